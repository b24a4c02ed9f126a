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
from slipfold.flow import flow_of
from slipfold.flow.dense_motion import DenseMotion
from slipfold.flow.implicit.takeover import Takeover
from slipfold.flow.linear_response import linear_response
from slipfold.flow.simulate import simulate
from slipfold.flow.sizes.typical_sizes import measured
from slipfold.models.evaluation import evaluation_of
from slipfold.models.model import Model
from slipfold.models.turns import TURN, without_turns
from slipfold.newton import Rule, find_root, solve_each
from slipfold.orbits.collocation import Collocation
from slipfold.orbits.continued import CARRYING, carry_to, hold_parameter
from slipfold.orbits.eigenvalues import unit_of_time
from slipfold.orbits.kinds import Cycles, ForcedOrbits
from slipfold.orbits.limits import broken_limit
from slipfold.orbits.multipliers import product
from slipfold.orbits.shooting import SEGMENTS

STIFF_SETTLING = (2, 20, 80)
"""Further forcing periods after which Newton's method is begun: two are half a second."""

BUDGET = 60_000
"""Implicit steps in which an orbit is found or given up: half a minute."""

CLOSED = Rule(close=1e-9, iterations=12)
"""The motion before a step this short, in scaled states, is an orbit."""


def is_stiff(orbits: ForcedOrbits, value: float) -> bool:
    """Whether motion from rest decays so fast that it takes implicit steps.

    Not where it leaves the model before a period has passed.
    """
    model = orbits.model.replace(**{orbits.vary: value})
    if model.limits and simulate(model, 1).stopped is not None:
        return False
    constants = orbits.flow.constants(model.vector, orbits.flow_scales)
    return orbits.flow.is_stiff(model.start, constants)


def stiff_response(
    orbits: ForcedOrbits, value: float, tell: Callable[[int], None] = lambda periods: None
) -> tuple[ForcedOrbits, Correction] | None:
    """Return a response of period 1 by collocation, None if motion from rest leads to none.

    What is told is after how many forcing periods the search is.

    The mesh has the steps of the motion, which are short where states turn sharply: of a knee that
    lasts a millionth of the period an even one knows nothing.
    """
    model = orbits.model.replace(**{orbits.vary: value})
    constants = orbits.flow.constants(model.vector, orbits.flow_scales)
    motion = _Search(Takeover(orbits.flow, constants), model, tell).closed()
    if motion is None:
        return None
    edges = motion.phases
    nodes = motion.at(edges[:-1])
    sized = measured(model, motion=nodes)  # what shooting was measured by may be far too small
    free = {orbits.vary: orbits.width}
    even = Collocation(sized, free, edges=edges)
    by = even.on(edges, even.scheme(nodes, constants))
    other = ForcedOrbits(sized, free, by=lambda *_: by)
    return other, correct(other, other.pack(nodes, value), hold_parameter(other.size))


class _Search:
    """The search for a motion that ends where it began after a period."""

    def __init__(self, takeover: Takeover, model: Model, tell: Callable[[int], None]) -> None:
        self._takeover, self._model, self._tell = takeover, model, tell
        self._periods = self._steps = 0

    def closed(self) -> DenseMotion | None:
        """Return such a motion, None where motion from rest leads to none within the budget."""
        state = self._model.start
        for periods in STIFF_SETTLING:
            for _ in range(periods):
                settling = self._period(state)
                if settling is None:
                    return None
                state = _end(settling, self._model)
            found = self._closed_near(state)
            if found is not None:
                return found
        return None

    def _period(self, state: Array) -> DenseMotion | None:
        """Return the motion of a period, None if it does not end or the budget is used up."""
        self._tell(self._periods)
        motion = None if self._steps >= BUDGET else self._takeover.period(state)
        if motion is not None:
            self._periods += 1
            self._steps += len(motion.phases) - 1
        return motion

    def _closed_near(self, state: Array) -> DenseMotion | None:
        """Correct where a motion begins by Newton's method."""
        takeover, model = self._takeover, self._model
        scales, last = takeover.field.scales, None

        def step(scaled: Array) -> Array:
            nonlocal last
            last = self._period(scaled * scales)
            if last is None:
                return np.full_like(scaled, np.nan)
            gap = without_turns(_end(last, model) / scales - scaled, model.whole_turns / scales)
            monodromy = product(takeover.matrices(last, last.phases))
            return solve_each(np.eye(len(gap)) - monodromy[None], gap[None])[0]

        return last if find_root(step, state / scales, CLOSED) is not None else None


def _end(motion: DenseMotion, model: Model) -> Array:
    return without_turns(motion.at(motion.phases[-1:])[0], model.whole_turns)


NEAR = 0.3
"""An orbit this far from the linear response, in scaled states, may belong to another branch."""

SETTLING = (25, 75, 300)
"""Forcing periods after which a motion from rest is tried, one after the other."""

ON_IT = 0.03
"""Distance of a motion from a stable orbit, in scaled states, at which it is on the way to it."""

NEUTRAL = 1e-6
"""Growth in a period that may be rounding, of what nothing damps."""

ITERATIONS = 20

STIFF = (
    f"motion is stiff, and within {sum(STIFF_SETTLING)} forcing periods or {BUDGET} implicit steps "
    "from rest it comes near no orbit"
)

RISING = Coarse(steps=replace(CARRYING.steps, turn=0.6))
"""Of orbits on the way from the quiet state nothing is asked but that they lead on."""


def find_response(
    orbits: ForcedOrbits,
    value: float,
    *,
    implicitly: bool = False,
    tell: Callable[[int], None] = lambda periods: None,
) -> tuple[ForcedOrbits, Correction]:
    """Find the response of period 1 at a value of the parameter; by collocation if it has to be.

    Newton's method corrects the linear response. Where that fails or leads far away, the response
    is followed from the model's quiet state, in the parameter that scales the forcing; where that
    fails as well, a motion is given time to settle. It is asked first where the quiet state is not
    stable: no motion follows what begins there, round folds, while the forcing rises. If Newton's
    method fails and motion is stiff, implicit steps are the only ones that lead on, and taken where
    they may be. What is told is after how many forcing periods a motion is.
    """
    guess = guess_orbit(orbits, value)
    if guess.converged and guess.distance <= NEAR:
        return orbits, guess
    if implicitly and not guess.converged and is_stiff(orbits, value):
        return stiff_response(orbits, value, tell) or (orbits, replace(guess, failure=STIFF))
    return orbits, _found_farther(orbits, value, guess, tell)


def _found_farther(
    orbits: ForcedOrbits, value: float, guess: Correction, tell: Callable[[int], None]
) -> Correction:
    model = orbits.model.replace(**{orbits.vary: value})
    from_rest = partial(_from_rest, orbits, model, value, tell)
    risen = _from_quiet(orbits, model, value, lambda: from_rest(SETTLING[:1], on_it=True))
    if not isinstance(risen, str):
        return risen
    settled = from_rest(SETTLING)
    if settled is not None:
        return settled
    return guess if guess.converged else replace(guess, failure=risen)


def guess_orbit(orbits: ForcedOrbits, value: float) -> Correction:
    """Correct the linear response to a periodic orbit of one forcing period."""
    vector = orbits.model.vector.copy()
    vector[orbits.indices[-1]] = value
    constants = orbits.flow.constants(vector, orbits.flow_scales)
    start = orbits.model.replace(**{orbits.vary: value}).start
    nodes = linear_response(orbits.flow, constants, orbits.scales, orbits.segments, start)
    guess = orbits.pack(nodes, value)
    return correct(orbits, guess, hold_parameter(orbits.size), iterations=15)


def _from_quiet(
    orbits: ForcedOrbits, model: Model, value: float, otherwise: Callable[[], Correction | None]
) -> Correction | str:
    """Follow the response from the quiet state, or say how far it comes.

    Where that state is not stable what is found otherwise comes first.
    """
    quiet = model.quiet
    if quiet is None or not model.values[quiet]:
        return "Newton's method does not converge from the linear response"
    target = model.values[quiet]
    rising = ForcedOrbits(model, {quiet: abs(target)}, 1, orbits.segments, orbits.by.cut)
    rest = guess_orbit(rising, 0.0)
    if not rest.converged:
        return f"there is no rest state with {quiet} = 0: {rest.failure}"
    settled = otherwise() if _growth(rest) > 1 + NEUTRAL else None
    if settled is not None:
        return settled
    reached = carry_to(rising, rest.z, target, lambda point: broken_limit(rising, point.z), RISING)
    if isinstance(reached, Failure):
        return (
            f"followed from {quiet} = 0 it does not reach {quiet} = {target:g} ({reached.reason})"
        )
    found = _corrected(orbits, rising.nodes(reached.z), value)
    return found if found.converged else found.failure


def _growth(found: Correction) -> float:
    """Return the largest modulus of an orbit's multipliers."""
    return float(np.abs(np.linalg.eigvals(found.linearisation.product)).max())


def _from_rest(
    orbits: ForcedOrbits,
    model: Model,
    value: float,
    tell: Callable[[int], None],
    settling: Sequence[int],
    *,
    on_it: bool = False,
) -> Correction | None:
    """Let a motion settle, and correct what it comes to; None where that leads to no orbit.

    If it is to be on the orbit, that is stable and near.
    """
    flow, state, zero = orbits.flow, model.start, np.zeros(1)
    constants = flow.constants(model.vector, orbits.flow_scales)
    for done, periods in zip(accumulate(settling, initial=0), settling, strict=False):
        tell(done)
        state = flow.trajectory(state, constants, np.arange(periods + 1.0), patient=False)[-1]
        if not np.isfinite(state).all():
            return None
        nodes = flow.sample(state[None], zero, zero + 1, orbits.segments, constants)[0]
        found = _corrected(orbits, nodes, value)
        if found.converged and (not on_it or (found.distance <= ON_IT and _growth(found) < 1)):
            return found
    return None


def _corrected(orbits: ForcedOrbits, nodes: Array, value: float) -> Correction:
    guess = orbits.pack(nodes, value)
    return correct(orbits, guess, hold_parameter(orbits.size), iterations=ITERATIONS)


SAMPLES = 8
"""Samples in a unit of time, which is about an eighth of the fastest turn."""

WINDOW = 800
"""Units of time looked at first, then twice as many: about a hundred of the fastest turns."""

WINDOWS = 8
"""Windows after which a motion counts as one that does not come back."""

NEAREST = 3.0
"""The first return that is no farther than this many times the nearest one is taken."""

RETURNED = 0.2
"""A return is nearer to where the motion began than this share of the motion's extent."""

SAME_RETURN = 1e-5
"""Returns within this share of the extent are one: what interpolation between samples is good
for."""

NUDGE = 0.01
"""How far beside an equilibrium a motion is begun, in scaled states."""

AT_REST = 1e-6
"""Motion smaller than this, in scaled states, is an equilibrium."""


def find_cycle(
    model: Model,
    vary: str,
    width: float,
    state: Array | None,
    duration: float | None,
    *,
    tolerance: float = 1e-10,
    settle: int = 400,
) -> tuple[Cycles, Correction]:
    """Return a cycle of an autonomous model near a motion of it."""
    unit = unit_of_time(_jacobian(model, model.start if state is None else state))
    paced = model.replace(duration=unit)
    if state is None:
        state = _motion(paced, _start(paced), WINDOW * max(1, settle // 100))[-1]
        state = without_turns(state, model.whole_turns)
    if duration is None:
        duration = unit * _first_return(paced, state)
    cycle, zero = model.replace(duration=duration), np.zeros(1)
    flow = flow_of(cycle)
    nodes = flow.sample(state[None], zero, zero + 1, SEGMENTS, flow.constants_of(cycle))[0]
    orbits = Cycles(measured(cycle, motion=nodes), {vary: width})
    guess = orbits.join(nodes, [duration, model.values[vary]])
    row = np.eye(1, len(guess), len(guess) - 1)[0]  # the parameter is held
    return orbits, correct(orbits, guess, row, tolerance=tolerance, iterations=20)


def _jacobian(model: Model, state: Array) -> Array:
    return evaluation_of(model).jacobian(model, state)


def _start(model: Model) -> Array:
    """Return where a motion begins that is to find a cycle: not at an equilibrium."""
    functions = evaluation_of(model)
    moving = functions.rates(model, model.start) * model.values["duration"] / model.state_scales()
    if float(np.abs(moving).max()) > AT_REST:
        return model.start
    return model.start + NUDGE * model.state_scales()


def _motion(paced: Model, state: Array, units: int) -> Array:
    """Sample a motion over units of time; refuse one that leaves the model."""
    flow = flow_of(paced)
    grid = np.linspace(0, units, units * SAMPLES + 1)
    motion = flow.trajectory(state, flow.constants_of(paced), grid)
    if not np.isfinite(motion).all():
        raise InputError(
            f"the motion of {paced.name} from {state.tolist()} does not stay finite; give a state "
            "nearer to a cycle"
        )
    return motion


def _first_return(paced: Model, state: Array) -> float:
    """Return after how many units of time a motion first comes back near where it began."""
    scales = paced.state_scales()
    flow = flow_of(paced)
    constants = flow.constants_of(paced)
    for window in range(WINDOWS):  # each begins where the motion has come to: it may still settle
        units = WINDOW * 2**window
        motion = _motion(paced, state, units)
        if float(np.abs((motion - state) / scales).max()) < AT_REST:
            break
        grid = np.linspace(0, units, len(motion))
        rates = flow.rates(motion, grid, constants)
        place = _nearest_passage(
            grid, (motion - state) / scales, rates / scales, paced.whole_turns / scales
        )
        if place is not None:
            return place
        state = motion[-1]
    raise InputError(
        f"the motion of {paced.name} comes to rest or does not come back to where it was; give a "
        "state near a cycle and its duration"
    )


def _on_circles(away: Array, rates: Array, turns: Array) -> tuple[Array, Array]:
    """Return how far angles are ahead as seen from the side of their circle, and at what rates.

    Shapes: away, rates (m, n); turns (n,).
    """
    per = np.where(turns > 0, TURN / np.where(turns > 0, turns, 1.0), 0.0)
    turned = per * away
    ahead = np.where(per > 0, np.sin(turned) / np.where(per > 0, per, 1.0), away)
    return ahead, np.cos(turned) * rates


def _nearest_passage(grid: Array, away: Array, rates: Array, turns: Array) -> float | None:
    """Return the first time at which a motion passes near its begin again, in the same sense."""
    from scipy.interpolate import CubicHermiteSpline  # slow to import, and seldom needed

    extent = float(np.linalg.norm(without_turns(away, turns), axis=1).max())
    forward = rates[0]
    passing, speeds = _on_circles(away, rates, turns)
    ahead = CubicHermiteSpline(grid, passing @ forward, speeds @ forward)
    places = ahead.roots(extrapolate=False)
    places = places[(places > grid[1]) & (ahead(places, 1) > 0)]
    if not len(places):
        return None
    passed = CubicHermiteSpline(grid, away, rates)(places)
    distances = np.linalg.norm(without_turns(passed, turns), axis=1)
    if distances.min() > RETURNED * extent:
        return None
    near = max(NEAREST * distances.min(), SAME_RETURN * extent)
    return float(places[np.flatnonzero(distances <= near)[0]])
