"""The last whole round of a motion: extrema of its states, and where its contacts stick."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.flow import flow_of
from slipfold.flow.switched.events import Ending
from slipfold.flow.switched.mode import Mode, Status
from slipfold.flow.switched.sampled import dense_legs
from slipfold.flow.switched.step_polynomials import BegunPolynomials, SlowPolynomials
from slipfold.flow.switched.switched_flow import Leg
from slipfold.flow.trajectory import Trajectory
from slipfold.models.model import Model
from slipfold.models.turns import without_turns

SAME = 1e-12
"""Share of a step by which a root may lie beside it."""

STEPS = 100_000
"""Steps of the integrator in a round at most."""

WHOLE = 1e-9
"""Phases that may lack of a round: the end of a leg is the root of an event there."""

CLOSES = 1e-5
"""Gap, in scaled states, of a round carried on from rest; what is caught there misses by far."""

SPREAD = 64
"""Places in a step of slow slip that are looked at."""

UNSETTLED = 16
"""Intervals at the end of an autonomous motion that are looked at if it has no round."""


@dataclass(frozen=True)
class StickTime:
    """A time in which a contact sticks; frozen.

    Parameters
    ----------
    contact
        Its name.
    begin, end
        From the start of the round, in forcing periods; of an autonomous model in s. Where a round
        repeats itself, a time that runs over its end ends beyond it.
    """

    contact: str
    begin: float
    end: float


@dataclass(frozen=True, eq=False)
class LastRound:
    """The last whole round of a motion.

    Parameters
    ----------
    least, most
        Smallest and largest value of each state, shape (n_states,); NaN if it was not whole.
    sticking
        When contacts stick.
    fraction
        Share of the time in which any contact sticks.
    stuck
        Whether all contacts stick all the time.
    """

    least: Array
    most: Array
    sticking: tuple[StickTime, ...] = ()
    fraction: float = 0.0
    stuck: bool = False


def last_round(motion: Trajectory) -> LastRound | None:
    """Return what the last whole round of a motion shows; None if there is none.

    That is the last response, or one more round of a cycle; of a motion that has not settled the
    last forcing period.
    """
    settlement, model = motion.settlement, motion.model
    count = settlement.period or (1 if model.forced else min(UNSETTLED, motion.periods))
    if not 1 <= count <= motion.periods:
        return None
    if settlement.duration is not None:
        model, place, count = motion.steady_model, motion.periods, 1
    else:
        place = motion.periods - count
    state, flow = motion.strobe[place], flow_of(model)
    constants = flow.constants_of(model)
    if motion.sticking is None:
        dense = flow.dense(state, constants, float(count), STEPS)
        return None if dense is None else LastRound(*_extrema([dense.polynomials], dense.scales))
    mode, names = motion.sticking.mode(place), motion.sticking.contacts
    found = round_with_stick(model, state, mode, names, count, settlement.settled)
    return None if np.isnan(found.fraction) else found


def round_with_stick(
    model: Model, state: Array, mode: Mode, contacts: Sequence[str], count: int, repeats: bool
) -> LastRound:
    """Return what a motion with stick and slip shows from phase zero to another.

    Of one that stops on the way nothing is known: NaN. Shapes: state (n,).
    """
    legs = list(dense_legs(model, state, mode, float(count)))
    if not _goes_round(model, state, legs, count):
        unknown = np.full(len(state), np.nan)
        return LastRound(unknown, unknown, fraction=np.nan)
    constants = flow_of(model).constants_of(model)
    known = [leg.polynomials for leg in legs if leg.polynomials is not None]
    unit = 1.0 if model.forced else constants.period
    times = []
    for contact, name in enumerate(contacts):
        spans = _joined([(leg.begin, leg.end) for leg in legs if leg.mode[contact] is STICK])
        if repeats and len(spans) > 1 and _meet(spans, float(count)):
            first, *spans = spans
            spans[-1] = (spans[-1][0], count + first[1])
        times += [StickTime(name, begin * unit, end * unit) for begin, end in spans]
    stuck = sum(leg.end - leg.begin for leg in legs if STICK in leg.mode)
    whole = all(status is STICK for leg in legs for status in leg.mode)
    return LastRound(*_extrema(known, constants.scales), tuple(times), stuck / count, whole)


STICK = Status.STICK


def _goes_round(model: Model, state: Array, legs: Sequence[Leg], count: int) -> bool:
    """Whether legs reach the end of a round; if on from rest at a touch, whether they close it."""
    if not legs or legs[-1].end < count - WHOLE:
        return False
    if not any(leg.event is not None and leg.event.ending is Ending.STIFF for leg in legs):
        return True
    apart = without_turns(legs[-1].state - state, model.whole_turns) / model.state_scales()
    return bool(np.abs(apart).max() < CLOSES)


def _meet(spans: Sequence[tuple[float, float]], end: float) -> bool:
    """Whether the first and the last of some spans are one in a round that repeats itself."""
    return spans[0][0] == 0.0 and spans[-1][1] == end


def _extrema(polynomials: Iterable[Any], scales: Array) -> tuple[Array, Array]:
    """Return the extrema of Taylor polynomials, wherever in their steps they lie."""
    n = len(scales)
    least, most = np.full(n, np.inf), np.full(n, -np.inf)
    for output in polynomials:
        known = [*range(n)]
        if isinstance(output, BegunPolynomials):
            output = output.inner
        if isinstance(output, SlowPolynomials):
            known = [place for place in known if place not in output.held]
            spread = output.nodes(np.linspace(0.0, 1.0, SPREAD))[0]
            for place in output.held:
                values = _peaks(spread[:, :, place])
                least[place] = min(least[place], values.min())
                most[place] = max(most[place], values.max())
            output = output.inner
        lengths = np.diff(output.times)
        for length, coefficients in zip(lengths, output.tcs[:, :n], strict=True):
            order = coefficients.shape[1]
            scaled = coefficients * length ** np.arange(order)
            for place in known:
                values = _turning_values(scaled[place])
                least[place] = min(least[place], values.min())
                most[place] = max(most[place], values.max())
    return least * scales, most * scales


def _peaks(values: Array) -> Array:
    """Return samples, and the vertices of parabolas where they turn. Shapes: values (m, p)."""
    before, middle, after = values[:, :-2], values[:, 1:-1], values[:, 2:]
    turns = (middle - before) * (after - middle) < 0
    bend = (after - 2 * middle + before)[turns]
    vertices = middle[turns] - (after - before)[turns] ** 2 / (8 * bend)
    return np.concatenate([values.ravel(), vertices])


def _turning_values(coefficients: Array) -> Array:
    """Return the values of a polynomial at the ends of [0, 1] and where it turns between them."""
    ends = np.array([coefficients[0], coefficients.sum()])
    slopes = coefficients[1:] * np.arange(1, len(coefficients))
    size = np.abs(slopes).max()
    if not abs(slopes[0]) <= np.abs(slopes[1:]).sum():  # the slope keeps its sign
        return ends
    slopes = np.trim_zeros(np.where(np.abs(slopes) < 1e-16 * size, 0.0, slopes), "b")
    if len(slopes) < 2:
        return ends
    roots = np.polynomial.polynomial.polyroots(slopes)
    real = roots.real[(np.abs(roots.imag) < 1e-6) & (roots.real > -SAME) & (roots.real < 1 + SAME)]
    values = np.polynomial.polynomial.polyval(np.clip(real, 0.0, 1.0), coefficients)
    return np.concatenate([ends, values])


def _joined(spans: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Join spans that follow each other at once, and leave out those without length."""
    found: list[tuple[float, float]] = []
    for begin, end in spans:
        if end == begin:
            continue
        if found and found[-1][1] == begin:
            found[-1] = (found[-1][0], end)
        else:
            found.append((begin, end))
    return found
