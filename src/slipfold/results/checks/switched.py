"""Trajectories through stick and slip compared with equations, friction and other steps."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Iterable
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.collocation_points import gauss_points
from slipfold.flow.affine_flow import AffineFlow
from slipfold.flow.contact_state import ContactsNow, Instant
from slipfold.flow.contact_trajectory import dense_phases
from slipfold.flow.hybrid_flow import HybridSystem, SmoothPhase, hybrid_system
from slipfold.flow.hybrid_trajectory import Broken, smooth_phases
from slipfold.flow.linearized_trajectory import EventMargin
from slipfold.flow.modes import Ending, Mode, Status, SwitchingEvent, reported_mode
from slipfold.flow.release import at_rest
from slipfold.models.angles import wrap_angles
from slipfold.orbits.multipliers import multiplier_difference
from slipfold.orbits.periodic_orbit import StickSlipOrbit
from slipfold.orbits.switched_shooting import SwitchedShooting
from slipfold.results.checks.checked import CHECKS
from slipfold.results.checks.orbit_difference import Difference


def integrated_again(
    system: HybridSystem, mode: Mode, state: Array, end: float
) -> tuple[Array, list[Mode]]:
    """Integrate a state from phase zero with other steps; return its end and the modes on its way.

    It is NaN if it does not get there. Shapes: state (n,).
    """
    begin, passed = 0.0, [mode]
    try:
        for until in (CHECKS.restart * end, end):
            for part, after in smooth_phases(system, mode, state, until, begin=begin):
                state, mode = part.state, reported_mode(after)
                passed += [mode] if mode != passed[-1] else []
            begin = until
    except Broken:
        return np.full(len(state), np.nan), passed
    return state, passed


# A step of the integrator is a polynomial of degree 17 or so.
_GAUSS = gauss_points(12)


def compare_phases(
    system: HybridSystem, parts: Iterable[SmoothPhase], start: Array
) -> tuple[float, float]:
    """Compare successive phases and all between their ends with equations and friction.

    Returns the largest sum of what steps lack, over the size of the states, and the largest
    violation of friction, as a fraction of the usual force. Shapes: start (n,).
    """
    flow, constants = system.flow, system.constants
    scales, n = constants.scales, len(start)
    lacking, largest, forces = [np.zeros(n)], float(np.abs(start / scales).max()), 0.0
    before = start
    for part in parts:
        if part.polynomials is None or part.end == part.begin:
            before = part.state
            continue
        nodes, phases, lengths = part.polynomials.nodes(_GAUSS.points)
        states = nodes[..., :n] * scales
        own = flow.of(part.reported_mode)
        rates = own.rates(states.reshape(-1, n), phases.ravel(), constants)
        rates = rates.reshape(states.shape) * lengths[..., None]
        ends = part.polynomials(np.array([part.begin, part.end]))[:, :n]
        changes = np.einsum("k,ikn->in", _GAUSS.weights, rates) / scales
        lacks = ends[1] - ends[0] - changes.sum(axis=0)
        steps = getattr(part.polynomials, "times", None)
        if steps is not None and isinstance(own, AffineFlow) and own.takes_many_steps(constants):
            # Fast rates turn rounding of states into much, which decays at once
            slopes = own.jacobians(np.zeros((1, n)), np.zeros(1), constants)
            decay = np.eye(n) - lengths[:, :1, None] * slopes * scales / scales[:, None]
            inside = np.diff(part.polynomials(steps)[:, :n], axis=0) - changes
            lacks = np.linalg.solve(decay, inside[..., None])[..., 0].sum(axis=0)
        lacking += [ends[0] - before / scales, lacks]
        largest = max(largest, float(np.abs(nodes[..., :n]).max()))
        forces = max(forces, _forces(system, part))
        before = part.state
    drift = float(np.abs(np.cumsum(lacking, axis=0)).max()) / max(1.0, largest)
    return drift if math.isfinite(drift) else math.inf, float(forces)


def _forces(system: HybridSystem, part: SmoothPhase) -> float:
    """Return how far contacts are from what a part says of them, at worst."""
    assert part.polynomials is not None
    constants, weights = system.constants, system.weights
    phases = np.linspace(part.begin, part.end, 9)
    states = part.polynomials(phases)[:, : len(part.state)] * constants.scales
    result, mode, count, places = [0.0], part.reported_mode, len(part.mode), system.places
    along = system.flow.quantities.along(states, phases, constants)
    for now in along:
        friction = list[float]()
        if Status.STICK in mode:
            rest = at_rest(system, mode, now)
            friction = Instant(now, places, rest, mode).forces(mode)[0]
        for contact, (status, index) in enumerate(zip(mode, places, strict=True)):
            slip = now.slip[index]
            if status is Status.STICK:
                over = math.hypot(*friction[index]) - now.holding[contact]
                result += [math.hypot(*slip) * weights[contact], over * weights[count + contact]]
            elif status is Status.OPEN:
                result.append(now.normal[contact] * weights[count + contact])
            elif len(slip) == 1:
                result.append(-float(status) * slip[0] * weights[contact])
    return max(*result, _event(system, part, along[-1]))


def _event(system: HybridSystem, part: SmoothPhase, now: ContactsNow) -> float:
    """Return how far that which ended a part is from zero."""
    event, count, weights = part.event, len(part.mode), system.weights
    if event is None or part.released:
        return 0.0
    which = event.which
    place = system.places[which] if which < count else slice(0)
    if event.ending is Ending.STOPS:
        return math.hypot(*now.slip[place]) * float(weights[which])
    if event.ending is Ending.YIELDS:
        rest = at_rest(system, part.reported_mode, now)
        friction = Instant(now, system.places, rest, part.reported_mode).forces(part.reported_mode)[
            0
        ]
        over = abs(math.hypot(*friction[place]) - now.holding[which])
        if over * weights[count + which] > CHECKS.forces:  # a stiff link magnifies rounding
            over = max(0.0, over - _rounding(system, part, event))
        return over * float(weights[count + which])
    if event.ending in (Ending.PARTS, Ending.MEETS):
        return abs(now.normal[which]) * float(weights[count + which])
    return 0.0


def _rounding(system: HybridSystem, part: SmoothPhase, event: SwitchingEvent) -> float:
    """Return what the last digits of the state at an event change in its function."""
    margin = EventMargin(system.flow, part.reported_mode, event, system.constants)
    unchanged = np.empty((len(system.constants.values), 0))
    slopes = margin.slopes(part.state, part.end, unchanged)[0]
    return float(np.finfo(float).eps * np.abs(slopes) @ np.abs(part.state))


def _off_the_middle(
    system: HybridSystem, parts: Iterable[SmoothPhase], contacts: Collection[int]
) -> float:
    """Return how much more friction contacts have left one way than the other, at worst."""
    left = defaultdict[tuple[int, Status], list[float]](list)
    for part in parts:
        if part.polynomials is not None and part.end > part.begin:
            for event in system.flow.mode(part.reported_mode).events:
                if event.ending is Ending.YIELDS and event.which in contacts:
                    margin = EventMargin(system.flow, part.reported_mode, event, system.constants)
                    left[event.which, event.towards].append(_least(margin, part))
    weights, count = system.weights, len(system.places)
    return max(
        abs(min(left[which, Status.FORTH]) - min(left[which, Status.BACK])) * weights[count + which]
        for which in contacts
    )


def _least(margin: EventMargin, part: SmoothPhase) -> float:
    """Return the least value of a margin, searched for in pieces: equal ones hide no less one."""
    assert part.polynomials is not None
    bounds, result = np.linspace(part.begin, part.end, 10), math.inf
    for near in pairwise(bounds):
        for _ in range(5):
            phases = np.linspace(*near, 33)
            states = part.polynomials(phases)[:, : len(part.state)] * margin.constants.scales
            values = margin.values(states, phases)
            at = int(values.argmin())
            near = phases[max(at - 1, 0)], phases[min(at + 1, 32)]
        result = min(result, float(values[at]))
    return result


def switched_difference(orbit: StickSlipOrbit) -> Difference:
    """Return the largest difference in units of what is allowed: of states and of multipliers.

    The orbit is integrated with steps that fall elsewhere and compared with equations and friction;
    so are trajectories near it. Where these have their events in another order, as near a grazing
    orbit, or differ by far more on one side than on the other, as where friction only just holds a
    contact, no multipliers are compared.
    """
    model, end = orbit.model, float(orbit.period)
    system = replace(hybrid_system(model, orbit.state), energies=False)
    by = SwitchedShooting(model, {}, orbit.period)

    def integrated(state: Array) -> tuple[Array, list[Mode]]:
        start = system.held(orbit.first_mode, state, 0.0)
        return integrated_again(system, orbit.first_mode, start, end)

    arrived, order = integrated(orbit.state)
    passed = list(dense_phases(model, orbit.state, orbit.first_mode, end))
    drift, forces = compare_phases(system, passed, orbit.state)
    apart = wrap_angles(arrived - orbit.state, model.angle_periods) / by.sizes
    states = max(float(np.abs(apart).max()), drift, forces * CHECKS.states / CHECKS.forces)
    rest = by.resting(orbit.state[None], system.constants)
    if rest is not None:
        states = max(states, _off_the_middle(system, passed, rest.contacts))
    place = Difference(float(states) if np.isfinite(states) else np.inf)

    def differenced(step: float) -> Array | None:
        columns, scales = [], by.scales
        for one in np.eye(len(scales)):
            (more, first), (less, second) = (
                integrated(orbit.state + sign * step * one * scales) for sign in (1, -1)
            )
            column, bend = (more - less) / scales, (more + less - 2 * arrived) / scales
            if not order == first == second or np.abs(bend).max() > CHECKS.aside:
                return None
            columns.append(column)
        matrix = np.transpose(columns) / (2 * step)
        return matrix if rest is None else rest.left(matrix)

    matrix = differenced(CHECKS.coarse)
    if matrix is None:
        return place
    multipliers = _judged(orbit, matrix)
    if multipliers.excess > 1:
        # Near a grazing, after stick that lasts d, third derivatives grow as d^-3.
        finer = differenced(CHECKS.coarse / 2)
        multipliers = multipliers if finer is None else _extrapolated(orbit, matrix, finer)
    return max(place, multipliers, key=lambda difference: difference.excess)


def _judged(orbit: StickSlipOrbit, matrix: Array) -> Difference:
    """Compare multipliers with those of a matrix of differences, which have lost digits.

    Two that are nearer each other than these digits over what is allowed are known by their mean.
    """
    near = np.finfo(float).eps / CHECKS.coarse**2
    value = multiplier_difference(orbit.multipliers, _values(matrix), near)
    return Difference(value, CHECKS.coarse, what="multipliers")


def _extrapolated(orbit: StickSlipOrbit, matrix: Array, finer: Array) -> Difference:
    """Compare them with differences of two steps, whose error of second order is left out.

    The extrapolated values are as uncertain as a tenth of what the extrapolation changes.
    """
    better = (4 * finer - matrix) / 3
    changed = multiplier_difference(_values(better), _values(finer))
    result = _judged(orbit, better)
    return replace(result, allowed=max(CHECKS.coarse, 0.1 * changed))


def _values(matrix: Array) -> NDArray[np.complex128]:
    return np.linalg.eigvals(matrix).astype(complex)
