"""A cycle of an autonomous model from a motion that passes near it."""

from __future__ import annotations

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.newton import Correction, correct
from slipfold.errors import InputError
from slipfold.flow import flow_of
from slipfold.flow.sizes.typical_sizes import measured
from slipfold.models.evaluation import evaluation_of
from slipfold.models.model import Model
from slipfold.models.turns import TURN, without_turns
from slipfold.orbits.cycles import Cycles
from slipfold.orbits.discretisations.shooting import SEGMENTS
from slipfold.orbits.spectrum.eigenvalues import unit_of_time

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
