"""The response of period 1: where Newton's method finds it, or is brought near it."""

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
from slipfold.flow.linear_response import linear_response
from slipfold.models.model import Model
from slipfold.orbits.carry_to import CARRYING, carry_to, hold_parameter
from slipfold.orbits.finding.stiff_response import BUDGET, is_stiff, stiff_response
from slipfold.orbits.finding.stiff_response import SETTLING as PERIODS
from slipfold.orbits.forced_orbits import ForcedOrbits
from slipfold.orbits.limits import broken_limit

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
    f"motion is stiff, and within {sum(PERIODS)} forcing periods or {BUDGET} implicit steps from "
    "rest it comes near no orbit"
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
