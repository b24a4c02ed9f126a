"""Extrema of outputs over the continuous orbit, not over mesh points; revolutions of angles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.polynomial import polyval

from slipfold.arrays import Array, Indices, Mask
from slipfold.errors import index_of
from slipfold.flow.contact_trajectory import Samples, dense_phases
from slipfold.flow.equations import Constants, power_of_two
from slipfold.flow.flow import Flow, flow_of
from slipfold.flow.modes import Mode
from slipfold.flow.trajectory import Trajectory
from slipfold.models.angles import REVOLUTION, count_revolutions
from slipfold.models.model import Model
from slipfold.models.quantities import OutputName
from slipfold.read_only import Documented
from slipfold.text import OneLine, PrintedTable, listed, number_text


def revolutions_of_segments(
    model: Model, flow: Flow, nodes: Array, period: int, constants: Constants
) -> Array:
    """Return by how many revolutions segments of orbits end ahead of the next node.

    Shapes: nodes (k, m, n); returns (k, m, n), zero for what is no angle.
    """
    if not model.angle_periods.any():
        return np.zeros(nodes.shape)
    count, segments = nodes.shape[:2]
    edges = np.linspace(0, period, segments + 1)
    start, end = np.tile(edges[:-1], count), np.tile(edges[1:], count)
    ends = flow.advance(
        nodes.reshape(count * segments, -1), start, end, constants.repeated(segments)
    )
    return count_revolutions(
        ends.reshape(nodes.shape) - np.roll(nodes, -1, axis=1), model.angle_periods
    )


class PEAKS:
    """The search for extrema between samples."""

    # Samples of a forcing period: most extrema are then those of polynomials through them
    samples: int = 192
    zoom: int = 16  # samples of each closer look
    zooms: int = 2  # closer looks: the second resolves 1e-3 of a forcing period
    max_zooms: int = 10  # where a trajectory turns sharply: to a phase's last digits
    neighbors: int = 3  # samples to either side that a polynomial goes through: 1e-13 in value
    bend: float = 1e-4  # fraction of the value by which these may exceed the minimum
    # Sixth difference of samples, over the largest, up to which the polynomial through them is
    # taken: where friction is steep, its error is 5e-11 with 1e-9, and 6e-14 with this
    smooth: float = 1e-11
    # Difference of two local minima, each of a parabola through three samples, over the second
    # difference of these, within which either may be the lower one: with 27 samples from one
    # minimum to the next, parabolas are off by a thousandth of it
    near: float = 0.01
    jump: float = 1 / 8  # change between samples, over the range, that may hide a peak
    periods: int = 256  # examined of a trajectory that has not converged
    memory: int = 4_000_000  # numbers that are sampled at once: 32 MB
    dense: int = 1024  # samples of a forcing period of a motion with stick, which has corners
    still: float = 1e-6  # rates over scales of an equilibrium: those of a cycle are about one


AVERAGED = ("rms", "harmonic")
"""Measures of an output over an orbit that are means, beside those of its extrema."""

TOGETHER = 32
"""Orbits examined at once: they fill the lanes of the flow."""


@dataclass(frozen=True, eq=False, repr=False)
class Extrema(OneLine, Documented):
    """Minimum and maximum of every output, for one orbit or many.

    Parameters
    ----------
    names
        The outputs; states come first.
    minimum, maximum
        Shape (n_orbits, n_outputs), in the units of the outputs. An angle that revolves has all
        values, and the minimum and maximum -pi and pi.
    """

    names: tuple[str, ...]
    minimum: Array
    maximum: Array

    def __eq__(self, other: object) -> bool:
        """Whether all numbers are the same."""
        if not isinstance(other, Extrema):
            return NotImplemented
        return (
            self.names == other.names
            and np.array_equal(self.minimum, other.minimum, equal_nan=True)
            and np.array_equal(self.maximum, other.maximum, equal_nan=True)
        )

    __hash__ = None  # type: ignore[assignment]

    def _line(self) -> str:
        count = len(self.minimum)
        rows = self._ranges()
        shown = listed(f"{name} {low} to {high}" for name, low, high in rows)
        return f"Extrema of {count} orbit{'' if count == 1 else 's'}: {shown or 'no outputs'}"

    def _rows(self) -> PrintedTable:
        return PrintedTable(["", "minimum", "maximum"], self._ranges(), ("",))

    def _ranges(self) -> list[list[str]]:
        """Name, least and largest value of each output over all orbits."""
        if not len(self.minimum):
            return [[name, "", ""] for name in self.names]
        low, high = self.minimum.min(axis=0), self.maximum.max(axis=0)
        ends = zip(self.names, low, high, strict=True)
        return [[name, number_text(a), number_text(b)] for name, a, b in ends]

    def of(self, name: OutputName) -> tuple[Array, Array]:
        """Return minimum and maximum of one output, each of shape (n_orbits,)."""
        index = index_of(name, self.names, "output")
        return self.minimum[:, index], self.maximum[:, index]

    def peak_to_peak(self, name: OutputName) -> Array:
        """Return maximum less minimum of one output, shape (n_orbits,)."""
        low, high = self.of(name)
        return high - low

    def modulus(self, name: OutputName) -> Array:
        """Return the largest absolute value of one output, shape (n_orbits,)."""
        low, high = self.of(name)
        return np.maximum(np.abs(low), np.abs(high))

    def measured(self, measure: str, name: OutputName) -> Array:
        """Return a measure of one output, shape (n_orbits,).

        Parameters
        ----------
        measure
            ``"max"``, ``"min"``, ``"peak_to_peak"`` or ``"modulus"``.
        """
        if measure == "peak_to_peak":
            return self.peak_to_peak(name)
        if measure == "modulus":
            return self.modulus(name)
        low, high = self.of(name)
        return high if measure == "max" else low


@np.errstate(invalid="ignore")  # an output that is infinite somewhere has none there
def find_extrema(
    model: Model, parameters: Array, nodes: Array, period: int, names: Sequence[str] | None = None
) -> Extrema:
    """Find the extrema of outputs over orbits of one period.

    Shapes: parameters (n_orbits, n_parameters); nodes (n_orbits, m, n_states).
    """
    flow, scales = flow_of(model), power_of_two(model.state_scales())
    names = flow.output_names if names is None else tuple(names)
    columns = np.array([flow.output_index(name) for name in names])
    if nodes.shape[1] == 1 and not model.forced:
        constants, zero = flow.constants(parameters, scales), np.zeros(len(nodes))
        rates = np.abs(flow.rates(nodes[:, 0], zero, constants)) / scales
        if not np.any(rates > PEAKS.still):  # equilibria, also where rates are no numbers
            values = flow.outputs(nodes[:, 0], zero, constants)[:, columns]
            return Extrema(names, values, values.copy())
    low = np.empty((len(nodes), len(names)))
    high = np.empty_like(low)
    numbers = PEAKS.samples * period * (flow.dimension + len(flow.output_names))
    together = min(TOGETHER, max(1, PEAKS.memory // numbers))
    for first in range(0, len(nodes), together):
        some = slice(first, first + together)
        low[some], high[some] = _extrema_of_orbits(
            model, flow.constants(parameters[some], scales), nodes[some], period, columns
        )
    return Extrema(names, low, high)


def _extrema_of_orbits(
    model: Model, constants: Constants, nodes: Array, period: int, columns: Indices
) -> tuple[Array, Array]:
    """Extrema of some outputs over some orbits, each of shape (n_orbits, n_outputs)."""
    flow, (count, segments) = flow_of(model), nodes.shape[:2]
    edges = np.linspace(0, period, segments + 1)
    each = -(-PEAKS.samples * period // segments)
    # Neighbors in the lanes of the flow are the same part of all orbits: as many steps each.
    segment, orbit = (index.ravel() for index in np.indices((segments, count)))
    start, end = edges[segment], edges[segment + 1]
    samples = flow.sample(nodes[orbit, segment], start, end, each, constants.rows(orbit))
    samples = samples.reshape(segments, count, each, -1).swapaxes(0, 1)
    ahead = revolutions_of_segments(model, flow, nodes, period, constants)
    before = (np.cumsum(ahead, axis=1) - ahead) * model.angle_periods
    samples = (samples + before[:, :, None]).reshape(count * segments * each, -1)
    total = segments * each
    spacing = period / total
    phases = np.tile(np.arange(total, dtype=float) * spacing, count)
    alone = (columns < flow.dimension).all()  # the first outputs are the states
    values = samples if alone else flow.outputs(samples, phases, constants.repeated(total))
    values = values[:, columns].reshape(count, total, -1)
    side, column, orbit, at = _lowest(values)
    shape = 2, len(columns), count
    rows, signs = np.ravel_multi_index((side, column, orbit), shape), 1.0 - 2.0 * side
    beside = values[orbit[:, None], (at[:, None] + _PLACES) % total, column[:, None]]
    beside *= signs[:, None]
    found, rough = _least_between(beside), ~_is_smooth(beside)
    orbits, places = _jumps(values, spread := np.ptp(values, axis=1))
    rough |= (jumping := np.isin(orbit, orbits))
    column, orbit, at, signs = column[rough], orbit[rough], at[rough], signs[rough]
    earlier = orbit * total + (at - 1) % total
    states, start, width = samples[earlier], phases[earlier], np.full(len(orbit), spacing)
    if jumping.any():
        first, lowest = orbits * total + places, signs * values[orbit, at, column]
        _look_closer(
            *(flow, constants, orbits, (samples[first], phases[first]), spacing, columns),
            *(spread, (orbit, column, signs), (lowest, states, start, width)),
        )
    if rough.any():
        own = constants.rows(orbit)
        found[rough] = refine_minimum(flow, own, states, start, width, columns[column], signs)
    least = np.full(2 * len(columns) * count, np.inf)
    np.minimum.at(least, rows, found)  # what is no number at one of the minima stays none
    low, high = (least.reshape(shape) * [[[1.0]], [[-1.0]]]).swapaxes(1, 2)
    revolving = np.zeros((count, len(flow.output_names)), dtype=bool)
    revolving[:, : ahead.shape[2]] = ahead.sum(axis=1) != 0
    turning = revolving[:, columns]
    return np.where(turning, -REVOLUTION / 2, low), np.where(turning, REVOLUTION / 2, high)


def _lowest(values: Array) -> Indices:
    """Return where minima and maxima are sought: sides, outputs, orbits and samples, (4, q).

    Each has its lowest, or highest, sample. Other local extrema follow where the parabolas through
    them come near the lowest, so that each may be the global one. Shapes: values (n_orbits,
    n_samples, n_outputs).
    """
    count, _, outputs = values.shape
    column, orbit = (index.ravel() for index in np.indices((outputs, count)))
    closed = np.concatenate([values[:, -1:], values, values[:, :1]], axis=1)
    closed = np.ascontiguousarray(closed.swapaxes(1, 2))  # rows are searched many times as fast
    found = []
    for side in (0, 1):
        nearest = closed[:, :, 1:-1].argmin(axis=2)
        sides = np.full(nearest.size, side)
        found.append([sides, column, orbit, nearest[orbit, column]])
        middle = closed[:, :, 1:-1]
        lower = (closed[:, :, :-2] > middle) & (middle <= closed[:, :, 2:])
        own, other, at = lower.nonzero()
        before, middle, after = (closed[own, other, at + i] for i in range(3))
        bend = (before - middle) + (after - middle)  # no rounding makes this zero
        heights = middle - (after - before) ** 2 / (8 * bend)
        least = np.full((count, outputs), np.inf)
        np.minimum.at(least, (own, other), heights)
        near = heights <= least[own, other] + PEAKS.near * bend
        near &= at != nearest[own, other]
        more = np.full(np.count_nonzero(near), side)
        found.append([more, other[near], own[near], at[near]])
        np.negative(closed, out=closed)
    return np.concatenate(found, axis=1)


def _look_closer(
    flow: Flow,
    constants: Constants,
    orbits: Indices,
    begins: tuple[Array, Array],
    width: float,
    columns: Indices,
    spread: Array,
    sought: tuple[Indices, Indices, Array],
    best: tuple[Array, Array, Array, Array],
) -> None:
    """Look ever closer at where outputs jump, and improve the best samples of what is sought.

    A spike may be as short as 1e-10 of a period, so that samples lie on either side of it.
    Shapes: orbits (p,) of the pieces and their `begins`, states (p, n) and phases (p,); spread
    (n_orbits, n_outputs); orbit, output and sign of what is `sought` (k,); its `best` samples:
    signed value, and state, phase and length of the interval before it, each (k, ...).
    """
    lowest, states, start, widths = best
    count = PEAKS.zoom + 1  # the next piece begins with the last one
    for _ in range(PEAKS.max_zooms):
        width, own = width / PEAKS.zoom, constants.rows(orbits)
        closer = flow.sample(*begins, begins[1] + count * width, count, own)
        times = begins[1][:, None] + np.arange(count) * width
        flat = flow.outputs(closer.reshape(-1, closer.shape[2]), times.ravel(), own.repeated(count))
        outputs = flat.reshape(*times.shape, -1)[:, :, columns]
        inner = outputs[:, 1:-1]  # the ends are known: lower is rounding
        least = np.full((2, *spread.shape), np.inf)
        np.minimum.at(least[0], orbits, inner.min(axis=1))
        np.minimum.at(least[1], orbits, -inner.max(axis=1))
        for row in (least[(sought[2] < 0).astype(int), *sought[:2]] < lowest).nonzero()[0]:
            orbit, column, sign = (each[row] for each in sought)
            pieces = (orbits == orbit).nonzero()[0]
            of_row = sign * inner[pieces, :, column]
            piece, place = divmod(int(of_row.argmin()), count - 2)
            sample = pieces[piece], place
            lowest[row], widths[row] = of_row[piece, place], width
            states[row], start[row] = closer[sample], times[sample]
        rows, places = _jumps(outputs, spread[orbits], closed=False)
        # Outputs that jump in ever more places are rounding errors themselves.
        few = np.bincount(orbits[rows], minlength=len(spread))[orbits[rows]] <= PEAKS.samples
        rows, places = rows[few], places[few]
        if not len(rows):
            break
        orbits, begins = orbits[rows], (closer[rows, places], times[rows, places])


def _jumps(values: Array, spread: Array, *, closed: bool = True) -> tuple[Indices, Indices]:
    """Return where an output jumps from one sample to the next, and beside: rows and samples.

    Shapes: values (n_rows, n_samples, n_outputs); spread (n_rows, n_outputs), the range of each.
    """
    after = np.roll(values, -1, axis=1) if closed else values[:, 1:]
    change = np.abs(after - values[:, : after.shape[1]])
    rounding = PEAKS.smooth * np.abs(values).max(axis=1)  # all that changes where one is constant
    jumps = (change > (PEAKS.jump * spread + rounding)[:, None]).any(axis=2)
    beside = np.pad(jumps, ((0, 0), (1, 1)), "wrap" if closed else "constant")
    rows, samples = np.nonzero(jumps | beside[:, 2:] | beside[:, :-2])
    return rows, samples


def refine_minimum(
    flow: Flow,
    constants: Constants,
    states: Array,
    start: Array,
    spacing: float | Array,
    columns: Indices,
    signs: Array,
    enough: Array | None = None,
) -> Array:
    """Find minima of outputs over continuous orbits, each near the lowest of its samples.

    The neighborhood of each is sampled ever more finely, which finds a minimum as sharp as that
    of the spring's length near collapse; a polynomial through the last samples gives the rest.
    What is seen to stay above `enough` is not examined any closer.

    Shapes: states (k, n); start, columns, signs, enough (k,), spacing too or one; returns (k,).
    """
    closest = np.empty((len(columns), len(_PLACES)))
    going = np.arange(len(columns))
    width = np.broadcast_to(2.0 * np.asarray(spacing), len(going))
    for zoom in range(1, PEAKS.max_zooms + 1):
        rows, own = np.arange(len(going)), constants.rows(going)
        fine = flow.sample(states, start, start + width, PEAKS.zoom, own)
        at = start[:, None] + np.arange(PEAKS.zoom) * (width / PEAKS.zoom)[:, None]
        flat = flow.outputs(fine.reshape(-1, fine.shape[2]), at.ravel(), own.repeated(PEAKS.zoom))
        values = flat.reshape(len(going), PEAKS.zoom, -1)[rows, :, columns[going]]
        values = signs[going, None] * values
        lowest = values.argmin(axis=1)
        # Of few numbers this takes a fourth of the time that `numpy.clip` does.
        best = np.minimum(np.maximum(lowest, PEAKS.neighbors), PEAKS.zoom - 1 - PEAKS.neighbors)
        closest[going] = beside = values[rows[:, None], best[:, None] + _PLACES]
        least, bend = beside.min(axis=1), _bend(beside)
        # Each continues individually: others change no digit of it.
        on = bend > PEAKS.bend * np.abs(values).max(axis=1)
        if zoom < PEAKS.zooms:
            on |= ~_is_smooth(beside)
        if enough is not None:
            on &= ~(least - np.abs(bend) > enough[going])
        on &= width > 2 * PEAKS.zoom**2 * np.spacing(start + width)  # phases have no more digits
        if not on.any():
            break
        best = np.minimum(np.maximum(lowest, 1), PEAKS.zoom - 2)
        going, states, start = going[on], fine[rows, best - 1][on], at[rows, best - 1][on]
        width = (2 * width / PEAKS.zoom)[on]
    return _least_between(closest)


_PLACES = np.arange(-PEAKS.neighbors, PEAKS.neighbors + 1)
_ORDERS = np.arange(len(_PLACES))[:, None]
_FIT = np.linalg.inv(np.vander(_PLACES.astype(float), increasing=True)).T
_SIXTH = np.array([1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0])


def _is_smooth(values: Array) -> Mask:
    """Return whether samples lie on a polynomial, (k, 2 neighbors + 1) to (k,)."""
    return np.asarray(np.abs(values @ _SIXTH) <= PEAKS.smooth * np.abs(values).max(axis=1))


def _middle(values: Array) -> Indices:
    """Return which of samples has the lowest in its neighborhood, (k, 2 neighbors + 1) to (k,)."""
    return np.minimum(np.maximum(values.argmin(axis=1), 1), len(_PLACES) - 2)


def _bend(values: Array) -> Array:
    """Return how much samples bend where they are lowest, (k, 2 neighbors + 1) to (k,)."""
    rows, middle = np.arange(len(values)), _middle(values)
    left, right = values[rows, middle - 1], values[rows, middle + 1]
    return np.asarray(left - 2 * values[rows, middle] + right)


def _least_between(values: Array) -> Array:
    """Return the minima of polynomials through samples, (k, 2 neighbors + 1) to (k,)."""
    least, bend, middle = values.min(axis=1), _bend(values), _middle(values)
    coefficients, places = _FIT.T @ values.T, _PLACES[middle].astype(float)
    slopes, low, high = coefficients[1:] * _ORDERS[1:], places - 1, places + 1
    curvatures = slopes[1:] * _ORDERS[1:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        for _ in range(3):
            slope, curvature = (polyval(places, each, False) for each in (slopes, curvatures))
            step = np.where(curvature > 0, slope / curvature, 0.0)
            places = np.minimum(np.maximum(places - step, low), high)
    # Where the samples lie on no polynomial, as beside a jump, it says nothing.
    beyond = np.where(np.abs(values @ _SIXTH) <= np.abs(bend), np.abs(bend), 0.0)
    found = np.maximum(polyval(places, coefficients, False), least - beyond)
    return np.asarray(np.minimum(found, least))


def contact_extrema(model: Model, state: Array, mode: Mode, count: int) -> tuple[Array, Array]:
    """Find minimum and maximum of all outputs over some periods in which contacts stick and slip.

    Outputs jump or have corners where contacts change: each smooth phase is examined alone, from
    one side of its ends to the other. Shapes: state (n,); returns (n_outputs,) each.
    """
    scales, sides = flow_of(model).constants_of(model).scales, list[Array]()
    for part in dense_phases(model, state, mode, float(count)):
        size = math.ceil(PEAKS.dense * (part.end - part.begin)) + PEAKS.zoom
        phases, states = np.linspace(part.begin, part.end, size), np.tile(part.state, (size, 1))
        if part.polynomials is not None:
            states[:-1] = part.polynomials(phases[:-1])[:, : len(state)] * scales
        values = Samples(model, states, phases, [part.reported_mode] * size).outputs()
        sides.append(np.array([_least_of_part(values), -_least_of_part(-values)]))
    unknown = np.full((2, len(flow_of(model).output_names)), np.nan)
    low, high = np.array(sides or [unknown]).swapaxes(0, 1)
    return low.min(axis=0), high.max(axis=0)


def _least_of_part(values: Array) -> Array:
    """Return the minima of outputs from equidistant samples of a smooth phase, (m, q) to (q,)."""
    last = len(values) - 1 - PEAKS.neighbors
    at = np.clip(values.argmin(axis=0), PEAKS.neighbors, last) + _PLACES[:, None]
    beside = np.take_along_axis(values, at, axis=0).T
    with np.errstate(invalid="ignore"):  # an output may be infinite at rest
        known = np.isfinite(beside).all(axis=1)
        return np.where(known, _least_between(beside), values.min(axis=0))


def steady_extrema(motion: Trajectory, names: Sequence[str]) -> Extrema:
    """Find extrema over the orbit that a trajectory settled on, or else over its last periods.

    It has a whole period at least.
    """
    settlement = motion.settlement
    count = motion.steady_periods(1 if settlement.settled else PEAKS.periods)
    columns = [flow_of(motion.model).output_index(name) for name in names]
    model = motion.steady_model
    # A round of a cycle takes no whole number of intervals, so that it begins at the last state.
    cycle = settlement.duration is not None
    if motion.sticking is not None:
        mode_at, starts = motion.sticking.mode, [-1] if cycle else range(-1 - count, -1)
        each = [contact_extrema(model, motion.states[i], mode_at(i), 1) for i in starts]
        low, high = np.array(each)[:, :, columns].swapaxes(0, 1)
        return Extrema(tuple(names), low.min(axis=0)[None], high.max(axis=0)[None])
    nodes = motion.states[-1:] if cycle else motion.states[-1 - count : -1]
    found = find_extrema(model, model.vector[None], nodes[None], len(nodes), names)
    if settlement.settled:
        return found
    # What does not close may be least or greatest where it begins, which nothing precedes.
    values = motion.steady_outputs(count, 1)[:, columns]
    low = np.minimum(found.minimum, values.min(axis=0))
    return Extrema(found.names, low, np.maximum(found.maximum, values.max(axis=0)))
