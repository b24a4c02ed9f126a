"""The stable orbits of a response at given values of its parameter, and at other parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.branches.branch import Branch
from slipfold.branches.response import trace_response
from slipfold.branches.settings import Settings
from slipfold.branches.start import measured_over
from slipfold.continuation.interpolation import polynomial
from slipfold.errors import BREAKDOWNS, InputError
from slipfold.models.model import Model
from slipfold.orbits.continued import hold_parameter
from slipfold.orbits.extrema import find_extrema
from slipfold.orbits.find import periodic_orbit
from slipfold.orbits.kinds import ForcedOrbits
from slipfold.orbits.orbit_batch import correct_orbits
from slipfold.parameter_space.measurement import Quantity, read_off
from slipfold.text import outside

FINE = 65
"""Arclengths between two points of a branch at which the parameter is interpolated."""

CLOSE = 1e-9
"""A correction shorter than this is the last: readings are then exact to rounding."""

MARGIN = 0.02
"""Fraction of the span by which branches are followed beyond it, so that its ends lie inside."""

SAME_STATE = 1e-6
"""Relative difference of states of the same orbit."""

SAME = 1e-7
"""Relative difference of readings of the same orbit."""


@dataclass(frozen=True, eq=False)
class StableOrbit:
    """A stable orbit at a value of the parameter, with its measured quantities."""

    value: float
    period: int
    nodes: Array  # shape (m, n)
    read: Array  # shape (q,)


def stable_orbits(
    model: Model, vary: str, values: Array, quantities: Sequence[Quantity]
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
    found: dict[float, list[StableOrbit]] = {float(value): [] for value in distinct}
    for branch in _from_both_ends(model, vary, span):
        if branch.interrupted:  # the orbits would not be complete
            raise KeyboardInterrupt
        for orbit in _stable_on(branch, distinct, quantities):
            known = found[orbit.value]
            if not any(_same(orbit, other) for other in known):
                known.append(orbit)
    return [found[float(value)] for value in values]


def _from_both_ends(model: Model, vary: str, span: tuple[float, float]) -> list[Branch]:
    """Return the branches of the response, and those of another one at the far end of a span.

    The first may leave the span before its fold, and then does not lead to the lower branch.
    """
    branches = [*trace_response(model, vary, span, settings=Settings())]
    try:
        far = periodic_orbit(model.replace(**{vary: span[1]}))
    except (InputError, *BREAKDOWNS):
        return branches
    there = [nodes[0] for item in branches for nodes in item.nodes[item.parameter == span[1]]]
    size = np.abs(far.nodes).max(axis=0)
    if any((np.abs(state - far.nodes[0]) <= SAME_STATE * size).all() for state in there):
        return branches
    try:
        return [*branches, *trace_response(model, vary, span[::-1], settings=Settings())]
    except (InputError, *BREAKDOWNS):
        return branches


def _span(model: Model, vary: str, low: float, high: float) -> tuple[float, float]:
    """Return a span about values of a parameter, as far as its bounds allow."""
    parameter = model.parameter(vary)
    margin = MARGIN * ((high - low) or abs(high) or 1.0)
    ends = []
    for end, wider in ((low, low - margin), (high, high + margin)):
        try:
            model.replace(**{vary: wider})
            ends.append(wider)
        except InputError:
            ends.append(parameter.check(end))
    return ends[0], ends[1]


def _same(one: StableOrbit, other: StableOrbit) -> bool:
    size = np.abs(one.read) + np.abs(other.read)
    return bool((np.abs(one.read - other.read) <= SAME * size).all())


def _stable_on(branch: Branch, values: Array, quantities: Sequence[Quantity]) -> list[StableOrbit]:
    """Return the stable orbits of a branch at given values of its parameter."""
    line = _line_of(branch)
    arclengths = [(value, place) for value in values for place in _arclengths(line, float(value))]
    if not arclengths:
        return []
    guesses = np.array([_between(line, place) for _, place in arclengths])
    at = np.array([value for value, _ in arclengths])
    nodes, read, stable = orbits_at(
        branch.model, branch.vary, branch.period, guesses, at, quantities
    )
    return [
        StableOrbit(float(at[row]), branch.period, nodes[row], read[row])
        for row in np.flatnonzero(stable)
    ]


def orbits_at(
    model: Model,
    vary: str,
    period: int,
    guesses: Array,
    values: Array,
    quantities: Sequence[Quantity],
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return orbits near guesses at values of a parameter, their readings, and which are stable.

    Those that are not found are NaN, and not stable.

    Shapes: guesses (k, m, n), values (k,); returns (k, m, n), (k, q), (k,).
    """
    width = float(np.ptp(values)) or abs(float(values[0])) or 1.0
    orbits = ForcedOrbits(model, {vary: width}, period, guesses.shape[1])
    z = np.array([orbits.pack(*item) for item in zip(guesses, values, strict=True)])
    rows = np.tile(hold_parameter(orbits.size), (len(z), 1))
    corrected = correct_orbits(orbits, z, rows, CLOSE)
    there = np.flatnonzero(corrected.found)
    nodes = np.full(guesses.shape, np.nan)
    read = np.full((len(z), len(quantities)), np.nan)
    stable = np.zeros(len(z), dtype=bool)
    if len(there):
        nodes[there] = [orbits.nodes(item) for item in corrected.z[there]]
        stable[there] = ~outside(corrected.multipliers[there]).any(axis=1)
        vectors = np.tile(model.vector, (len(there), 1))
        vectors[:, model.parameter_index(vary)] = values[there]
        names = list(dict.fromkeys(item.output for item in quantities))
        read[there] = read_off(
            find_extrema(model, vectors, nodes[there], period, names), quantities
        )
    return nodes, read, stable


@dataclass(frozen=True, eq=False)
class _Line:
    """The orbits of a branch in order, folds among them: between two there is no fold."""

    arclength: Array  # shape (k,)
    parameter: Array  # shape (k,)
    nodes: Array  # shape (k, m, n)
    slips: NDArray[np.bool_]  # whether contacts slip all the time, shape (k,)

    def near(self, first: int) -> slice:
        """Return the four orbits about an interval."""
        begin = max(min(first - 1, len(self.arclength) - 4), 0)
        return slice(begin, begin + 4)


def _line_of(branch: Branch) -> _Line:
    forced = branch.kind == "periodic" and branch.durations is None
    stuck = np.zeros(len(branch)) if branch.stuck_fraction is None else branch.stuck_fraction
    folds = [
        item
        for item in branch.special
        if item.type == "LP" and item.nodes.shape == branch.nodes.shape[1:]
    ]
    arclength = np.append(branch.arclength, [item.arclength for item in folds])
    order = np.argsort(arclength, kind="stable")
    order = order[np.append(True, np.diff(arclength[order]) > 0)]
    slips = np.append(~(np.nan_to_num(stuck) > 0), np.ones(len(folds), dtype=bool)) & forced
    return _Line(
        arclength[order],
        np.append(branch.parameter, [item.value for item in folds])[order],
        np.concatenate([branch.nodes, *(item.nodes[None] for item in folds)])[order],
        slips[order],
    )


def _arclengths(line: _Line, value: float) -> list[float]:
    """Return the arclengths at which orbits that slip have a value of the parameter."""
    found = []
    for first in np.flatnonzero(line.slips[:-1] & line.slips[1:]).tolist():
        ends = line.parameter[first : first + 2] - value
        if ends[0] * ends[1] > 0 or (ends[1] == 0 and first + 2 < len(line.parameter)):
            continue
        near = line.near(first)
        low, high = line.arclength[first : first + 2].tolist()
        fine = np.linspace(low, high, FINE)
        along = polynomial(line.arclength[near], line.parameter[near], fine) - value
        along[[0, -1]] = ends
        crossing = np.flatnonzero(along[:-1] * along[1:] <= 0)
        for place in crossing:
            step = along[place + 1] - along[place]
            share = 0.0 if step == 0 else -along[place] / step
            found.append(float(fine[place] + share * (fine[place + 1] - fine[place])))
    return found


def _between(line: _Line, place: float) -> Array:
    """Return the interpolated orbit at an arclength, shape (m, n)."""
    first = int(np.clip(np.searchsorted(line.arclength, place) - 1, 0, len(line.arclength) - 2))
    near = line.near(first)
    nodes = line.nodes[near]
    flat = polynomial(line.arclength[near], nodes.reshape(len(nodes), -1), np.array([place]))
    return np.asarray(flat[0]).reshape(nodes.shape[1:])
