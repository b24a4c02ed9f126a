"""A periodic orbit from nothing but a model, or near a state."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from slipfold.arrays import Array
from slipfold.continuation.newton import Correction, correct
from slipfold.errors import InputError
from slipfold.flow import flow_of, simulate
from slipfold.flow.guarded_flow import guarded_flow_of
from slipfold.flow.pace import paced
from slipfold.flow.simulate import initial_state
from slipfold.flow.sizes.typical_sizes import measured
from slipfold.flow.switched.mode_equations import contacts_of
from slipfold.flow.switched.simulate import (
    comes_to_rest,
    simulate_smooth_or_switched,
    simulate_switched,
)
from slipfold.flow.trajectory import Trajectory
from slipfold.models.equilibrium_search import search_equilibrium
from slipfold.models.followed import check_followed
from slipfold.models.model import Model
from slipfold.models.turns import without_turns
from slipfold.orbits.continued import hold_parameter
from slipfold.orbits.first_orbits import find_cycle, find_response
from slipfold.orbits.kinds import ForcedOrbits, orbits_of
from slipfold.orbits.limits import broken_limit
from slipfold.orbits.orbit_curve import Orbits
from slipfold.orbits.periodic_orbit import PeriodicOrbit, StickSlipOrbit
from slipfold.orbits.switched_shooting import SwitchedShooting
from slipfold.orbits.test_functions import floquet_multipliers
from slipfold.progress import Observer

CONVERGED = 1e-6
"""Change from round to round, in scaled states, at which Newton's method takes over."""

ITERATIONS = 20


def find_switched(
    model: Model,
    vary: str,
    width: float,
    period: int | None,
    state: Array | None,
    *,
    tolerance: float = 1e-10,
    settle: int = 400,
) -> tuple[Orbits, Correction]:
    """Return an orbit near what a motion with stick and slip comes to, and its correction.

    Without a period it has that of the motion. Shapes: state (n,).
    """
    start = model.start if state is None else state
    motion = simulate_switched(model, settle if model.forced else None, start, CONVERGED)
    if motion.stopped is not None:
        raise InputError(f"no orbit was found: {motion.stopped.reason}")
    settlement = motion.settlement
    if not model.forced and settlement.kind != "cycle":
        raise InputError(
            f"the motion of {model.name} comes to no cycle: {settlement.message}; give a state "
            "near one"
        )
    for name in _resting(motion) if model.forced else ():
        raise InputError(
            f"the contact {name} of {model.name} sticks for good, so it may rest anywhere "
            "in a range and no orbit stands alone; begin where it slips"
        )
    model, node = motion.model, motion.strobe[-1]
    if settlement.duration is not None and not model.forced:
        model = model.replace(duration=settlement.duration)
    period = (period or settlement.period or 1) if model.forced else 1
    orbits = orbits_of(model, {vary: width}, period, 1, by=SwitchedShooting)
    by = orbits.by
    assert isinstance(by, SwitchedShooting)
    constants = orbits.flow.constants_of(model)
    better = by.better(node[None], constants)
    if better is not None:
        node = by.states(node[None], constants, better.start)[0]
        orbits = orbits.described_by(better)
    guess = orbits.unknown(node[None], model)
    row = hold_parameter(len(guess) - 1)
    return orbits, correct(orbits, guess, row, tolerance=tolerance, iterations=ITERATIONS)


def _resting(motion: Trajectory) -> list[str]:
    """Return the contacts that stick throughout the last forcing period."""
    last = motion.periods
    return [
        item.contact
        for item in (motion.sticking.intervals if motion.sticking is not None else ())
        if item.state == "stick" and item.begin <= last - 1 and item.end >= last
    ]


LONGEST_PERIOD = 64
"""Longest period that can be asked for, in forcing periods."""

LONGEST_SETTLING = 10**6
"""Most periods that a motion is given to settle."""

MOST_ROUNDS = 24
"""Times that a motion may go round a cycle until it is seen to come back, and products of such."""

SAME = 1e-7
"""Distance of states, in their scales, from which on they differ: orbits close to 1e-10, and what a
cascade has just doubled is farther apart."""


def periodic_orbit(
    model: Model,
    period: int = 1,
    state: ArrayLike | Mapping[str, float] | None = None,
    *,
    tolerance: float = 1e-10,
    settle: int = 400,
    duration: float | None = None,
) -> PeriodicOrbit:
    """Find a periodic orbit of a model.

    Of an autonomous model it is a cycle: the one that a motion from the model's start settles to,
    or one near a given state.

    Parameters
    ----------
    model
        The model.
    period
        Period in forcing periods; 1 for an autonomous model.
    state
        State near the orbit at phase zero, shape (n_states,), or some states by name; what is not
        given is the model's own start. Without it the linear response is the guess for period 1,
        and what a motion from the start settles to for longer periods.
    tolerance
        Largest mismatch of the accepted orbit, in scaled states.
    settle
        Forcing periods that a motion from rest is given to settle; of an autonomous model, turns.
    duration
        Duration of a cycle of an autonomous model in seconds, about; without it the time after
        which the motion comes back.

    Returns
    -------
    PeriodicOrbit
        The orbit with its multipliers.

    Raises
    ------
    InputError
        If the period or the state cannot be used or Newton's method does not lead to an orbit of
        this period.

    Examples
    --------
    >>> from slipfold.models import SlidingOscillator
    >>> orbit = periodic_orbit(SlidingOscillator(f=12.2, Nd=0.15), period=2)
    >>> orbit.stable
    True

    Van der Pol's cycle:

    >>> from slipfold.models import model_named
    >>> cycle = periodic_orbit(model_named("vanderpol-free"))
    >>> round(cycle.duration, 9)
    6.663286859
    """
    if period not in range(1, LONGEST_PERIOD + 1):
        raise InputError(
            f"period = {period!r} is not a whole number from 1 to {LONGEST_PERIOD}; give e.g. 2"
        )
    if settle not in range(1, LONGEST_SETTLING + 1):
        raise InputError(
            f"settle = {settle!r} is not a whole number from 1 to {LONGEST_SETTLING}; give e.g. 400"
        )
    on_wall = not may_slip(model)
    model = model if on_wall else measured(model)
    # Which one may change plays no part, but the duration of a cycle is unknown already.
    free = [item.name for item in model.parameters if model.forced or item.name != "duration"]
    if not free:
        raise InputError(f"{model.name} has no parameter; give it one, used or not")
    vary = free[0]
    if model.forced and duration is not None:
        raise InputError(
            f"duration = {duration!r} does not fit: {model.name} is forced, its orbits last whole "
            "forcing periods; leave it out, or give period"
        )
    near = None if state is None else _checked_state(model, state)
    smooth = partial(
        _smooth_orbit,
        *(model, vary, int(period)),
        duration=duration,
        tolerance=tolerance,
        settle=settle,
    )
    if not contacts_of(model):
        return smooth(near)
    through_stick = partial(_stick_slip_orbit, model, vary, int(period), near, tolerance, settle)
    if on_wall:
        return through_stick()
    if not model.forced:  # one motion tells whether it sticks
        try:
            orbit = through_stick()
        except InputError:
            return smooth(near)
        return orbit if orbit.sticking else smooth(near)
    if near is not None or period > 1:  # else it is sought by the linear response
        motion = simulate(model, settle if near is None else int(period), near)
        if comes_to_rest(motion.stopped, model):
            orbit = through_stick()
            return orbit if orbit.sticking else smooth(orbit.state)
        near = motion.strobe[-1] if near is None else near
    try:
        slips = smooth(near)
    except InputError:
        return through_stick()
    return slips if _keeps_limits(slips) else through_stick()


def may_slip(model: Model) -> bool:
    """Whether there are orbits in slip alone: not where a counter-body is at rest."""
    try:
        check_followed(model)
    except InputError:
        return not contacts_of(model)
    return True


def _smooth_orbit(
    model: Model,
    vary: str,
    period: int,
    state: Array | None,
    *,
    duration: float | None,
    tolerance: float,
    settle: int,
) -> PeriodicOrbit:
    """Return an orbit on which no contact changes what it does."""
    if not model.forced:
        return _cycle(model, vary, period, state, duration, tolerance, settle)
    orbits = ForcedOrbits(model, {vary: 1.0}, period)
    if state is None and period == 1:
        orbits, found = find_response(orbits, model.values[vary], implicitly=True)
        if found.converged:  # to the last digit
            found = correct(orbits, found.z, hold_parameter(orbits.size), tolerance=tolerance)
        return _as_orbit(orbits, model, found)
    start = _settled(model, settle) if state is None else state
    constants = orbits.flow.constants_of(model)
    zero = np.zeros(1)
    nodes = orbits.flow.sample(start[None], zero, zero + period, orbits.segments, constants)[0]
    guess = orbits.unknown(nodes, model)
    row = hold_parameter(orbits.size)
    correction = correct(orbits, guess, row, tolerance=tolerance, iterations=20)
    orbit = _as_orbit(orbits, model, correction)
    strobes = orbits.flow.sample(orbit.state[None], zero, zero + period, period, constants)[0]
    _refuse_shorter(orbit, strobes)
    return orbit


def _keeps_limits(orbit: PeriodicOrbit) -> bool:
    """Whether an orbit stays within the limits of its model, those of its contacts included."""
    name = next(item.name for item in orbit.model.parameters if item.name != "duration")
    orbits = orbits_of(orbit.model, {name: 1.0}, orbit.period, len(orbit.nodes))
    return broken_limit(orbits, orbits.unknown(orbit.nodes, orbit.model)) is None


def _stick_slip_orbit(
    model: Model, vary: str, period: int, state: Array | None, tolerance: float, settle: int
) -> StickSlipOrbit:
    """Return the orbit near what a motion with stick and slip comes to."""
    orbits, found = find_switched(
        model, vary, 1.0, period, state, tolerance=tolerance, settle=settle
    )
    if not found.converged:
        raise InputError(
            f"no orbit of period {period} was found for {model!r}: {found.failure}; give a state "
            "nearer to it, e.g. the end of a long simulation"
        )
    monodromy = orbits.linearise(found.z).monodromy
    orbit = StickSlipOrbit(
        orbits.model_at(found.z),
        period,
        orbits.evenly(found.z),
        orbits.spectrum.whole(floquet_multipliers(monodromy)),
        found.residual,
    )
    if period > 1:
        _refuse_shorter(orbit, simulate_switched(orbit.model, period, orbit.state, SAME).strobe)
    return orbit


def _cycle(
    model: Model,
    vary: str,
    period: int,
    state: Array | None,
    duration: float | None,
    tolerance: float,
    settle: int,
) -> PeriodicOrbit:
    if period != 1:
        raise InputError(
            f"period = {period} counts forcing periods, and {model.name} is autonomous; leave it "
            "out, and give a state near the cycle and its duration"
        )
    if duration is not None and not 0 < duration < np.inf:
        raise InputError(f"duration = {duration!r} s is not positive; give the cycle's, about")
    find = partial(find_cycle, model, vary, 1.0, tolerance=tolerance, settle=settle)
    orbits, correction = find(state, duration)
    orbit = _as_orbit(orbits, orbits.model_at(correction.z), correction)
    while (rounds := _times_round(orbit)) > 1:
        orbits, correction = find(orbit.state, orbit.duration / rounds)
        orbit = _as_orbit(orbits, orbits.model_at(correction.z), correction)
    return orbit


def _times_round(cycle: PeriodicOrbit) -> int:
    """Return how often a cycle comes back to where it began."""
    flow, model = flow_of(cycle.model), cycle.model
    phases = np.append(0.0, 1 / np.arange(MOST_ROUNDS, 1, -1))
    states = flow.trajectory(cycle.state, flow.constants_of(model), phases)[1:]
    apart = without_turns(states - cycle.state, model.whole_turns) / model.state_scales()
    back = np.flatnonzero(np.abs(apart).max(axis=1) < SAME)
    return int(MOST_ROUNDS - back[0]) if len(back) else 1


def _checked_state(model: Model, state: ArrayLike | Mapping[str, float]) -> Array:
    names = [item.name for item in model.states]
    if isinstance(state, Mapping) and set(state) <= set(names):
        own = dict(zip(names, model.start, strict=True))
        state = [state.get(name, own[name]) for name in names]
    try:
        checked = np.asarray(state, dtype=float)
    except (TypeError, ValueError):
        checked = np.empty(0)
    if checked.shape != (len(names),) or not np.isfinite(checked).all():
        raise InputError(
            f"state = {state!r} does not fit; give finite numbers for {' '.join(names)}"
        )
    return without_turns(checked, model.whole_turns)


def _settled(model: Model, periods: int) -> Array:
    """State that a motion from the model's start comes to."""
    flow = flow_of(model)
    constants = flow.constants_of(model)
    state = model.start
    one_period = np.array([0.0, 1.0])
    for _ in range(periods):
        state = flow.trajectory(state, constants, one_period)[-1]
        state = without_turns(state, model.whole_turns)
    return state


def _refuse_shorter(orbit: PeriodicOrbit, strobes: Array) -> None:
    """Refuse an orbit that repeats within the period asked for.

    Shapes: strobes (period, n) or more, its states after whole forcing periods.
    """
    count, model = orbit.period, orbit.model
    for shorter in range(1, count):
        apart = without_turns(strobes[shorter] - strobes[0], model.whole_turns)
        moved = np.abs(apart / model.state_scales()).max()
        if count % shorter == 0 and moved < SAME:
            raise InputError(
                f"the orbit found for period {count} has period {shorter}; give a state nearer to "
                f"an orbit of period {count}, or ask for period {shorter}"
            )


def _as_orbit(orbits: Orbits, model: Model, correction: Correction) -> PeriodicOrbit:
    if not correction.converged or correction.linearisation is None:
        raise InputError(
            f"no orbit of period {orbits.period} was found for {model!r}: {correction.failure}; "
            "give a state nearer to it, e.g. the end of a long simulation"
        )
    # Newton's last derivatives were taken beside the orbit: these are its own.
    monodromy = orbits.linearise(correction.z).monodromy
    return PeriodicOrbit(
        model,
        orbits.period,
        orbits.evenly(correction.z),
        orbits.spectrum.whole(floquet_multipliers(monodromy)),
        correction.residual,
    )


GivenState = ArrayLike | Mapping[str, float] | None

MOTION = 2000
"""Forcing periods of a motion that is to settle."""

PERIODS = 8
"""Longest period of forced orbits that is looked for near a state."""

OTHERS = (1, 2, 4, 3)
"""Periods that are tried where a motion from the state repeats after none."""

ROUND = 2000
"""Steps of the integrator in which a motion that begins near a cycle comes round."""

CLOSED = 0.05
"""A motion that comes back this near, over its extent or in scaled states, is near an orbit."""


def settled_on(
    model: Model, state: GivenState = None, observer: Observer | None = None
) -> PeriodicOrbit | Array:
    """Return what a motion from a state settles on."""
    periods = MOTION if model.forced else None
    motion = simulate_smooth_or_switched(model, periods, state, observer=observer)
    if motion.stopped is not None and motion.stopped.kind == "interrupted":
        raise KeyboardInterrupt
    found, last = motion.settlement, motion.strobe[-1]
    if found.period is None:
        raise InputError(
            f"the motion of {model.name} does not settle on what could be followed ({found}); "
            "start elsewhere, or follow the response"
        )
    if found.kind == "equilibrium":
        return last
    if found.kind == "cycle":
        return periodic_orbit(model, state=last, duration=found.duration)
    return periodic_orbit(model, found.period, last)


def orbit_near(model: Model, state: GivenState) -> PeriodicOrbit | Array:
    """Return an orbit near a state; of an autonomous model an equilibrium, or a cycle.

    Newton's method is begun there, of a forced model with the period after which a motion from the
    state nearly repeats. A cycle is looked for where the motion comes nearly back.
    """
    start = initial_state(model, state)
    if model.forced:
        return _forced_orbit(model, start)
    if _comes_back(model, start):
        with suppress(InputError):
            return periodic_orbit(model, state=start)
    found = search_equilibrium(model, start)
    if found is None:
        raise InputError(
            f"neither a cycle nor an equilibrium of {model.name} was found near the state "
            f"{start.tolist()}; start nearer to one, or follow what a motion settles to"
        )
    return found


def _forced_orbit(model: Model, start: Array) -> PeriodicOrbit:
    constants = flow_of(model).constants_of(model)
    strobe = guarded_flow_of(model).strobe(start, PERIODS, constants)
    away = np.abs(without_turns(strobe[1:] - start, model.whole_turns) / constants.scales)
    away = away.max(axis=1)
    likely = [int(k) + 1 for k in np.flatnonzero(away <= CLOSED)]
    failure: InputError | None = None
    for period in dict.fromkeys((*likely[:1], *OTHERS)):
        try:
            return periodic_orbit(model, period, start)
        except InputError as error:
            failure = failure or error
    assert failure is not None
    raise failure


def _comes_back(model: Model, start: Array) -> bool:
    """Whether a motion leaves a state and comes nearly back to it."""
    changed, _ = paced(model, start, None)
    flow = flow_of(changed)
    constants = flow.constants_of(changed)
    motion = flow.dense(start, constants, float(ROUND), ROUND)
    if motion is None:
        return False
    finely = np.linspace(0.0, motion.end, 8 * len(motion.phases))
    apart = without_turns(motion.at(finely) - start, model.whole_turns)
    away = np.linalg.norm(apart / constants.scales, axis=1)
    extent = float(away.max())
    left = np.flatnonzero(away > 0.5 * extent)
    return extent > 0 and bool((away[left[0] :] < CLOSED * extent).any())
