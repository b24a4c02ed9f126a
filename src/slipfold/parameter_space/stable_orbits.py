"""Stable orbits of a response at given parameter values: predictions, sensitivities and plans."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.orbit_between import orbit_between, passes
from slipfold.bifurcations.branches.response import trace_response
from slipfold.bifurcations.branches.settings import Settings
from slipfold.bifurcations.branches.start import measured_over
from slipfold.errors import BREAKDOWNS, InputError
from slipfold.models.model import Model
from slipfold.orbits.continued import hold_parameter
from slipfold.orbits.extrema import find_extrema
from slipfold.orbits.find import periodic_orbit
from slipfold.orbits.kinds import ForcedOrbits
from slipfold.orbits.orbit_batch import correct_orbits
from slipfold.parameter_space.measurement import Quantity, read_off
from slipfold.text import outside


class PREDICTION:
    """Accuracies of predicted measurements and their derivatives."""

    # Fraction of the span by which branches are followed beyond it, so that its ends lie inside
    margin: float = 0.02
    # A correction shorter than this is the last: measured quantities are then exact to rounding
    close: float = 1e-9
    # Relative difference of measured quantities, or states, of the same orbit
    same: float = 1e-7
    # Relative step of finite differences: orbits are known to 1e-12, and central differences then
    # to about 1e-8
    step: float = 1e-4
    # Relative difference of measured quantities below which they are equal
    rounding: float = 1e-12
    # Singular value of the scaled derivatives, over the largest or the measurements' error, below
    # which the measurements do not determine a combination of parameters: ten times the error of
    # derivatives by differences, so that what counts as known has a digit
    blind: float = 1e-7


@dataclass(frozen=True, eq=False)
class StableOrbit:
    """A stable orbit at a value of the parameter, with its measured quantities."""

    value: float
    period: int
    nodes: Array  # shape (m, n)
    predicted: Array  # shape (q,)

    def is_same(self, other: StableOrbit) -> bool:
        """Whether another orbit has the same measured quantities."""
        size = np.abs(self.predicted) + np.abs(other.predicted)
        return bool((np.abs(self.predicted - other.predicted) <= PREDICTION.same * size).all())


def stable_orbits(
    model: Model, vary: str, values: Array, quantities: tuple[Quantity, ...]
) -> list[list[StableOrbit]]:
    """Return the stable orbits of the response at given values of its parameter.

    Orbits that stick are excluded. Shapes: values (k,).
    """
    if not model.forced:
        raise InputError(
            f"{model.name} has no forcing, so that no response is measured over a parameter; give "
            "a forced model"
        )
    distinct = np.unique(values)
    span = _span(model, vary, float(distinct[0]), float(distinct[-1]))
    model = measured_over(model, vary, span)
    result: dict[float, list[StableOrbit]] = {float(value): [] for value in distinct}
    for branch in _from_both_ends(model, vary, span):
        if branch.interrupted:  # the orbits would not be complete
            raise KeyboardInterrupt
        for orbit in _stable_on(branch, distinct, quantities):
            if not any(orbit.is_same(other) for other in result[orbit.value]):
                result[orbit.value].append(orbit)
    return [result[float(value)] for value in values]


def _span(model: Model, vary: str, low: float, high: float) -> tuple[float, float]:
    """Return a span about values of a parameter, as far as its bounds allow."""
    margin = PREDICTION.margin * ((high - low) or abs(high) or 1.0)
    ends = []
    for end, wider in ((low, low - margin), (high, high + margin)):
        try:
            model.replace(**{vary: wider})
            ends.append(wider)
        except InputError:
            ends.append(model.parameter(vary).check(end))
    return ends[0], ends[1]


def _from_both_ends(model: Model, vary: str, span: tuple[float, float]) -> list[Branch]:
    """Return the branches of the response, and those of another one at the far end of a span.

    The first may leave the span before its fold, and then does not lead to the lower branch.
    """
    branches = [*trace_response(model, vary, span, settings=Settings())]
    try:
        far = periodic_orbit(model.replace(**{vary: span[1]}))
        size = np.abs(far.nodes).max(axis=0)
        there = [nodes[0] for item in branches for nodes in item.nodes[item.parameter == span[1]]]
        if any((np.abs(state - far.nodes[0]) <= PREDICTION.same * size).all() for state in there):
            return branches
        return [*branches, *trace_response(model, vary, span[::-1], settings=Settings())]
    except BREAKDOWNS:
        return branches


def _stable_on(
    branch: Branch, values: Array, quantities: tuple[Quantity, ...]
) -> list[StableOrbit]:
    """Return the stable orbits of a branch at values of its parameter, but those that stick."""
    if branch.kind != "periodic" or branch.durations is not None:
        return []
    guesses = list[StableOrbit]()
    for value in values.tolist():
        for place, before, after, part in passes(branch, value):
            if before.sticking or after.sticking:
                continue
            nodes = before.nodes
            if nodes.shape == after.nodes.shape:
                nodes = (1 - part) * nodes + part * after.nodes
            else:  # special points keep their own number of nodes
                with suppress(*BREAKDOWNS):
                    nodes = orbit_between(branch, place, value).nodes
            guesses.append(StableOrbit(value, branch.period, nodes, np.empty(0)))
    known = Prediction(branch.model, branch.vary, quantities, tuple(guesses))
    found = known.corrected(branch.model)
    return [orbit for orbit in found if orbit is not None]


def _stable_near(
    model: Model,
    vary: str,
    period: int,
    guesses: Array,
    values: Array,
    quantities: Sequence[Quantity],
) -> list[StableOrbit | None]:
    """Return the stable orbits near guesses at values of a parameter, None where none is found.

    Shapes: guesses (k, m, n), values (k,).
    """
    width = float(np.ptp(values)) or abs(float(values[0])) or 1.0
    orbits = ForcedOrbits(model, {vary: width}, period, guesses.shape[1])
    z = np.array([orbits.join(*item) for item in zip(guesses, values, strict=True)])
    rows = np.tile(hold_parameter(orbits.size), (len(z), 1))
    corrected = correct_orbits(orbits, z, rows, PREDICTION.close)
    result: list[StableOrbit | None] = [None] * len(z)
    there = np.flatnonzero(corrected.found)
    there = there[~outside(corrected.multipliers[there]).any(axis=1)]
    if len(there):
        nodes = np.array([orbits.nodes(item) for item in corrected.z[there]])
        vectors = np.tile(model.vector, (len(there), 1))
        vectors[:, model.parameter_index(vary)] = values[there]
        names = list(dict.fromkeys(item.output for item in quantities))
        read = read_off(find_extrema(model, vectors, nodes, period, names), quantities)
        for row, *own in zip(there.tolist(), nodes, read, strict=True):
            result[row] = StableOrbit(float(values[row]), period, own[0], own[1])
    return result


# -- predictions -----------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Prediction:
    """Orbits of a model at some values of its parameter, one for each measurement."""

    model: Model
    vary: str
    quantities: tuple[Quantity, ...]
    orbits: tuple[StableOrbit, ...]

    @property
    def predicted(self) -> Array:
        """Measured quantities of each, shape (k, q)."""
        return np.array([orbit.predicted for orbit in self.orbits]).reshape(
            -1, len(self.quantities)
        )

    def moved(self, model: Model) -> Prediction | None:
        """Return the same orbits at other parameters; None if one is lost or not stable."""
        result = [orbit for orbit in self.corrected(model) if orbit is not None]
        if len(result) < len(self.orbits):
            return None
        return replace(self, model=model, orbits=tuple(result))

    def read_at(self, model: Model) -> Array:
        """Return the measured quantities of the same orbits at other parameters; NaN if lost."""
        lost = np.full(len(self.quantities), np.nan)
        orbits = self.corrected(model)
        return np.array([lost if orbit is None else orbit.predicted for orbit in orbits])

    def corrected(self, model: Model) -> list[StableOrbit | None]:
        """Return the same orbits at other parameters, None where they are lost or not stable."""
        batches: dict[tuple[int, int], list[int]] = {}
        for row, orbit in enumerate(self.orbits):
            batches.setdefault((orbit.period, len(orbit.nodes)), []).append(row)
        result: list[StableOrbit | None] = [None] * len(self.orbits)
        for (period, _), rows in batches.items():
            guesses = np.array([self.orbits[row].nodes for row in rows])
            values = np.array([self.orbits[row].value for row in rows])
            try:
                moved = _stable_near(model, self.vary, period, guesses, values, self.quantities)
            except BREAKDOWNS:
                continue
            for row, corrected in zip(rows, moved, strict=True):
                result[row] = corrected
        return result


def sensitivities(prediction: Prediction, names: Sequence[str], sizes: Array) -> Array:
    """Return the derivatives of predictions with respect to parameters.

    NaN where an orbit is lost on both sides; one-sided where it is lost on one, as near a fold.
    Shapes: sizes (p,); returns (k, q, p).
    """
    model, here = prediction.model, prediction.predicted
    result = np.full((*here.shape, len(names)), np.nan)
    for column, (name, size) in enumerate(zip(names, sizes, strict=True)):
        step, sides = PREDICTION.step * size, []
        for way in (-1, 1):
            try:
                changed = model.replace(**{name: model.values[name] + way * step})
            except InputError:  # beyond the bounds of the parameter
                sides.append(np.full_like(here, np.nan))
            else:
                sides.append((prediction.read_at(changed) - here) / (way * step))
        known = np.isfinite(sides)
        total = np.where(known, sides, 0.0).sum(axis=0)
        total[np.abs(total) * step <= PREDICTION.rounding * np.abs(here)] = 0.0
        with np.errstate(invalid="ignore"):
            result[..., column] = total / np.where(known.any(axis=0), known.sum(axis=0), np.nan)
    return result


# -- plans of measurements -------------------------------------------------------------------------


def covariance_of(slopes: Array, sizes: Array) -> Array:
    """Return the covariance of parameters from the derivatives of measurements of unit error.

    Rows with NaN are left out. Infinite where measurements do not determine a parameter.
    Shapes: slopes (k, p), sizes (p,); returns (p, p).
    """
    finite = slopes[np.isfinite(slopes).all(axis=1)]
    _, singular, rows = np.linalg.svd(finite * sizes, full_matrices=True)
    sharp = np.zeros(len(sizes))
    sharp[: len(singular)] = singular
    known = sharp > PREDICTION.blind * max(sharp.max(), 1.0)
    covariance = (rows[known].T / sharp[known] ** 2) @ rows[known] * np.outer(sizes, sizes)
    blind = (np.abs(rows[~known]) > np.sqrt(PREDICTION.blind)).any(axis=0)
    covariance[blind] = covariance[:, blind] = np.nan
    covariance[blind, blind] = np.inf
    return np.asarray(covariance)


def plan(
    model: Model,
    vary: str,
    values: Array,
    quantities: tuple[Quantity, ...],
    names: Sequence[str],
    errors: Array,
) -> tuple[Array, Array]:
    """Predict measurements at values in their order, and their derivatives by parameters.

    Each belongs to the stable response nearest to the one before, in units of `errors`, as in a
    sweep; the first belongs to the one that is followed first from the response of period 1. NaN
    where no response is stable.

    Shapes: values (m,), errors (q,); returns (m, q), (m, q, p).
    """
    for name in names:
        if model.values[name] == 0:
            raise InputError(f"{name} = 0 has no size to compare with; give it a value above zero")
    there, chosen = list[int](), list[StableOrbit]()
    for row, orbits in enumerate(stable_orbits(model, vary, values, quantities)):
        if orbits:
            last = chosen[-1].predicted if chosen else orbits[0].predicted
            away = [float((np.abs(orbit.predicted - last) / errors).max()) for orbit in orbits]
            chosen.append(orbits[int(np.argmin(away))])
            there.append(row)
    if not there:
        raise InputError(
            f"no response is stable at the {len(values)} values of {vary} planned; plan others"
        )
    prediction = Prediction(model, vary, quantities, tuple(chosen))
    predicted = np.full((len(values), len(quantities)), np.nan)
    slopes = np.full((*predicted.shape, len(names)), np.nan)
    sizes = np.array([abs(model.values[name]) for name in names])
    predicted[there], slopes[there] = prediction.predicted, sensitivities(prediction, names, sizes)
    return predicted, slopes


def best_rows(scaled: Array, count: int) -> list[int]:
    """Return the rows that determine all parameters best together, `count` of them, in their order.

    One by one that row is taken which makes the determinant of the information matrix largest (a
    D-optimal design), then each is exchanged for a better one while there is one.

    Shapes: scaled (m, q, p), derivatives by scaled parameters over the errors of measurements.
    """
    parts = {row: item.T @ item for row, item in enumerate(scaled) if np.isfinite(item).all()}
    count = min(count, len(parts))
    # A little information beforehand, so that the first rows can be compared at all.
    prior = 1e-9 * max(np.trace(part) for part in parts.values()) * np.eye(scaled.shape[2])

    def best_next(chosen: Sequence[int]) -> int:
        known = prior + sum((parts[row] for row in chosen), np.zeros_like(prior))
        left = [row for row in parts if row not in chosen]
        return max(left, key=lambda row: float(np.linalg.slogdet(known + parts[row])[1]))

    chosen: list[int] = []
    for _ in range(count):
        chosen.append(best_next(chosen))
    for _ in range(10 * count):
        before = sorted(chosen)
        for place in range(count):
            chosen[place] = best_next(chosen[:place] + chosen[place + 1 :])
        if sorted(chosen) == before:
            break
    return sorted(chosen)
