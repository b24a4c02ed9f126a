"""Periods of a trajectory computed again by other means."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.collocation_points import radau_points
from slipfold.flow.batches import LANES
from slipfold.flow.contact_trajectory import dense_phases
from slipfold.flow.equilibrium import EQUILIBRIUM, invariant_groups_of, state_sizes
from slipfold.flow.flow import flow_of
from slipfold.flow.hybrid_flow import hybrid_system
from slipfold.flow.implicit_steps import StiffFallback
from slipfold.flow.trajectory import Trajectory
from slipfold.models.angles import distances, wrap_angles
from slipfold.results.checks.checked import CHECKS, Check, Checked
from slipfold.results.checks.curves import spread
from slipfold.results.checks.orbit_difference import implicit_ends
from slipfold.results.checks.retraced import SampledSolution, retrace
from slipfold.results.checks.switched import compare_phases, integrated_again

IMPLICIT = "implicit steps of another order"
"""How stiff periods are repeated."""

OTHER_POINTS, FINER = radau_points(6), 1e-12
"""Points of their steps, and what the last terms of these may be: twice as many steps as those of
the trajectory, with errors of order 11 instead of 15 where they are not stiff."""

RELATIVE_TO_ITSELF = "other steps, relative to it"
"""How that is compared."""


def check_trajectory(trajectory: Trajectory) -> Checked:
    """Integrate some forcing periods again by other steps, and compare a few with the equations.

    The first finds what goes wrong now and then, the second also what goes wrong always.
    """
    if not trajectory.periods:
        return Checked(())
    try:
        with np.errstate(all="ignore"):  # numbers of a wrong trajectory may overflow
            if trajectory.sticking is not None:
                return Checked((*_compared_with_equations(trajectory), _hybrid_again(trajectory)))
            again = _again(trajectory)
            stiff = any(check.method == IMPLICIT for check in again)
            traced = [] if trajectory.periods < CHECKS.brief or stiff else _retraced(trajectory)
            checks = (*traced, *again, *_smallest(trajectory))
            return Checked(checks, _remark(trajectory, checks))
    except KeyboardInterrupt:
        return Checked((), interrupted=True)


def _again(trajectory: Trajectory) -> list[Check]:
    flow = flow_of(trajectory.model)
    count = min(
        trajectory.periods,
        max(
            CHECKS.again_brief if _short(trajectory) else CHECKS.again,
            trajectory.periods // CHECKS.one_in,
        ),
    )
    free = np.flatnonzero(~_perturbed(trajectory))
    if not len(free):
        return []
    chosen = free[np.linspace(0, len(free) - 1, min(count, len(free))).astype(int)]
    for calls in CHECKS.calls:  # a period may take more steps than one call allows
        ends = _ends(trajectory, trajectory.states[chosen], calls)
        failed = ~np.isfinite(ends).all(axis=1)
        if not failed.any():
            break
        if calls == CHECKS.calls[0]:
            continue
        # Each takes twice the time that the trajectory took for it.
        few = max(2, trajectory.periods // CHECKS.one_in)
        stiff = chosen[failed][np.unique(np.linspace(0, failed.sum() - 1, few).astype(int))]
        fallback = StiffFallback(flow, flow.constants_of(trajectory.model))
        scales, begins = fallback.field.scales, np.zeros(len(stiff))
        # A period of large reversing slip takes five hundred steps.
        options = {"most": 5_000, "points": OTHER_POINTS, "tolerance": FINER}
        scaled = trajectory.states[stiff] / scales
        stiff_ends = scales * implicit_ends(fallback, scaled, begins, begins + 1, **options)
        if np.isfinite(stiff_ends).all():
            result = [repeated(trajectory, stiff, stiff_ends, IMPLICIT)]
            if not failed.all():
                result.append(repeated(trajectory, chosen[~failed], ends[~failed], "other steps"))
            return result
    return [repeated(trajectory, chosen, ends, "other steps")]


def repeated(
    trajectory: Trajectory, chosen: NDArray[np.intp], ends: NDArray[np.float64], method: str
) -> Check:
    """Compare the ends of periods with those of the trajectory."""
    scales = trajectory.model.state_scales()
    size = max(1.0, float(np.abs(trajectory.states / scales).max()))
    apart = distances(trajectory.model, ends, trajectory.states[chosen + 1])
    difference = apart.max(initial=0.0) / size
    difference = float(difference) if np.isfinite(difference) else np.inf
    each = "forcing period" if trajectory.model.forced else "interval"
    plural = "s" if trajectory.periods > 1 else ""
    name = f"repetition of {len(chosen)} of {trajectory.periods} {each}{plural}"
    return Check(name, method, difference, CHECKS.states)


def _smallest(trajectory: Trajectory) -> list[Check]:
    """Integrate again where states of an invariant zero subspace are smallest, relative to them."""
    scaled = np.abs(trajectory.states[:-1] / trajectory.model.state_scales())
    if not ((scaled > 0) & (scaled < CHECKS.coarse)).any():
        return []
    checks = list[Check]()
    for group in map(list, invariant_groups_of(trajectory.model)):
        left = scaled[:, group].max(axis=1)
        place = int(np.where(left > 0, left, np.inf).argmin())
        if not 0 < left[place] < CHECKS.coarse:
            continue
        end = _ends(trajectory, trajectory.states[place][None], 1)[0, group]
        right = trajectory.states[place + 1, group]
        difference = float(np.abs(end - right).max() / np.abs(right).max())
        names = " and ".join(trajectory.model.states[i].name for i in group)
        name = f"{names} from {place * trajectory.forcing_period:.6g} s on, where it is smallest,"
        difference = difference if np.isfinite(difference) else np.inf
        checks.append(Check(name, RELATIVE_TO_ITSELF, difference, CHECKS.states))
    return checks


def _remark(trajectory: Trajectory, checks: Sequence[Check]) -> str:
    """Return what to do where digits are lost, and otherwise whether the trajectory is chaotic."""
    if any(check.method == RELATIVE_TO_ITSELF and not check.agrees for check in checks):
        return "what comes back from so little is not known; write the equation for its logarithm"
    return sensitivity(trajectory)


def _ends(trajectory: Trajectory, states: NDArray[np.float64], calls: int) -> NDArray[np.float64]:
    """Integrate states over a forcing period, in so many calls."""
    flow = flow_of(trajectory.model)
    constants, one = flow.constants_of(trajectory.model), np.ones(len(states))
    for k in range(calls):
        states = flow.advance(states, k / calls * one, (k + 1) / calls * one, constants)
    return states


def _retraced(trajectory: Trajectory) -> list[Check]:
    """Retrace the last, the first and some of the forcing periods between them."""
    flow, scales = flow_of(trajectory.model), trajectory.model.state_scales()
    constants = flow.constants_of(trajectory.model)
    checks, tried = list[Check](), 0
    perturbed = _perturbed(trajectory)
    for place in (place for place in spread(trajectory.periods) if not perturbed[place]):
        few = len(checks) < 2 and tried < 10 * CHECKS.pieces and not _short(trajectory)
        # A piece takes the time in which a period, in its ten to twenty steps, is integrated.
        if checks and not few and tried + CHECKS.pieces > 0.05 * trajectory.periods:
            break
        one = SampledSolution(
            np.array([0.0, 1.0]),
            trajectory.states[place : place + 2],
            constants,
            CHECKS.pieces,
            angle_periods=trajectory.model.angle_periods,
        )
        (result,) = retrace(flow, scales, [one])
        tried += result.tried
        time = f"{place * constants.period:.6g} s"
        checks.append(
            Check(f"the trajectory from {time} on", "quadrature", result.drift, CHECKS.states)
        )
    return checks


def _perturbed(trajectory: Trajectory) -> NDArray[np.bool_]:
    """Whether a period may end with a push off an unstable equilibrium, which no equation makes."""
    if trajectory.model.forced:
        return np.zeros(trajectory.periods, dtype=bool)
    moved = np.abs(np.diff(trajectory.states, axis=0) / trajectory.model.state_scales()).max(axis=1)
    return np.asarray(
        (moved < 2 * EQUILIBRIUM.perturbation) & (moved > EQUILIBRIUM.perturbation / 10)
    )


def _short(trajectory: Trajectory) -> bool:
    return trajectory.periods < (
        CHECKS.short if trajectory.settlement.settled else CHECKS.unsettled
    )


def _hybrid_again(trajectory: Trajectory) -> Check:
    assert trajectory.sticking is not None
    system = hybrid_system(trajectory.model, trajectory.states[0])
    count = -(-trajectory.periods // CHECKS.one_in)
    chosen = np.unique(np.linspace(0, trajectory.periods - 1, count).astype(int))
    ends = [
        integrated_again(system, trajectory.sticking.mode(i), trajectory.states[i], 1.0)[0]
        for i in chosen
    ]
    return repeated(trajectory, chosen, np.array(ends), "other steps")


def _compared_with_equations(trajectory: Trajectory) -> Iterable[Check]:
    """Compare the last period, the first and some between with equations and friction."""
    assert trajectory.sticking is not None
    for place in spread(trajectory.periods)[: -(-trajectory.periods // CHECKS.compared_one_in)]:
        state, mode = trajectory.states[place], trajectory.sticking.mode(place)
        system = hybrid_system(trajectory.model, state)
        drift, forces = compare_phases(
            system, dense_phases(trajectory.model, state, mode, 1.0), state
        )
        time = f"{place * system.constants.period:.6g} s"
        yield Check(f"the trajectory from {time} on", "quadrature", drift, CHECKS.states)
        name = f"friction and its changes from {time} on"
        yield Check(name, "forces", forces, CHECKS.forces, "forces")


def sensitivity(trajectory: Trajectory) -> str:
    """Return a sentence if disturbances grow so much that points are not to be relied on.

    It is empty where they do not, where the trajectory is steady and where it is short.
    """
    if trajectory.periods < CHECKS.long or trajectory.settlement.settled:
        return ""
    length = min(200, math.ceil(CHECKS.segment * trajectory.periods))
    places = np.linspace(0, trajectory.periods - length, LANES).astype(int)
    rates = _growth(trajectory, places, length)
    # Less its error, so that a burst in one of the segments is not taken for lasting growth.
    rate = float(rates.mean() - rates.std() / math.sqrt(LANES))
    if not rate * trajectory.periods > CHECKS.digits:
        return ""
    known = round(CHECKS.digits / float(rates.mean()))
    time = (
        f"{known} periods"
        if trajectory.model.forced
        else f"{known * trajectory.forcing_period:.2g} s"
    )
    return f"the trajectory is sensitive: its single points are known for about {time} only"


def _growth(trajectory: Trajectory, places: NDArray[np.intp], length: int) -> Array:
    """Return the exponents, per period, with which disturbances grow along segments."""
    flow = flow_of(trajectory.model)
    along = trajectory.states[places[:, None] + np.arange(length + 1)]
    sizes = state_sizes(trajectory.model, along)
    signs = np.resize([1.0, -1.0, 1.0], along.shape[2])
    phases = np.tile(np.arange(length + 1.0), (len(places), 1))
    disturbed = along[:, 0] + CHECKS.perturbation * signs * sizes[:, 0]
    states = flow.along(disturbed, phases, flow.constants_of(trajectory.model))
    apart = np.abs(wrap_angles(states - along, trajectory.model.angle_periods))
    apart = (apart / sizes).max(axis=2)
    # Larger disturbances do not grow as small ones do.
    large = apart > 1e-3
    count = np.where(large.any(axis=1), large.argmax(axis=1), length)
    factors = apart[np.arange(len(places)), count] / (
        CHECKS.perturbation * CHECKS.algebraic * count
    )
    return np.asarray(np.log(factors) / count)
