"""All attractors that trajectories from starts in a box converge to, each verified."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow.ensembles import released
from slipfold.flow.equilibrium import paced
from slipfold.flow.scales import measured
from slipfold.long_term.attractor import Attractor
from slipfold.long_term.verified import Known, Trajectories, Verified
from slipfold.models.model import Model
from slipfold.models.parameter import DURATION
from slipfold.models.quantity import parse_quantity
from slipfold.models.suggestion import unknown
from slipfold.progress import Observer, Progress

REACH = 1.5
"""Of a box that nobody gives: times the characteristic scale of each state, about the model's
start."""


@dataclass(frozen=True, eq=False)
class Box:
    """States between two corners; where they agree a state is the same in all starts."""

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
    """Read a box from intervals by state; the other states are those of the model's start.

    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
    >>> checked_box(SlidingOscillator(), {"y": (-0.5, "0.5")}).high.tolist()
    [0.0, 0.5, 0.0, 0.0]
    """
    units = {state.name: state.unit for state in model.states}
    low, high = model.start.copy(), model.start.copy()
    if not isinstance(given, Mapping) or not given:
        example = {next(iter(units)): (-1, 1)}
        raise InputError(f"box = {given!r} does not say which states; give e.g. {example!r}")
    for name, ends in given.items():
        if name not in units:
            raise unknown(f"{model.name} has no state", name, units)
        try:
            first, last = ends
        except (TypeError, ValueError):
            raise InputError(
                f"the box of {name}, {ends!r}, is not a pair of numbers; give its least and its "
                "largest value"
            ) from None
        place = list(units).index(name)
        low[place], high[place] = (parse_quantity(end, units[name], name) for end in (first, last))
        if not (np.isfinite([low[place], high[place]]).all() and low[place] < high[place]):
            raise InputError(
                f"the box of {name} from {low[place]:g} to {high[place]:g} is empty; give its "
                "least value first"
            )
    return Box(low, high)


def box_around(model: Model, reached: Array | None = None) -> Box:
    """Return the box that is meant where nobody gives one.

    It is about the model's start, by the characteristic scales of states or how far orbits reach
    from it, whichever is larger. Shapes: reached (n,).
    """
    sizes = model.state_scales() if reached is None else np.maximum(model.state_scales(), reached)
    half = np.where(model.whole_turns > 0, model.whole_turns / 2, REACH * sizes)
    return Box(model.start - half, model.start + half)


UNDECIDED, ENDED, UNFINISHED = 0, -1, -2
"""Labels of starts that converge to no attractor."""

KEPT = 33
"""States of each trajectory that these looks see."""

SCOUTS = 256
"""Starts, of more, that go ahead: the others then mostly come to what is known."""

SURELY = 256
"""Periods in which a trajectory on a torus or in chaos passes most of what it passes at all."""

PACED = 7
"""Trajectories whose paces are looked at."""


@dataclass(frozen=True, eq=False)
class Searched:
    """What was found."""

    model: Model
    attractors: tuple[Attractor, ...]
    labels: NDArray[np.int64]  # of each start: number of an attractor, or what else it came to
    ends: dict[str, int]  # how many trajectories ended early, by the kind of their end
    interrupted: bool
    known: tuple[Known, ...] = ()  # the attractors with what lies near them


def search(
    model: Model,
    starts: Array,
    periods: int | None = None,
    observer: Observer | None = None,
    *,
    measure: bool = True,
    known: tuple[Known, ...] = (),
) -> Searched:
    """Let trajectories from many starts continue until each is near something known and verified.

    `known` are the attractors of a search before, whose model this is. What converges to nothing
    that repeats is measured by its exponents, or else undecided. An interruption keeps what is
    found.

    Shapes: starts (k, n).
    """
    work, interrupted, most = None, False, periods or 1024
    some = np.random.default_rng(0).permutation(len(starts))[:SCOUTS]
    ahead = starts[some] if len(starts) > 2 * SCOUTS else starts[:0]
    try:
        model = measured(model)
        if not model.forced and not known:
            model = _paced(model, starts)
        verified = Verified(model)
        verified.known.extend(known)
        total = len(ahead) + len(starts)
        work = _Search(verified, starts, most, _counted(observer, len(ahead), total))
        if len(ahead):
            first = _Search(verified, ahead, most, _counted(observer, 0, total))
            first.run(measure=measure)
        work.run(measure=measure)
    except KeyboardInterrupt:
        interrupted = True
    if work is None:
        return Searched(model, (), np.full(len(starts), UNFINISHED), {}, interrupted)
    return work.result(interrupted)


class _Search:
    """The trajectories, and what they have come to so far."""

    def __init__(
        self, verified: Verified, starts: Array, most: int, observer: Observer | None
    ) -> None:
        self._verified = verified
        self._trajectories = Trajectories(verified.model, starts)
        self._labels = np.full(len(starts), UNFINISHED)
        self._last = np.repeat(starts[:, None], KEPT, axis=1)
        self._most, self._periods = most, 0
        self._observer = observer

    def run(self, *, measure: bool) -> None:
        """Let all trajectories continue, and look closely at them now and then."""
        look = 32  # periods, then twice as many each time
        while len(self._open) and self._periods < self._most:
            self._advance(min(16, self._most - self._periods))  # periods between looks
            if self._periods >= look:
                look *= 2
                self._look_at_open()
        self._look_at_open()
        if measure:
            self._measure_open()

    def result(self, interrupted: bool) -> Searched:
        """Return what was found."""
        if not interrupted:
            self._labels[self._labels == UNFINISHED] = UNDECIDED
        ends = Counter(stop.kind for stop in self._trajectories.stops.values())
        known = tuple(self._verified.known)
        found = tuple(item.attractor for item in known)
        return Searched(self._verified.model, found, self._labels, dict(ends), interrupted, known)

    @property
    def _open(self) -> NDArray[np.intp]:
        return np.flatnonzero(self._labels == UNFINISHED)

    def _advance(self, periods: int) -> None:
        which = self._open
        states = self._trajectories.advance(which, periods)
        self._last[which] = np.concatenate([self._last[which, periods:], states[:, 1:]], axis=1)
        self._periods += periods
        self._labels[[place for place in which if place in self._trajectories.stops]] = ENDED
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

    def _catch(self, known: Known) -> None:
        """Label the trajectories that have come near it."""
        which = self._open
        if len(which):
            self._labels[which[known.catches(self._last[which])]] = known.attractor.id

    def _add(self, known: Known) -> None:
        self._verified.known.append(known)
        self._catch(known)
        self._report()

    def _look_at_open(self) -> None:
        """Correct what trajectories nearly repeat on to what they converge to."""
        which = self._open
        for place in which[:: -(-len(which) // 48) or 1]:  # 48 of them at most
            if self._labels[place] == UNFINISHED:
                sticks = bool(self._trajectories.stuck[place])
                known = self._verified.settling(self._last[place], sticks)
                if known is not None:
                    self._add(known)

    def _measure_open(self) -> None:
        """Tell tori and chaos by their exponents."""
        trials = 0
        for place in self._open:
            if self._labels[place] != UNFINISHED or trials == 4:  # without success in sequence
                continue
            sticks = bool(self._trajectories.stuck[place])
            known = self._verified.measured(self._trajectories.states[place], sticks)
            trials = 0 if known is not None else trials + 1
            self._labels[place] = UNDECIDED if known is None else known.attractor.id
            if known is not None and known not in self._verified.known:
                self._verified.known.append(known)
                self._catch_later(known)
                self._report()

    def _catch_later(self, known: Known) -> None:
        """Label open trajectories that converge to this attractor within `SURELY` periods."""
        which = self._open
        if len(which):
            states = self._trajectories.advance(which, SURELY)
            self._labels[which[known.catches(states)]] = known.attractor.id


def _counted(observer: Observer | None, before: int, total: int) -> Observer | None:
    """Return an observer of trajectories besides those `before`, as part of all of them."""
    if observer is None:
        return None
    return lambda progress: observer(replace(progress, done=before + progress.done, total=total))


def _paced(model: Model, starts: Array) -> Model:
    """Return an autonomous model whose ``duration`` suits its slowest trajectories."""
    some = starts[:: max(len(starts) // PACED, 1)][:PACED]
    durations = [paced(model, start, None)[0].values[DURATION.name] for start in some]
    return model.replace(**{DURATION.name: max(durations)})


def kind_of(item: Attractor) -> str:
    """Return what an attractor is wherever it continues."""
    return item.kind if item.period is None else f"period {item.period}"


def search_released(
    model: Model,
    starts: Array,
    phases: Array,
    periods: int | None = None,
    observer: Observer | None = None,
    known: tuple[Known, ...] = (),
) -> Searched:
    """Continue trajectories from their phases to phase zero, and until each is known.

    `known` are the attractors of a search before. Shapes: starts (k, n); phases (k,), from 0 to 1.
    """
    states, stops = released(model, starts, phases)
    if not stops:
        return search(model, states, periods, observer, known=known)
    going = np.setdiff1d(np.arange(len(starts)), [*stops])
    result = search(model, states[going], periods, observer, known=known)
    labels = np.full(len(starts), ENDED)
    labels[going] = result.labels
    ends = Counter(stop.kind for stop in stops.values()) + Counter(result.ends)
    return replace(result, labels=labels, ends=dict(ends))
