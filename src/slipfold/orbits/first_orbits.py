"""First orbits: the response of period 1, also where it is stiff, and cycles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import accumulate

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.newton import Correction, correct
from slipfold.continuation.settings import Coarse
from slipfold.continuation.walk import Failure
from slipfold.errors import InputError
from slipfold.flow.equilibrium import linear_responses
from slipfold.flow.flow import flow_of
from slipfold.flow.implicit_steps import StiffFallback
from slipfold.flow.polynomials import DenseTrajectory
from slipfold.flow.scales import measured
from slipfold.flow.simulate import simulate
from slipfold.models.angles import REVOLUTION, wrap_angles
from slipfold.models.model import Model, evaluation_of
from slipfold.newton import Rule, find_root, solve_each
from slipfold.orbits.collocation import Collocation
from slipfold.orbits.continued import CONTINUING, continue_to, hold_parameter
from slipfold.orbits.eigenvalues import unit_of_time
from slipfold.orbits.kinds import ForcedOrbits, orbits_at
from slipfold.orbits.limits import broken_limit
from slipfold.orbits.multipliers import product
from slipfold.orbits.orbit_curve import Orbits
from slipfold.orbits.shooting import SEGMENTS


class FIRST:
    """The search for a first orbit."""

    near: float = 0.3  # distance from the linear response, in scales, beyond which branches differ
    settling: tuple[int, ...] = (25, 75, 300)  # forcing periods from rest, each tried
    iterations: int = 20  # Newton steps from a trajectory on its way to an orbit
    stiff_settling: tuple[int, ...] = (2, 20, 80)  # the same of stiff trajectories
    stiff_steps: int = 60_000  # implicit steps: half a minute
    samples: int = 8  # in a unit of time, an eighth of the fastest revolution
    window: int = 800  # units of time of the first window, a hundred revolutions
    windows: int = 8  # each twice as long as the last, in which a trajectory has to return
    returned: float = 0.2  # fraction of the extent within which it returns to where it began
    at_rest: float = 1e-6  # change in scales below which it is at an equilibrium


STIFF = (
    f"motion is stiff, and within {sum(FIRST.stiff_settling)} forcing periods or "
    f"{FIRST.stiff_steps} implicit steps from rest it comes near no orbit"
)

RISING = Coarse(steps=replace(CONTINUING.steps, turn=0.6))
"""Orbits on the way from zero forcing have to lead on, and nothing else."""


def find_response(
    orbits: ForcedOrbits,
    value: float,
    *,
    implicitly: bool = False,
    on_progress: Callable[[int], None] = lambda periods: None,
) -> tuple[ForcedOrbits, Correction]:
    """Find the response of period 1 at a value of the parameter, by collocation if it is stiff.

    Newton's method corrects the linear response. Where that fails or leads far away, the response
    is followed from zero forcing in the parameter that scales the forcing; where that fails as
    well, a trajectory converges for some time. It comes first where the state without forcing is
    unstable: no trajectory follows what begins there, around folds, while the forcing rises. If
    Newton's method fails for a stiff model, implicit steps are taken where they may be.
    `on_progress` is called with the number of forcing periods that a trajectory has lasted.
    """
    guess = guess_orbit(orbits, value)
    if guess.converged and guess.distance <= FIRST.near:
        return orbits, guess
    model = orbits.model.replace(**{orbits.vary: value})
    if implicitly and not guess.converged and _is_stiff(orbits, model):
        return _stiff_response(orbits, model, on_progress) or (
            orbits,
            replace(guess, failure=STIFF),
        )
    from_rest = partial(_from_rest, orbits, model, value, on_progress)
    risen = _from_zero_forcing(orbits, model, value, from_rest)
    if not isinstance(risen, str):
        return orbits, risen
    settled = from_rest(FIRST.settling)
    if settled is not None:
        return orbits, settled
    return orbits, guess if guess.converged else replace(guess, failure=risen)


def guess_orbit(orbits: ForcedOrbits, value: float) -> Correction:
    """Correct the linear response to a periodic orbit of one forcing period."""
    model = orbits.model.replace(**{orbits.vary: value})
    constants = orbits.flow.constants(model.vector, orbits.flow_scales)
    given = orbits.flow, constants, orbits.scales, orbits.segments, model.start[None]
    return _corrected(orbits, linear_responses(*given)[0], value)


def _from_zero_forcing(
    orbits: ForcedOrbits, model: Model, value: float, from_rest: Callable[..., Correction | None]
) -> Correction | str:
    """Follow the response from zero forcing, or say how far it comes.

    Where the state without forcing is unstable, a trajectory from rest comes first.
    """
    forcing = model.forcing_amplitude
    if forcing is None or not model.values[forcing]:
        return "Newton's method does not converge from the linear response"
    target = model.values[forcing]
    rising = orbits.at_values_of(model).varying({forcing: abs(target)})
    rest = guess_orbit(rising, 0.0)
    if not rest.converged:
        return f"no rest state with {forcing} = 0 was found: {rest.failure}"
    growth = _growth(rest)
    # Growth of an undamped state by rounding is none.
    settled = from_rest(FIRST.settling[:1], stable=True) if growth > 1 + 1e-6 else None
    if settled is not None:
        return settled
    if np.isinf(growth):
        return f"perturbations of the rest state with {forcing} = 0 outgrow all numbers in a period"
    reached = continue_to(
        rising, rest.z, target, lambda point: broken_limit(rising, point.z), RISING
    )
    if isinstance(reached, Failure):
        return (
            f"followed from {forcing} = 0 it does not reach {forcing} = {target:g} "
            f"({reached.reason})"
        )
    found = _corrected(orbits, rising.nodes(reached.z), value)
    return found if found.converged else found.failure


def _growth(found: Correction) -> float:
    """Return the largest modulus of an orbit's multipliers, infinity where their product is."""
    whole = found.linearization.product
    return float(np.abs(np.linalg.eigvals(whole)).max()) if np.isfinite(whole).all() else np.inf


def _from_rest(
    orbits: ForcedOrbits,
    model: Model,
    value: float,
    on_progress: Callable[[int], None],
    settling: Sequence[int],
    *,
    stable: bool = False,
) -> Correction | None:
    """Correct where a trajectory has converged; None where that leads to no orbit, or no stable."""
    flow, state, zero = orbits.flow, model.start, np.zeros(1)
    constants = flow.constants(model.vector, orbits.flow_scales)
    for done, periods in zip(accumulate(settling, initial=0), settling, strict=False):
        on_progress(done)
        state = flow.trajectory(state, constants, np.arange(periods + 1.0), patient=False)[-1]
        if not np.isfinite(state).all():
            return None
        nodes = flow.sample(state[None], zero, zero + 1, orbits.segments, constants)[0]
        found = _corrected(orbits, nodes, value)
        if found.converged and (
            not stable or (found.distance <= FIRST.near / 10 and _growth(found) < 1)
        ):
            return found
    return None


def _corrected(orbits: ForcedOrbits, nodes: Array, value: float) -> Correction:
    guess = orbits.join(nodes, value)
    return correct(orbits, guess, hold_parameter(orbits.size), iterations=FIRST.iterations)


# -- stiff responses -----------------------------------------------------------------------------


def _is_stiff(orbits: ForcedOrbits, model: Model) -> bool:
    """Whether a trajectory from rest decays so fast that it takes implicit steps.

    Not where it leaves the model before a period has passed.
    """
    if model.limits and simulate(model, 1, through_stick=False).stopped is not None:
        return False
    return orbits.flow.is_stiff(
        model.start, orbits.flow.constants(model.vector, orbits.flow_scales)
    )


def _stiff_response(
    orbits: ForcedOrbits, model: Model, on_progress: Callable[[int], None]
) -> tuple[ForcedOrbits, Correction] | None:
    """Return a response of period 1 by collocation, None if a trajectory from rest leads to none.

    The mesh has the steps of the trajectory, which are short where states turn sharply: an even one
    misses a knee that lasts a millionth of the period.
    """
    constants = orbits.flow.constants(model.vector, orbits.flow_scales)
    motion = _StiffSearch(StiffFallback(orbits.flow, constants), model, on_progress).closed()
    if motion is None:
        return None
    edges = motion.phases
    nodes = motion.at(edges[:-1])
    sized = measured(model, motion=nodes)  # the scales of shooting may be far too small
    free = {orbits.vary: orbits.width}
    even = Collocation(sized, free, edges=edges)
    by = even.on(edges, even.scheme(nodes, constants))
    other = ForcedOrbits(sized, free, by=lambda *_: by)
    guess = other.join(nodes, model.values[orbits.vary])
    return other, correct(other, guess, hold_parameter(other.size))


class _StiffSearch:
    """The search for a trajectory in implicit steps that ends where it began after a period."""

    def __init__(
        self, fallback: StiffFallback, model: Model, on_progress: Callable[[int], None]
    ) -> None:
        self._fallback, self._model, self._on_progress = fallback, model, on_progress
        self._periods = self._steps = 0

    def closed(self) -> DenseTrajectory | None:
        """Return such a trajectory, None where none is found within the budget."""
        state = self._model.start
        for periods in FIRST.stiff_settling:
            for _ in range(periods):
                settling = self._period(state)
                if settling is None:
                    return None
                state = self._end(settling)
            found = self._closed_near(state)
            if found is not None:
                return found
        return None

    def _period(self, state: Array) -> DenseTrajectory | None:
        """Return the trajectory of a period, None if it does not end or the budget is used up."""
        self._on_progress(self._periods)
        motion = None if self._steps >= FIRST.stiff_steps else self._fallback.period(state)
        if motion is not None:
            self._periods += 1
            self._steps += len(motion.phases) - 1
        return motion

    def _end(self, motion: DenseTrajectory) -> Array:
        return wrap_angles(motion.at(motion.phases[-1:])[0], self._model.angle_periods)

    def _closed_near(self, state: Array) -> DenseTrajectory | None:
        """Correct the first state by Newton's method; the last trajectory is an orbit."""
        scales, last = self._fallback.field.scales, None

        def step(scaled: Array) -> Array:
            nonlocal last
            last = self._period(scaled * scales)
            if last is None:
                return np.full_like(scaled, np.nan)
            angle_periods = self._model.angle_periods / scales
            gap = wrap_angles(self._end(last) / scales - scaled, angle_periods)
            monodromy = product(self._fallback.matrices(last, last.phases))
            return solve_each(np.eye(len(gap)) - monodromy[None], gap[None])[0]

        found = find_root(step, state / scales, Rule(close=1e-9, iterations=12))
        return None if found is None else last


# -- cycles --------------------------------------------------------------------------------------


def find_cycle(
    model: Model, state: Array | None, duration: float | None, settle: int
) -> tuple[Orbits, Array]:
    """Return cycles of an autonomous model, and a guess of the one near a trajectory."""
    functions, scales = evaluation_of(model), model.state_scales()
    unit = unit_of_time(functions.jacobian(model, model.start if state is None else state))
    paced = model.replace(duration=unit)
    if state is None:
        start = model.start
        if np.abs(functions.rates(paced, start) * unit / scales).max() <= FIRST.at_rest:
            start = start + 0.01 * scales  # beside the equilibrium
        state = _trajectory(paced, start, FIRST.window * max(1, settle // 100))[-1]
        state = wrap_angles(state, model.angle_periods)
    if duration is None:
        duration = unit * _first_return(paced, state)
    cycle, zero = model.replace(duration=duration), np.zeros(1)
    flow = flow_of(cycle)
    nodes = flow.sample(state[None], zero, zero + 1, SEGMENTS, flow.constants_of(cycle))[0]
    orbits = orbits_at(measured(cycle, motion=nodes))
    return orbits, orbits.unknown(nodes, cycle)


def _trajectory(paced: Model, state: Array, units: int) -> Array:
    """Sample a trajectory over units of time; refuse one that leaves the model."""
    flow = flow_of(paced)
    grid = np.linspace(0, units, units * FIRST.samples + 1)
    states = flow.trajectory(state, flow.constants_of(paced), grid)
    if not np.isfinite(states).all():
        raise InputError(
            f"the motion of {paced.name} from {state.tolist()} does not stay finite; give a state "
            "nearer to a cycle"
        )
    return states


def _first_return(paced: Model, state: Array) -> float:
    """Return after how many units of time a trajectory first returns near its beginning."""
    scales, flow = paced.state_scales(), flow_of(paced)
    for window in range(FIRST.windows):  # each begins at the end of the last
        units = FIRST.window * 2**window
        states = _trajectory(paced, state, units)
        if float(np.abs((states - state) / scales).max()) < FIRST.at_rest:
            break
        grid = np.linspace(0, units, len(states))
        rates = flow.rates(states, grid, flow.constants_of(paced))
        found = _nearest_passage(
            grid, (states - state) / scales, rates / scales, paced.angle_periods / scales
        )
        if found is not None:
            return found
        state = states[-1]
    raise InputError(
        f"the motion of {paced.name} comes to rest or does not return to where it was; give a "
        "state near a cycle and its duration"
    )


def _nearest_passage(grid: Array, away: Array, rates: Array, angle_periods: Array) -> float | None:
    """Return the first time at which a trajectory passes near its beginning in the same sense.

    Angles are seen from the side of their circle. Shapes: away, rates (m, n); angle_periods (n,).
    """
    from scipy.interpolate import CubicHermiteSpline  # slow to import, and seldom needed

    extent = float(np.linalg.norm(wrap_angles(away, angle_periods), axis=1).max())
    per = np.where(
        angle_periods > 0, REVOLUTION / np.where(angle_periods > 0, angle_periods, 1.0), 0.0
    )
    passing = np.where(per > 0, np.sin(per * away) / np.where(per > 0, per, 1.0), away)
    forward, speeds = rates[0], np.cos(per * away) * rates
    ahead = CubicHermiteSpline(grid, passing @ forward, speeds @ forward)
    times = ahead.roots(extrapolate=False)
    times = times[(times > grid[1]) & (ahead(times, 1) > 0)]
    if not len(times):
        return None
    passed = CubicHermiteSpline(grid, away, rates)(times)
    distances = np.linalg.norm(wrap_angles(passed, angle_periods), axis=1)
    if distances.min() > FIRST.returned * extent:
        return None
    # The first return that is about as near as the nearest, as far as samples show.
    near = max(3.0 * distances.min(), 1e-5 * extent)
    return float(times[np.flatnonzero(distances <= near)[0]])
