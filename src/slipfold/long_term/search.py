"""Attractors of trajectories from many starts, and their basins; each attractor is verified."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from slipfold.arrays import Array, Indices, Mask
from slipfold.errors import InputError, unknown
from slipfold.flow.batches import ROUNDING
from slipfold.flow.ensembles import released
from slipfold.flow.equilibrium import with_duration
from slipfold.flow.scales import measured
from slipfold.long_term.attractor import Attractor
from slipfold.long_term.classification import CLASSIFICATION
from slipfold.long_term.verified import ATTRACTOR, AttractorRegion, AttractorSet, Trajectories
from slipfold.models.model import Model
from slipfold.models.quantities import DURATION, Parameter
from slipfold.models.units import interval
from slipfold.progress import Observer, Progress


@dataclass(frozen=True, eq=False)
class Box:
    """States between two corners; a state with equal bounds is the same in all starts."""

    low: Array  # shape (n,)
    high: Array  # shape (n,)

    def starts(self, number: int, seed: int) -> Array:
        """Return starts of low discrepancy (scrambled Sobol points), shape (number, n)."""
        from scipy.stats import qmc  # takes a second, which only a search should

        moves = self.high > self.low
        states = np.tile(self.low, (number, 1))
        if moves.any():
            points = qmc.Sobol(int(moves.sum()), rng=np.random.default_rng(seed))
            fractions = points.random_base2(int(np.ceil(np.log2(max(number, 2)))))[:number]
            states[:, moves] += fractions * (self.high - self.low)[moves]
        return states


def checked_box(model: Model, given: Any) -> Box:
    """Read a box from intervals by state; the other states are those of the model's start."""
    units = {state.name: state.unit for state in model.states}
    low, high = model.start.copy(), model.start.copy()
    if not isinstance(given, Mapping) or not given:
        example = {next(iter(units)): (-1, 1)}
        raise InputError(f"box = {given!r} does not say which states; give e.g. {example!r}")
    for name, ends in given.items():
        if name not in units:
            raise unknown(f"{model.name} has no state", name, units)
        index, state = list(units).index(name), Parameter(name, 0.0, units[name])
        low[index], high[index] = interval(state, ends, "box", rising=True)
    return Box(low, high)


def box_around(model: Model, reached: Array | None = None) -> Box:
    """Return the default box about the model's start.

    Its size follows from the characteristic scales, or from how far orbits reach if that is more.
    Shapes: reached (n,).
    """
    sizes = model.state_scales() if reached is None else np.maximum(model.state_scales(), reached)
    half = np.where(model.angle_periods > 0, model.angle_periods / 2, ATTRACTOR.reach * sizes)
    return Box(model.start - half, model.start + half)


UNDECIDED, ENDED, UNFINISHED = 0, -1, -2
"""Labels of starts that converge to no attractor."""


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Result of a search."""

    model: Model
    attractors: tuple[Attractor, ...]
    labels: Indices  # of each start: number of an attractor, or what else was reached
    ends: dict[str, int]  # how many trajectories ended early, by the kind of their end
    interrupted: bool
    known: tuple[AttractorRegion, ...] = ()  # the attractors with what lies near them


def search(
    model: Model,
    starts: Array,
    periods: int | None = None,
    observer: Observer | None = None,
    *,
    measure: bool = True,
    known: tuple[AttractorRegion, ...] = (),
) -> SearchResult:
    """Follow trajectories from many starts until each is near a verified attractor.

    `known` are the attractors of an earlier search with this model. Trajectories that do not repeat
    are classified by their exponents, or are undecided. An interruption keeps results so far.

    Shapes: starts (k, n).
    """
    work, interrupted = None, False
    try:
        model = measured(model)
        if not model.forced and not known:
            model = _paced(model, starts)
        verified = AttractorSet(model)
        verified.known.extend(known)
        work = _Search(verified, starts, periods or 1024, observer)
        work.run(measure=measure)
    except KeyboardInterrupt:
        interrupted = True
    if work is None:
        return SearchResult(model, (), np.full(len(starts), UNFINISHED), {}, interrupted)
    return work.result(interrupted)


class _Search:
    """The trajectories and their labels so far."""

    def __init__(
        self, verified: AttractorSet, starts: Array, most: int, observer: Observer | None
    ) -> None:
        self._verified = verified
        self._trajectories = Trajectories(verified.model, starts)
        self._labels = np.full(len(starts), UNFINISHED)
        self._last = np.repeat(starts[:, None], ATTRACTOR.stored, axis=1)
        self._most, self._periods = most, 0
        self._observer = observer

    def run(self, *, measure: bool) -> None:
        """Continue all trajectories, and search for attractors at growing intervals."""
        look = 32  # periods, then twice as many each time
        while len(self._open) and self._periods < self._most:
            self._advance(min(16, self._most - self._periods))  # periods between looks
            if self._periods >= look:
                look *= 2
                self._look_at_open()
        self._look_at_open()
        if measure:
            self._measure_open()

    def result(self, interrupted: bool) -> SearchResult:
        """Return the result so far."""
        if not interrupted:
            self._labels[self._labels == UNFINISHED] = UNDECIDED
        ends = Counter(stop.kind for stop in self._trajectories.stops.values())
        # All states about one that is held are at rest too, so that it attracts nothing
        ends["held by friction"] = int((self._labels == ENDED).sum()) - ends.total()
        known = tuple(self._verified.known)
        found = tuple(item.attractor for item in known)
        return SearchResult(
            self._verified.model, found, self._labels, dict(+ends), interrupted, known
        )

    @property
    def _open(self) -> Indices:
        return np.flatnonzero(self._labels == UNFINISHED)

    def _advance(self, periods: int) -> None:
        which = self._open
        states = self._trajectories.advance(which, periods)
        self._last[which] = np.concatenate([self._last[which, periods:], states[:, 1:]], axis=1)
        self._periods += periods
        self._labels[[index for index in which if index in self._trajectories.stops]] = ENDED
        for known in self._verified.known:
            self._catch(known)
        self._report()

    def _report(self) -> None:
        if self._observer is not None:
            result = tuple(kind_of(known.attractor) for known in self._verified.known)
            done = int((self._labels != UNFINISHED).sum())
            text = f"{self._periods} periods  found: {', '.join(result) or 'nothing yet'}"
            values = {"periods": self._periods, "found": result}
            self._observer(Progress("starts", done, len(self._labels), text, values))

    def _catch(self, known: AttractorRegion) -> None:
        """Label the trajectories in the region of an attractor."""
        which = self._open
        if len(which):
            self._labels[which[known.catches(self._last[which])]] = known.attractor.id

    def _add(self, known: AttractorRegion) -> None:
        self._verified.known.append(known)
        self._catch(known)
        self._report()

    def _look_at_open(self) -> None:
        """Search for attractors that open trajectories converge to."""
        which = self._open
        for index in which[:: -(-len(which) // 48) or 1]:  # 48 of them at most
            if self._labels[index] == UNFINISHED:
                sticks = bool(self._trajectories.stuck[index])
                known = self._verified.attractor_near(self._last[index], sticks)
                if known is not None:
                    self._add(known)
        moved = np.ptp(self._last, axis=1) / self._verified.model.state_scales()
        still = self._trajectories.stuck & (moved.max(axis=1) <= ROUNDING)
        self._labels[still & (self._labels == UNFINISHED)] = ENDED

    def _measure_open(self) -> None:
        """Identify tori and chaos by their exponents."""
        trials = 0
        for index in self._open:
            if self._labels[index] != UNFINISHED or trials == 4:  # without success in sequence
                continue
            sticks = bool(self._trajectories.stuck[index])
            known = self._verified.classified(self._trajectories.states[index], sticks)
            trials = 0 if known is not None else trials + 1
            self._labels[index] = UNDECIDED if known is None else known.attractor.id
            if known is not None and known not in self._verified.known:
                self._verified.known.append(known)
                which = self._open
                if len(which):  # some may converge to it within some periods
                    states = self._trajectories.advance(which, ATTRACTOR.visiting)
                    self._labels[which[known.catches(states)]] = known.attractor.id
                self._report()


def _report_part(observer: Observer, before: int, starts: int, total: int, part: Progress) -> None:
    """Report the progress of some starts, before which others are done, out of all."""
    done = before + part.done * starts // (part.total or 1)
    observer(replace(part, done=done, total=total))


def _paced(model: Model, starts: Array) -> Model:
    """Return an autonomous model whose ``duration`` suits its slowest trajectories.

    Far away they may be faster than where they arrive.
    """
    rows = starts[:: max(len(starts) // ATTRACTOR.paced, 1)][: ATTRACTOR.paced]
    chosen = 0.0
    while len(rows):
        durations = [with_duration(model, start, None)[0].values[DURATION.name] for start in rows]
        if max(durations) <= ATTRACTOR.slower * chosen:
            break
        chosen = max(durations)
        paced = model.replace(**{DURATION.name: chosen})
        rows = Trajectories(paced, rows).advance(np.arange(len(rows)), 16)[:, -1]
        rows = rows[np.isfinite(rows).all(axis=1)]
    return paced


def kind_of(item: Attractor) -> str:
    """Return the kind of an attractor, with its period."""
    return item.kind if item.period is None else f"period {item.period}"


def search_released(
    model: Model,
    starts: Array,
    phases: Array,
    periods: int | None = None,
    observer: Observer | None = None,
    known: tuple[AttractorRegion, ...] = (),
) -> SearchResult:
    """Continue trajectories from their phases to phase zero, and until each is known.

    `known` are the attractors of a search before. Shapes: starts (k, n); phases (k,), from 0 to 1.
    """
    states, stops = released(model, starts, phases)
    going = np.setdiff1d(np.arange(len(starts)), [*stops])
    result = search(model, states[going], periods, observer, known=known)
    labels = np.full(len(starts), ENDED)
    labels[going] = result.labels
    ends = Counter(stop.kind for stop in stops.values()) + Counter(result.ends)
    return replace(result, labels=labels, ends=dict(ends))


KNOWN, WITHIN_CELL, WITHIN_ERROR = 0, 1, 2
"""Whether the label of a cell is certain, differs at a corner, or differs for a start perturbed by
an integration error."""


def find_basins(
    model: Model,
    axes: tuple[Array, Array],
    starts_at: Callable[[Array, Array], tuple[Array, Array]],
    periods: int | None,
    observer: Observer | None,
) -> tuple[SearchResult, Indices]:
    """Label the cells of a plane by their attractors, and mark uncertain cells.

    Trajectories start at the centers of cells, then at their corners. Cells whose labels differ and
    their neighbors are labeled again from states perturbed by integration errors. `starts_at`
    returns states and phases of coordinates. Shapes: axes (n_first,), (n_second,); labels and marks
    (n_second, n_first).
    """
    from scipy.ndimage import binary_dilation

    def searched_on(starts: Array, phases: Array) -> SearchResult:
        return search_released(last.model, starts, phases, periods, observer, last.known)

    starts, phases = starts_at(*_grid(*axes))
    first = last = search_released(model, starts, phases, periods, observer)
    labels = first.labels.reshape(len(axes[1]), -1)
    uncertain = np.full_like(labels, KNOWN)
    if not last.interrupted:
        last = searched_on(*starts_at(*_grid(*map(_edges, axes))))
        corners = last.labels.reshape(len(labels) + 1, -1)
        for up, across in product((slice(1, None), slice(-1)), repeat=2):
            uncertain[_differ(labels, corners[up, across])] = WITHIN_CELL
    cells = np.flatnonzero(binary_dilation(uncertain > KNOWN, np.ones((3, 3), bool)))
    moved = CLASSIFICATION.floor * last.model.state_scales()
    for sign in (-1.0, 1.0) if len(cells) else ():
        if not last.interrupted:
            last = searched_on(starts[cells] + sign * moved, phases[cells])
            uncertain.flat[cells[_differ(labels.flat[cells], last.labels)]] = WITHIN_ERROR
    return replace(last, labels=labels, ends=first.ends), uncertain


def _grid(first: Array, second: Array) -> tuple[Array, Array]:
    across, up = np.meshgrid(first, second)
    return across.ravel(), up.ravel()


def _edges(values: Array) -> Array:
    """Return the ends of cells within the plane. Shapes: values (n,), returns (n + 1,)."""
    return np.concatenate([values[:1], 0.5 * (values[1:] + values[:-1]), values[-1:]])


def _differ(one: Indices, other: Indices) -> Mask:
    """Whether two known labels differ."""
    return np.asarray((one != other) & (one != UNFINISHED) & (other != UNFINISHED))


@dataclass(frozen=True, eq=False)
class Fractions:
    """Attractors and labels of starts at each value of a parameter."""

    labels: Indices  # shape (n_values, n_starts)
    attractors: tuple[tuple[Attractor, ...], ...]  # of each value, none where it was not finished
    ends: dict[str, int]  # how many trajectories ended early, by the kind of their end
    interrupted: bool


def find_fractions(
    model: Model,
    vary: str,
    values: Array,
    starts: Array,
    periods: int | None,
    observer: Observer | None,
) -> Fractions:
    """Search at one value after the other; an attractor keeps its number as long as it continues.

    One more trajectory, which is not counted, starts on each attractor of the previous value. It
    keeps small basins in view and shows which attractor continues which.

    Shapes: values (m,), starts (k, n).
    """
    labels = np.full((len(values), len(starts)), UNFINISHED)
    attractors: list[tuple[Attractor, ...]] = [() for _ in values]
    ends: Counter[str] = Counter()
    before: tuple[Attractor, ...] = ()
    known, interrupted = 0, False
    for index, value in enumerate(values):
        continued = np.array([item.state for item in before]).reshape(-1, starts.shape[1])
        result = search(
            model.replace(**{vary: float(value)}),
            np.concatenate([continued, starts]),
            periods,
            observer
            and partial(_report_part, observer, index * len(starts), len(starts), labels.size),
        )
        if result.interrupted:
            interrupted = True
            break
        led, reached = np.split(result.labels, [len(before)])
        numbers = _numbers(result.attractors, before, led, model.state_scales(), known)
        known = max([known, *numbers.values()])
        before = tuple(replace(item, id=numbers[item.id]) for item in result.attractors)
        attractors[index] = before
        labels[index] = [numbers.get(label, label) for label in reached.tolist()]
        ends.update(result.ends)
    return Fractions(labels, tuple(attractors), dict(ends), interrupted)


def _numbers(
    result: Sequence[Attractor],
    before: Sequence[Attractor],
    led: Indices,
    scales: Array,
    known: int,
) -> dict[int, int]:
    """Return the number of each attractor: that of its predecessor of the same kind, or a new one.

    Of several predecessors the one with the nearest extremes counts.
    """
    numbers: dict[int, int] = {}
    for item in result:
        alike = [
            other
            for other, label in zip(before, led, strict=True)
            if label == item.id and (other.kind, other.period) == (item.kind, item.period)
        ]
        if alike:
            numbers[item.id] = min(alike, key=lambda other: _apart(other, item, scales)).id
        else:
            known += 1
            numbers[item.id] = known
    return numbers


def _apart(one: Attractor, other: Attractor, scales: Array) -> float:
    """Return how far the extremes of the states of two attractors are apart."""
    ends = [np.stack([item.minimum, item.maximum])[:, : len(scales)] for item in (one, other)]
    return float(np.abs((ends[0] - ends[1]) / scales).max())
