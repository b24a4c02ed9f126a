"""The stable orbits that explain a measurement, and how far it lies from them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array, Indices, Mask
from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.parameter_space.measurement import Measurement
from slipfold.parameter_space.stable_orbits import (
    Prediction,
    StableOrbit,
    sensitivities,
    stable_orbits,
)


class LIMITS:
    """Limits and tolerances of a fit."""

    confidence: float = 0.95
    # Distance, in typical ones, beyond which a row is excluded: it lies on the other side of a jump
    # of the model, or belongs to another response. It then contributes as much as one at this
    # distance, so that excluding rows never decreases the sum of squares.
    far: float = 6.0
    # Minimum of the typical distance, over the ranges of measured values, that simulated ones have
    smallest: float = 1e-6
    exact: float = 1e-9  # typical residual, over these ranges, of orbits without errors
    close: float = 1e-11  # change of the parameters, over their bounds, at which a fit ends
    # Relative decrease of the sum of squares that counts: far below the accuracy of intervals
    decrease: float = 1e-6
    # Relative difference of sums of squares in the same minimum. Where orbits vanish, steps that
    # gain less end the search: trust regions shrink fourfold each time that an orbit is lost.
    same: float = 1e-3
    starts: int = 8  # further initial values: where responses jump, there are several minima
    # Fits from the best of these if they explain the measurements; else until as many agree
    agreeing: int = 3
    unlikely: float = 1e-3  # probability of so large a sum below which rows are not explained
    # Error of an end of an interval where orbits vanish, over its distance from the fitted value;
    # decrease of the sum of squares, over its growth at the ends, that makes another fit better
    profile: float = 1e-2
    # Growth of the sum of squares, over that at the ends, at which a parabola gives the end with
    # about the square of the remaining error
    reached: float = 0.96
    wider: float = 1.5  # interval over that of the linearized model, from which errors mislead
    rounds: int = 12  # maximum number of times that orbits are assigned to rows again
    iterations: int = 60  # maximum number of steps of a search, and of points of a profile
    listed: int = 5  # maximum number of excluded rows that are named


@dataclass(frozen=True, eq=False)
class Weighted:
    """A measurement with its weights, and the parameters that are fitted to it."""

    measurement: Measurement
    bounds: Mapping[str, tuple[float, float]]
    weights: Array  # one over the standard deviations, 0 where nothing was read, shape (m, q)
    known: bool  # whether the standard deviations are known; else weights are from ranges

    @classmethod
    def from_measurement(
        cls, measurement: Measurement, bounds: Mapping[str, tuple[float, float]]
    ) -> Weighted:
        """Return a measurement with weights from its standard deviations.

        If these are not known, they are the same fraction of each quantity's range.
        """
        measurements, errors = measurement.measured, measurement.errors
        there = np.isfinite(measurements)
        given = np.isfinite(errors) & there
        if (count := there.sum()) <= len(bounds):
            raise InputError(f"{count} measurements are too few for {len(bounds)} parameters")
        if given.any() and not (given == there).all():
            raise InputError(
                f"{given.sum()} of {there.sum()} measurements have an error; give all or none"
            )
        if not given.any():
            ranges = np.nanmax(measurements, axis=0) - np.nanmin(measurements, axis=0)
            ranges = np.where(ranges > 0, ranges, np.nanmax(np.abs(measurements), axis=0))
            errors = np.broadcast_to(np.where(ranges > 0, ranges, 1.0), measurements.shape)
        weights = np.where(there, 1 / np.where(there, errors, 1.0), 0.0)
        return cls(measurement, bounds, weights, bool(given.any()))

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters that are fitted."""
        return tuple(self.bounds)

    @property
    def ends(self) -> Array:
        """Lower and upper bounds of the parameters, shape (2, p)."""
        return np.array(list(self.bounds.values())).T

    @property
    def counts(self) -> Indices:
        """Number of measured values in each row, shape (m,)."""
        return np.asarray((self.weights > 0).sum(axis=1))

    def explained(self, model: Model, before: Explanation | None = None) -> Explanation:
        """Return the nearest stable orbits of a model, whose response is followed again.

        The orbits of an explanation `before`, at the same parameters, are candidates too: they may
        lie on branches that are not connected to the response.
        """
        measured = self.measurement
        candidates = stable_orbits(model, measured.vary, measured.values, measured.quantities)
        chosen: list[StableOrbit | None] = []
        for row, orbits in enumerate(candidates):
            held = None if before is None else before.orbits[row]
            known = [*orbits, *([] if held is None else [held])]
            away = [self._distance(row, orbit) for orbit in known]
            chosen.append(known[int(np.argmin(away))] if known else None)
        return self.by(model, chosen)

    def by(self, model: Model, orbits: Sequence[StableOrbit | None]) -> Explanation:
        """Return the explanation by given orbits, one for each row."""
        away = [self._distance(row, orbit) for row, orbit in enumerate(orbits)]
        return Explanation(self, model, tuple(orbits), np.array(away))

    def _distance(self, row: int, orbit: StableOrbit | None) -> float:
        """Return the root mean square of the weighted residuals of a row."""
        there = self.weights[row] > 0
        if orbit is None or not there.any():
            return np.inf
        away = (orbit.predicted - self.measurement.measured[row]) * self.weights[row]
        return float(np.sqrt(np.mean(away[there] ** 2)))


@dataclass(frozen=True, eq=False)
class Explanation:
    """Stable orbits of a model, one for each row, that are nearest to the measured values."""

    measured: Weighted
    model: Model
    orbits: tuple[StableOrbit | None, ...]
    distances: Array  # weighted, infinite where there is no orbit or nothing was read, shape (m,)

    @property
    def values(self) -> Array:
        """Values of the parameters that are fitted, shape (p,)."""
        return np.array([self.model.values[name] for name in self.measured.names])

    @property
    def scale(self) -> float:
        """Typical distance of a row: a robust standard deviation, from the median."""
        there = np.isfinite(self.distances)
        typical = 1.4826 * float(np.median(self.distances[there])) if there.any() else np.inf
        return max(typical, 1.0 if self.measured.known else LIMITS.smallest)

    def used(self, scale: float) -> Mask:
        """Return which rows are explained, shape (m,)."""
        return np.asarray(self.distances <= LIMITS.far * min(scale, 1e300))

    def cost(self, scale: float) -> float:
        """Return the sum of squares; an excluded row counts as one at the maximum distance."""
        counts = self.measured.counts
        away = np.minimum(self.distances[counts > 0], LIMITS.far * scale)
        return float(counts[counts > 0] @ away**2)

    def prediction(self, rows: Mask) -> Prediction:
        """Return the predictions for a subset of rows, each of which has an orbit."""
        measured = self.measured.measurement
        chosen = zip(self.orbits, rows, strict=True)
        orbits = tuple(orbit for orbit, uses in chosen if uses and orbit is not None)
        return Prediction(self.model, measured.vary, measured.quantities, orbits)

    def moved(self, names: Sequence[str], values: Array, rows: Mask) -> Explanation | None:
        """Return a subset of rows with the same orbits at other parameters; None if one is lost."""
        try:
            model = self.model.replace(**dict(zip(names, values.tolist(), strict=True)))
        except InputError:  # beyond what the model allows
            return None
        moved = self.prediction(rows).moved(model)
        if moved is None:
            return None
        left = iter(moved.orbits)
        return self.measured.by(model, [next(left) if uses else None for uses in rows])

    def residuals(self, rows: Mask) -> Array:
        """Return the weighted residuals of the measured values in a subset of rows."""
        weights = self.measured.weights[rows]
        away = self.prediction(rows).predicted - self.measured.measurement.measured[rows]
        return np.asarray((away * weights)[weights > 0])

    def slopes(self, names: tuple[str, ...], rows: Mask) -> Array:
        """Return the derivatives of these residuals by parameters, NaN where orbits are lost."""
        weights = self.measured.weights[rows]
        sizes = np.array([np.ptp(self.measured.bounds[name]) for name in names])
        slopes = sensitivities(self.prediction(rows), names, sizes) * weights[:, :, None]
        return np.asarray(slopes[weights > 0])

    def excluded(self, scale: float) -> list[str]:
        """Return which rows are excluded, and why."""
        seen, known = self.measured.measurement, self.measured.known
        unit = "standard deviations" if known else "typical distances"
        rows = []
        for row in np.flatnonzero(~self.used(scale)).tolist():
            if self.measured.counts[row] == 0:
                reason = "nothing was read"
            elif self.orbits[row] is None:
                reason = "no response is stable there"
            else:
                away = self.distances[row] / (1.0 if known else scale)
                reason = f"the nearest stable response is {away:.3g} {unit} away"
            at = f"{seen.vary} = {seen.values[row]:.6g} {seen.unit}".rstrip()
            rows.append(f"row {row + 1} ({at}: {reason})")
        return rows
