r"""A motion through stick and slip held against its equations, leg by leg, and against friction.

In each leg the equations of its mode hold: :math:`x(b) - x(a) = \int_a^b f(x(t), t)\, dt` on every
step, by quadrature of what lies between its ends. Where it ends what the event says is so, and what
friction bears is no more than it can.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array
from slipfold.collocation_points import gauss_points
from slipfold.flow.equations import Constants
from slipfold.flow.switched.at_the_limit import at_rest
from slipfold.flow.switched.contact_quantities import ContactsNow
from slipfold.flow.switched.events import Ending
from slipfold.flow.switched.mode import Status
from slipfold.flow.switched.switched_flow import Leg, SwitchedFlow
from slipfold.flow.switched.transition import friction_in

POINTS = 12
"""Gauss points a step of an integrator, which is a polynomial of degree 17 or so."""

SEEN = 9
"""Places in each leg at which forces in contacts are looked at, its ends included."""

FORCES = 1e-11
"""Violation of friction that rounding and the ends of events may make, as a share of what is usual:
events count as met 1e-14 beyond zero, and slow slip in the plane comes to an end at 1e-13."""

_GAUSS = gauss_points(POINTS)


@dataclass(frozen=True)
class Held:
    """What a motion lacks."""

    drift: float  # largest sum of what its steps lack, over the size of the states
    forces: float  # largest violation at events and between them, as a share of what is usual


def hold_legs(
    flow: SwitchedFlow, legs: Iterable[Leg], start: Array, constants: Constants, weights: Array
) -> Held:
    """Hold successive legs with all that lies between their ends against equations and friction.

    Shapes: start (n,).
    """
    scales, n = constants.scales, len(start)
    lacking, largest, forces = [np.zeros(n)], float(np.abs(start / scales).max()), 0.0
    before = start
    for leg in legs:
        if leg.polynomials is None or leg.end == leg.begin:
            before = leg.state
            continue
        nodes, phases, lengths = leg.polynomials.nodes(_GAUSS.points)
        states = nodes[..., :n] * scales
        rates = flow.of(leg.seen).rates(states.reshape(-1, n), phases.ravel(), constants)
        rates = rates.reshape(states.shape) * lengths[..., None]
        ends = leg.polynomials(np.array([leg.begin, leg.end]))[:, :n]
        change = np.einsum("k,ikn->n", _GAUSS.weights, rates) / scales
        lacking += [ends[0] - before / scales, ends[1] - ends[0] - change]
        largest = max(largest, float(np.abs(nodes[..., :n]).max()))
        forces = max(forces, _forces(flow, leg, constants, weights))
        before = leg.state
    drift = float(np.abs(np.cumsum(lacking, axis=0)).max()) / max(1.0, largest)
    return Held(drift if math.isfinite(drift) else math.inf, float(forces))


def _forces(flow: SwitchedFlow, leg: Leg, constants: Constants, weights: Array) -> float:
    """Return how far contacts are from what a leg says of them, at worst."""
    assert leg.polynomials is not None
    phases = np.linspace(leg.begin, leg.end, SEEN)
    states = leg.polynomials(phases)[:, : len(leg.state)] * constants.scales
    found, mode, count, places = [0.0], leg.seen, len(leg.mode), flow.quantities.places
    along = flow.quantities.along(states, phases, constants)
    for now in along:
        friction = list[float]()
        if Status.STICK in mode:
            friction = friction_in(now, places, mode, at_rest(flow, mode, now, weights))
        for contact, (status, place) in enumerate(zip(mode, places, strict=True)):
            slip = now.slip[place]
            if status is Status.STICK:
                over = math.hypot(*friction[place]) - now.holding[contact]
                found += [math.hypot(*slip) * weights[contact], over * weights[count + contact]]
            elif status is Status.OPEN:
                found.append(now.normal[contact] * weights[count + contact])
            elif len(slip) == 1:
                found.append(-float(status) * slip[0] * weights[contact])
    return max(*found, _event(flow, leg, along[-1], weights))


def _event(flow: SwitchedFlow, leg: Leg, now: ContactsNow, weights: Array) -> float:
    """Return how far that which ended a leg is from zero."""
    event, count = leg.event, len(leg.mode)
    if event is None or leg.released:
        return 0.0
    which = event.which
    place = flow.quantities.places[which] if which < count else slice(0)
    if event.ending is Ending.STOPS:
        return math.hypot(*now.slip[place]) * float(weights[which])
    if event.ending is Ending.YIELDS:
        rest = at_rest(flow, leg.seen, now, weights)
        friction = friction_in(now, flow.quantities.places, leg.seen, rest)
        over = math.hypot(*friction[place]) - now.holding[which]
        return abs(over) * float(weights[count + which])
    if event.ending in (Ending.PARTS, Ending.MEETS):
        return abs(now.normal[which]) * float(weights[count + which])
    return 0.0
