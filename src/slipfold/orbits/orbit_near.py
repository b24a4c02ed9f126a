"""The orbit, cycle or equilibrium near a state, or that a motion from there settles on."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress

import numpy as np
from numpy.typing import ArrayLike

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow import flow_of
from slipfold.flow.guarded_flow import guarded_flow_of
from slipfold.flow.pace import paced
from slipfold.flow.simulate import initial_state
from slipfold.flow.switched.simulate import simulate_smooth_or_switched
from slipfold.models.equilibrium_search import search_equilibrium
from slipfold.models.model import Model
from slipfold.models.turns import without_turns
from slipfold.orbits.find import periodic_orbit
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.progress import Observer

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
