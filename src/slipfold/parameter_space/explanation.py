"""Predictions of measured values, their sensitivities, and the orbits nearest to readings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.errors import BREAKDOWNS, InputError
from slipfold.models.model import Model
from slipfold.parameter_space.measurement import Measurement, Quantity
from slipfold.parameter_space.stable_orbits import StableOrbit, orbits_at, stable_orbits

STEP = 1e-4
"""Relative step of finite differences: orbits are known to 1e-12, and central differences then to
about 1e-8."""


ROUNDING = 1e-12
"""Relative difference of readings below which they are equal."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """Orbits of a model at some values of its parameters, one for each reading."""

    model: Model
    vary: str
    quantities: tuple[Quantity, ...]
    orbits: tuple[StableOrbit, ...]

    @property
    def read(self) -> Array:
        """Measured quantities of each, shape (k, q)."""
        return np.array([orbit.read for orbit in self.orbits]).reshape(-1, len(self.quantities))

    def moved(self, model: Model) -> Prediction | None:
        """Return the same orbits at other parameters; None if one is lost or not stable."""
        found = self._corrected(model)
        if not all(np.isfinite(orbit.read).all() for orbit in found):
            return None
        return replace(self, model=model, orbits=tuple(found))

    def read_at(self, model: Model) -> Array:
        """Return the measured quantities of the same orbits at other parameters; NaN if lost."""
        return replace(self, orbits=tuple(self._corrected(model))).read

    def _corrected(self, model: Model) -> list[StableOrbit]:
        """Return the same orbits at other parameters, NaN where they are lost or not stable."""
        found = list(self.orbits)
        for rows in _alike(self.orbits):
            chosen = [self.orbits[row] for row in rows]
            guesses = np.array([orbit.nodes for orbit in chosen])
            values = np.array([orbit.value for orbit in chosen])
            try:
                nodes, read, stable = orbits_at(
                    model, self.vary, chosen[0].period, guesses, values, self.quantities
                )
                read[~stable] = np.nan
            except BREAKDOWNS:
                nodes, read = guesses, np.full((len(rows), len(self.quantities)), np.nan)
            for row, orbit, *new in zip(rows, chosen, nodes, read, strict=True):
                found[row] = replace(orbit, nodes=new[0], read=new[1])
        return found


def _alike(orbits: Sequence[StableOrbit]) -> list[list[int]]:
    """Return numbers of orbits that are corrected in one batch: of one period and shape."""
    groups: dict[tuple[int, int], list[int]] = {}
    for row, orbit in enumerate(orbits):
        groups.setdefault((orbit.period, len(orbit.nodes)), []).append(row)
    return list(groups.values())


def sensitivities(prediction: Prediction, names: Sequence[str], sizes: Array) -> Array:
    """Return the derivatives of predictions with respect to parameters.

    NaN where an orbit is lost on both sides; one-sided where it is lost on one, as near a fold.
    Shapes: sizes (p,); returns (k, q, p).
    """
    model, here = prediction.model, prediction.read
    found = np.full((*here.shape, len(names)), np.nan)
    for column, (name, size) in enumerate(zip(names, sizes, strict=True)):
        step = STEP * size
        ends = []
        for way in (-1, 1):
            try:
                changed = model.replace(**{name: model.values[name] + way * step})
            except InputError:  # beyond the bounds of the parameter
                ends.append(np.full_like(here, np.nan))
            else:
                ends.append(prediction.read_at(changed))
        sides = [(here - ends[0]) / step, (ends[1] - here) / step]
        known = np.isfinite(sides)
        total = np.where(known, sides, 0.0).sum(axis=0)
        total[np.abs(total) * step <= ROUNDING * np.abs(here)] = 0.0
        with np.errstate(invalid="ignore"):
            found[..., column] = total / np.where(known.any(axis=0), known.sum(axis=0), np.nan)
    return found


Truth = NDArray[np.bool_]

FAR = 6.0
"""Distance, in typical ones, beyond which a reading is excluded: it lies on the other side of a
jump of the model, or belongs to another response. An excluded reading contributes as much as one at
this distance, so that excluding readings never decreases the sum."""

TYPICAL = 1.4826
"""Standard deviation over the median of absolute values, of the normal distribution."""

MINIMUM = 1e-6
"""Minimum of the typical distance, in ranges of the readings: simulated ones agree to rounding."""


@dataclass(frozen=True, eq=False)
class Readings:
    """Readings with their weights, and the parameters that are fitted to them."""

    measurement: Measurement
    bounds: Mapping[str, tuple[float, float]]
    weights: Array  # one over the standard deviations, 0 where there is no reading, shape (m, q)
    known: bool  # whether the standard deviations are known; else weights are from ranges

    @classmethod
    def weighted(
        cls, measurement: Measurement, bounds: Mapping[str, tuple[float, float]]
    ) -> Readings:
        """Return readings with weights from their standard deviations.

        If these are not known, they are the same fraction of each quantity's range.
        """
        readings, errors = measurement.readings, measurement.errors
        there = np.isfinite(readings)
        given = np.isfinite(errors) & there
        if given.any() and not (given == there).all():
            raise InputError(
                f"{given.sum()} of {there.sum()} readings have an error; give one for each, or none"
            )
        if not given.any():
            ranges = np.nanmax(readings, axis=0) - np.nanmin(readings, axis=0)
            ranges = np.where(ranges > 0, ranges, np.nanmax(np.abs(readings), axis=0))
            errors = np.broadcast_to(np.where(ranges > 0, ranges, 1.0), readings.shape)
        weights = np.where(there, 1 / np.where(there, errors, 1.0), 0.0)
        return cls(measurement, bounds, weights, bool(given.any()))

    @property
    def counts(self) -> NDArray[np.int64]:
        """Number of readings in each row, shape (m,)."""
        return np.asarray((self.weights > 0).sum(axis=1))

    def explained(self, model: Model, before: Explanation | None = None) -> Explanation:
        """Return the nearest stable orbits of a model, whose response is followed again.

        The orbits of an explanation `before`, at the same parameters, are candidates too: they may
        lie on branches that are not connected to the response.
        """
        measured = self.measurement
        candidates = stable_orbits(model, measured.vary, measured.values, measured.quantities)
        held = (None,) * len(measured) if before is None else before.orbits
        chosen: list[StableOrbit | None] = []
        for row, orbits in enumerate(candidates):
            known = [*orbits, *([] if held[row] is None else [held[row]])]
            away = [self._distance(row, orbit) for orbit in known]
            chosen.append(known[int(np.argmin(away))] if known else None)
        return self.by(model, tuple(chosen))

    def by(self, model: Model, orbits: tuple[StableOrbit | None, ...]) -> Explanation:
        """Return the explanation by given orbits, one for each row."""
        away = [self._distance(row, orbit) for row, orbit in enumerate(orbits)]
        return Explanation(self, model, orbits, np.array(away))

    def _distance(self, row: int, orbit: StableOrbit | None) -> float:
        """Return the root mean square of the weighted residuals of a row."""
        there = self.weights[row] > 0
        if orbit is None or not there.any():
            return np.inf
        away = (orbit.read - self.measurement.readings[row]) * self.weights[row]
        return float(np.sqrt(np.mean(away[there] ** 2)))


@dataclass(frozen=True, eq=False)
class Explanation:
    """Stable orbits of a model, one for each row, that are nearest to the readings."""

    readings: Readings
    model: Model
    orbits: tuple[StableOrbit | None, ...]
    distances: Array  # weighted, infinite where there is no orbit or no reading, shape (m,)

    @property
    def values(self) -> Array:
        """Values of the parameters that are fitted, shape (p,)."""
        return np.array([self.model.values[name] for name in self.readings.bounds])

    @property
    def scale(self) -> float:
        """Typical distance of a row."""
        there = np.isfinite(self.distances)
        typical = TYPICAL * float(np.median(self.distances[there])) if there.any() else np.inf
        return max(typical, 1.0 if self.readings.known else MINIMUM)

    def used(self, scale: float) -> Truth:
        """Return which rows are explained, shape (m,)."""
        return np.asarray(self.distances <= FAR * min(scale, 1e300))

    def cost(self, scale: float) -> float:
        """Return the sum of squares; an excluded row counts as one at the maximum distance."""
        counts = self.readings.counts
        away = np.minimum(self.distances[counts > 0], FAR * scale)
        return float(counts[counts > 0] @ away**2)

    def prediction(self, rows: Truth) -> Prediction:
        """Return the predictions for a subset of rows, each of which has an orbit."""
        measured = self.readings.measurement
        chosen = zip(self.orbits, rows, strict=True)
        orbits = tuple(orbit for orbit, uses in chosen if uses and orbit is not None)
        return Prediction(self.model, measured.vary, measured.quantities, orbits)

    def moved(self, changes: Mapping[str, float], rows: Truth) -> Explanation | None:
        """Return a subset of rows with the same orbits at other parameters; None if one is lost."""
        try:
            model = self.model.replace(**changes)
        except InputError:  # beyond what the model allows
            return None
        moved = self.prediction(rows).moved(model)
        if moved is None:
            return None
        left = iter(moved.orbits)
        return self.readings.by(model, tuple(next(left) if uses else None for uses in rows))

    def residuals(self, rows: Truth) -> Array:
        """Return the weighted residuals of the readings in a subset of rows."""
        weights = self.readings.weights[rows]
        away = self.prediction(rows).read - self.readings.measurement.readings[rows]
        return np.asarray((away * weights)[weights > 0])

    def slopes(self, names: tuple[str, ...], rows: Truth) -> Array:
        """Return the derivatives of these residuals by parameters, NaN where orbits are lost."""
        weights = self.readings.weights[rows]
        sizes = np.array([np.ptp(self.readings.bounds[name]) for name in names])
        found = sensitivities(self.prediction(rows), names, sizes) * weights[:, :, None]
        return np.asarray(found[weights > 0])

    def reasons(self, scale: float) -> tuple[str, ...]:
        """Return why each row is excluded, empty where it is not."""
        unit = "standard deviations" if self.readings.known else "typical distances"
        size = 1.0 if self.readings.known else scale
        said = []
        for away, orbit, count, uses in zip(
            self.distances, self.orbits, self.readings.counts, self.used(scale), strict=True
        ):
            if uses:
                said.append("")
            elif count == 0:
                said.append("nothing was read")
            elif orbit is None:
                said.append("no response is stable there")
            else:
                said.append(f"the nearest stable response is {away / size:.3g} {unit} away")
        return tuple(said)
