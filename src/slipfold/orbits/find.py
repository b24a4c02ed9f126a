"""A periodic orbit from nothing but a model, or near a state."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from slipfold.arrays import Array
from slipfold.continuation.newton import Correction, correct
from slipfold.errors import InputError, refusal
from slipfold.flow.batches import ROUNDING
from slipfold.flow.equilibrium import with_duration
from slipfold.flow.flow import flow_of
from slipfold.flow.guarded_flow import GuardStop
from slipfold.flow.modes import contacts_of
from slipfold.flow.scales import has_slopes, measured
from slipfold.flow.simulate import HybridIntegration, initial_state, reaches_stick_limit, simulate
from slipfold.models.angles import distances, wrap_angles
from slipfold.models.equilibria import check_followed, search_equilibrium
from slipfold.models.model import Model
from slipfold.models.quantities import DURATION
from slipfold.orbits.continued import fitted, hold_parameter
from slipfold.orbits.extrema import PEAKS
from slipfold.orbits.first_orbits import FIRST, find_cycle, find_response
from slipfold.orbits.kinds import ForcedOrbits, orbits_at
from slipfold.orbits.limits import broken_limit
from slipfold.orbits.modal_shooting import shooting_for
from slipfold.orbits.orbit_curve import Orbits
from slipfold.orbits.periodic_orbit import PeriodicOrbit, StickSlipOrbit
from slipfold.orbits.shooting import SEGMENTS
from slipfold.orbits.switched_shooting import SwitchedShooting
from slipfold.orbits.test_functions import floquet_multipliers
from slipfold.progress import Observer

GivenState = ArrayLike | Mapping[str, float | str] | None


class ORBIT:
    """The search for an orbit near a state."""

    max_period: int = 64  # in forcing periods
    max_settling: int = 10**6  # forcing periods
    revolutions: int = 24  # of a trajectory until it returns, and products of such
    same: float = 1e-7  # distance in scales above which states differ: orbits close to 1e-10
    transient: int = 2000  # forcing periods, or steps in which a trajectory near a cycle returns
    periods: tuple[int, ...] = (1, 2, 4, 3)  # tried where a trajectory does not nearly repeat
    repeated: float = 1e-6  # distance in scales after a period of a motion that nearly repeats
    nearly: float = 1e-2  # the same from which Newton's method may lead to where it converges,
    astray: float = 10.0  # no farther than this multiple of what drift and multipliers say
    between: int = 16  # periods after which it is looked at again
    returned: float = 0.05  # distance over the extent, or in scales, at which an orbit is near


def periodic_orbit(
    model: Model,
    period: int = 1,
    state: GivenState = None,
    *,
    tolerance: float = 1e-10,
    settle: int = 400,
    duration: float | str | None = None,
) -> PeriodicOrbit:
    """Find a periodic orbit of a model.

    Of an autonomous model it is a cycle: the one to which a trajectory from the model's start
    converges, or one near a given state.

    Parameters
    ----------
    model
        The model.
    period
        Period in forcing periods; 1 for an autonomous model.
    state
        State near the orbit at phase zero, shape (n_states,), or some states by name; the others
        are those of the model's own start. Without it the linear response is the guess for period
        1, and the limit of a trajectory from the start for longer periods.
    tolerance
        Largest mismatch of the accepted orbit, in scaled states.
    settle
        Forcing periods in which a trajectory from rest converges, through stick at most; of an
        autonomous model, revolutions.
    duration
        Duration of an autonomous cycle, about, in seconds or with a unit; without it the time after
        which the trajectory returns.

    Raises
    ------
    InputError
        If the period or the state cannot be used or Newton's method does not lead to an orbit of
        this period.

    Examples
    --------
    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
    >>> orbit = periodic_orbit(SlidingOscillator(f=12.2, Nd=0.15), period=2)
    >>> orbit.stable
    True

    Van der Pol's cycle:

    >>> from slipfold.models.registry import model_named
    >>> cycle = periodic_orbit(model_named("vanderpol-free"))
    >>> round(cycle.duration, 9)
    6.663286859
    """
    period = checked_period(period)
    if settle not in range(1, ORBIT.max_settling + 1):
        raise InputError(
            f"settle = {settle!r} is not a whole number from 1 to {ORBIT.max_settling}; "
            "give e.g. 400"
        )
    given = None if state is None else initial_state(model, state)
    on_wall = not may_slip(model)
    if not on_wall:  # a given state may be far from any orbit
        known = contacts_of(model) or has_slopes(model, model.start)
        model = measured(model, start=None if known else given)
    if model.forced and duration is not None:
        raise InputError(
            f"duration = {duration!r} does not fit: {model.name} is forced, its orbits last whole "
            "forcing periods; leave it out, or give period"
        )
    if not model.forced and period != 1:
        raise InputError(
            f"period = {period} counts forcing periods, and {model.name} is autonomous; "
            "leave it out, and give a state near the cycle and its duration"
        )
    if duration is not None:
        duration = float(model.replace(duration=duration).values[DURATION.name])
    near = None if given is None else wrap_angles(given, model.angle_periods)
    search = _Search(model, period, tolerance, settle, duration)
    if not contacts_of(model):
        return search.smooth(near)
    if on_wall:
        return search.through_stick(near)
    if not model.forced:  # one trajectory shows whether it sticks
        try:
            orbit = search.through_stick(near)
        except InputError:
            with suppress(InputError):
                return search.smooth(near)
            raise
        return search.in_slip(orbit)
    guess = near
    if near is not None or period > 1:  # else the linear response is the guess
        motion = simulate(model, settle if near is None else period, near, through_stick=False)
        if reaches_stick_limit(motion.stopped, model):
            orbit = search.through_stick(near)
            return search.in_slip(orbit)
        guess = motion.states[-1] if near is None else near
    try:
        slips = search.smooth(guess)
    except InputError:
        return search.through_stick(near)
    return slips if _is_in_slip(slips) else search.through_stick(near)


def checked_period(period: float) -> int:
    """Return a period in forcing periods; raise `InputError` for what is none."""
    if period not in range(1, ORBIT.max_period + 1):
        raise InputError(
            f"period = {period!r} is not a whole number from 1 to {ORBIT.max_period}; give e.g. 2"
        )
    return int(period)


def _is_in_slip(orbit: PeriodicOrbit) -> bool:
    """Whether no contact reaches one of its limits on an orbit."""
    orbits = orbits_at(orbit.model, orbit.period, len(orbit.nodes))
    return broken_limit(orbits, orbits.unknown(orbit.nodes, orbit.model)) is None


def may_slip(model: Model) -> bool:
    """Whether there are orbits in slip alone: not where a moving surface is at rest."""
    return not (contacts_of(model) and refusal(check_followed, model))


@dataclass(frozen=True)
class _Search:
    """The search for an orbit of a model."""

    model: Model
    period: int
    tolerance: float
    settle: int
    duration: float | None

    def smooth(self, state: Array | None) -> PeriodicOrbit:
        """Return an orbit on which no contact changes its mode."""
        model, period = self.model, self.period
        if not model.forced:
            return self._cycle(state)
        orbits = orbits_at(model, period, SEGMENTS, by=shooting_for(model))
        assert isinstance(orbits, ForcedOrbits)
        if state is None and period == 1:
            orbits, found = find_response(orbits, model.values[orbits.vary], implicitly=True)
            if not found.converged:
                return self._as_orbit(orbits, found)
            return self._as_orbit(*self._to_the_last_digit(orbits, found.z))
        constants, zero = orbits.flow.constants_of(model), np.zeros(1)
        if state is None:
            span = np.array([0.0, float(self.settle)])
            state = orbits.flow.trajectory(model.start, constants, span)[-1]
            state = wrap_angles(state, model.angle_periods)
        nodes = orbits.flow.sample(state[None], zero, zero + period, orbits.segments, constants)[0]
        orbit = self._as_orbit(*self._to_the_last_digit(orbits, orbits.unknown(nodes, model)))
        states = orbits.flow.sample(orbit.state[None], zero, zero + period, period, constants)[0]
        _refuse_shorter(orbit, states)
        return orbit

    def _to_the_last_digit(self, orbits: Orbits, z: Array) -> tuple[Orbits, Correction]:
        """Correct an orbit, where there is a mesh on one that fits it."""
        found = self._corrected(orbits, z)
        other, z = fitted(orbits, found.z) if found.converged else (orbits, z)
        return (orbits, found) if other is orbits else (other, self._corrected(other, z))

    def through_stick(self, state: Array | None) -> PeriodicOrbit:
        """Return the orbit near the limit of a trajectory with stick and slip."""
        model, forced = self.model, self.model.forced
        start = model.start if state is None else state
        if not forced and state is not None and self.duration is not None:
            timed = model.replace(duration=self.duration)
            orbits = orbits_at(timed, 1, 1, by=SwitchedShooting)
            z = orbits.unknown(state[None], timed)
            if self._mismatch(orbits, z) < ORBIT.repeated:  # its phase is kept
                with suppress(InputError):
                    orbit = self._as_orbit(orbits, self._corrected(orbits, z))
                    if _revolutions(orbit) == 1:  # neither a multiple of a cycle nor at rest
                        return orbit
        # Newton's method takes over from where the trajectory nearly repeats.
        hybrid = HybridIntegration.begin(model, start, own_duration=True, energies=False)
        if forced:
            orbits, z, found = self._repeating(hybrid)
        else:
            motion = hybrid.run(None, ORBIT.repeated)
            _refuse_stopped(motion.stopped)
            settlement = motion.settlement
            if settlement.kind != "cycle" or settlement.duration is None:
                raise InputError(
                    f"the motion of {model.name} converges to no cycle: {settlement.message}; give "
                    "a state near one"
                )
            paced = motion.model.replace(duration=settlement.duration)
            orbits, z, found = self._from_node(paced, motion.states[-1])
        by, z = orbits.by, found.z if found.converged else z
        assert isinstance(by, SwitchedShooting)
        resting = by.rests(orbits.nodes(z), orbits.constants(z)) if forced else None
        if resting is not None:
            raise InputError(resting)
        orbit = self._as_orbit(orbits, found)
        if self.period > 1:
            hybrid = HybridIntegration.begin(orbit.model, orbit.state, own_duration=False)
            _refuse_shorter(orbit, hybrid.run(self.period, ORBIT.same).states)
        return orbit

    def _from_node(self, model: Model, node: Array) -> tuple[Orbits, Array, Correction]:
        """Return the orbit near a state: what it is, a guess, and its correction."""
        orbits = orbits_at(model, self.period, 1, by=SwitchedShooting)
        orbits, z = fitted(orbits, orbits.unknown(node[None], model))
        return orbits, z, self._corrected(orbits, z)

    def _repeating(self, hybrid: HybridIntegration) -> tuple[Orbits, Array, Correction]:
        """Do so where a trajectory nearly repeats, or after all periods.

        Before, Newton's method is believed where perturbations decay so that the trajectory's drift
        leads to the orbit.
        """
        every, nearly = self.period * -(-ORBIT.between // self.period), ORBIT.nearly
        hybrid.advance(self.settle % self.period)  # it begins in the phase in which all would end
        while hybrid.periods < self.settle:
            hybrid.advance(min(every, self.settle - hybrid.periods))
            _refuse_stopped(hybrid.stopped)
            model, (last, before) = hybrid.model, hybrid.states[[-1, -1 - self.period]]
            drift = distances(model, last, before)
            if drift < ORBIT.repeated:
                break
            if drift < nearly:
                nearly *= ORBIT.nearly
                orbits, z, found = self._from_node(model, last)
                if found.converged and found.linearization is not None:
                    growth = np.abs(orbits.eigenvalues(z, found.linearization)).max()
                    away = distances(model, *(orbits.nodes(each)[0] for each in (z, found.z)))
                    if growth < 1 and away * (1 - growth) < ORBIT.astray * drift:
                        return orbits, z, found
        _refuse_stopped(hybrid.stopped)
        last, *before = hybrid.states[: -2 - ORBIT.max_period : -1]
        back = np.flatnonzero(distances(hybrid.model, np.array(before), last) < ORBIT.repeated)
        after = int(back[0]) + 1 if len(back) else self.period
        try:
            orbits, z, found = self._from_node(hybrid.model, last)
            if found.converged or after <= self.period:
                return orbits, z, found
        except InputError:
            if after <= self.period:
                raise
        raise InputError(
            f"the motion of {self.model.name} repeats after {after} forcing periods, not after "
            f"{self.period}; ask for period {after}, or give a state nearer to another"
        )

    def in_slip(self, orbit: PeriodicOrbit) -> PeriodicOrbit:
        """Return an orbit by the smooth flow, unless its contacts stick, open or reverse."""
        if not orbit.sticking:
            with suppress(InputError):
                slips = self.smooth(orbit.state)
                return slips if _is_in_slip(slips) else orbit
        return orbit

    def _cycle(self, state: Array | None) -> PeriodicOrbit:
        model, duration = self.model, self.duration
        while True:
            orbits, guess = find_cycle(model, state, duration, self.settle)
            orbit = self._as_orbit(orbits, self._corrected(orbits, guess))
            revolutions = _revolutions(orbit)
            if revolutions == 1:
                return orbit
            state, duration = orbit.state, orbit.duration / revolutions

    def _corrected(self, orbits: Orbits, guess: Array) -> Correction:
        """Correct a guess, unless it is as good: at folds Newton's method only leads away."""
        row = hold_parameter(len(guess) - 1)
        found = correct(orbits, guess, row, tolerance=self.tolerance, iterations=FIRST.iterations)
        mismatch = self._mismatch(orbits, guess)
        if not mismatch <= self.tolerance or _is_at_rest(orbits, guess):  # closes at any time
            return found
        linearization = orbits.linearize(guess)
        if not linearization.is_finite:
            return found
        if found.converged:
            known = self._mismatch(orbits, found.z)
        else:  # errors of steps, as they grow in a period
            known = ROUNDING * max(1.0, float(np.linalg.norm(linearization.monodromy, 2)))
        if mismatch > known:
            return found
        return replace(
            found, z=guess, linearization=linearization, residual=mismatch, moved=0.0, failure=""
        )

    def _mismatch(self, orbits: Orbits, z: Array) -> float:
        with np.errstate(all="ignore"):
            return orbits.residual(z, orbits.defect(z))

    def _as_orbit(self, orbits: Orbits, correction: Correction) -> PeriodicOrbit:
        failure, duration = correction.failure, orbits.duration(correction.z)
        if not failure and duration is not None and not duration > 0:
            failure = "its duration vanishes, as at an equilibrium"
        if failure or correction.linearization is None:
            raise InputError(
                f"no orbit of period {orbits.period} was found for {self.model!r}: {failure}; "
                + (self.model.advice or "give a state nearer to it, e.g. the end of a simulation")
            )
        orbit = as_orbit(orbits, correction)
        return replace(orbit, model=self.model) if self.model.forced and orbits.by.smooth else orbit


def as_orbit(orbits: Orbits, found: Correction) -> PeriodicOrbit:
    """Return a converged correction as an orbit."""
    # Newton's last derivatives were taken near the orbit: these are its own.
    multipliers = floquet_multipliers(orbits.linearize(found.z).monodromy)
    return (PeriodicOrbit if orbits.by.smooth else StickSlipOrbit)(
        orbits.model_at(found.z),
        orbits.period,
        orbits.evenly(found.z),
        orbits.spectrum.whole(multipliers),
        found.residual,
    )


def _is_at_rest(orbits: Orbits, z: Array) -> bool:
    """Whether a smooth cycle of an autonomous model is an equilibrium."""
    if orbits.model.forced or not orbits.by.smooth:
        return False
    rates = orbits.by.rates(orbits.nodes(z), orbits.constants(z))
    return not np.any(np.abs(rates) > PEAKS.still)


def _refuse_stopped(stopped: GuardStop | None) -> None:
    if stopped is not None:
        raise InputError(f"no orbit was found: {stopped.reason}")


def _revolutions(cycle: PeriodicOrbit) -> int:
    """Return how often a cycle returns to where it began."""
    flow, model, counts = flow_of(cycle.model), cycle.model, np.arange(ORBIT.revolutions, 1, -1)
    if isinstance(cycle, StickSlipOrbit):
        states = np.array([cycle.sample(count)[1][1] for count in counts.tolist()])
    else:
        phases = np.append(0.0, 1 / counts)
        states = flow.trajectory(cycle.state, flow.constants_of(model), phases)[1:]
    back = np.flatnonzero(distances(model, states, cycle.state) < ORBIT.same)
    return int(ORBIT.revolutions - back[0]) if len(back) else 1


def _refuse_shorter(orbit: PeriodicOrbit, states: Array) -> None:
    """Refuse an orbit that repeats within the requested period.

    Shapes: states (period, n) or more, its states after whole forcing periods.
    """
    count, shorter = orbit.period, shortest_period(orbit.model, orbit.period, states)
    if shorter < count:
        raise InputError(
            f"the orbit found for period {count} has period {shorter}; give a state nearer to "
            f"an orbit of period {count}, or ask for period {shorter}"
        )


def shortest_period(model: Model, count: int, states: Array) -> int:
    """Return the forcing periods after which an orbit that repeats after some repeats at first.

    Shapes: states (count, n) or more, its states after whole forcing periods.
    """
    found = (
        shorter
        for shorter in range(1, count)
        if count % shorter == 0 and distances(model, states[shorter], states[0]) < ORBIT.same
    )
    return next(found, count)


# -- near a state --------------------------------------------------------------------------------


def attractor_from(
    model: Model, state: GivenState = None, observer: Observer | None = None
) -> PeriodicOrbit | Array:
    """Return the orbit or equilibrium to which a trajectory from a state converges."""
    periods = ORBIT.transient if model.forced else None
    motion = simulate(model, periods, state, observer=observer)
    if motion.stopped is not None and motion.stopped.kind == "interrupted":
        raise KeyboardInterrupt
    found, last = motion.settlement, motion.states[-1]
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

    Newton's method begins there, for a forced model with the period after which a trajectory from
    the state nearly repeats. A cycle is searched where the trajectory nearly returns.
    """
    start = initial_state(model, state)
    if model.forced:
        return _forced_orbit(model, start)
    if not may_slip(model):
        return periodic_orbit(model, state=start)
    if _returns(model, start):
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
    states = simulate(model, 2 * max(ORBIT.periods), start).states[1:]
    likely = np.flatnonzero(distances(model, states, start) <= ORBIT.returned)[:1] + 1
    failure: InputError | None = None
    for period in dict.fromkeys((*likely.tolist(), *ORBIT.periods)):
        try:
            return periodic_orbit(model, period, start)
        except InputError as error:
            failure = failure or error
    assert failure is not None
    raise failure


def _returns(model: Model, start: Array) -> bool:
    """Whether a trajectory leaves a state and nearly returns to it."""
    changed, _ = with_duration(model, start, None)
    flow = flow_of(changed)
    constants = flow.constants_of(changed)
    motion = flow.dense(start, constants, float(ORBIT.transient), ORBIT.transient)
    if motion is None:
        return False
    finely = np.linspace(0.0, motion.end, 8 * len(motion.phases))
    apart = wrap_angles(motion.at(finely) - start, model.angle_periods)
    away = np.linalg.norm(apart / constants.scales, axis=1)
    extent = float(away.max())
    left = np.flatnonzero(away > 0.5 * extent)
    return extent > 0 and bool((away[left[0] :] < ORBIT.returned * extent).any())
