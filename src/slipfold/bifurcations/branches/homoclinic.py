"""Branches of cycles whose duration grows without bound, towards a homoclinic orbit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.stops import LOOPS, STOP, Neared
from slipfold.continuation.end import End
from slipfold.continuation.traced_curve import Found, MonitorResult, StepInterval, Stop
from slipfold.models.angles import wrap_angles
from slipfold.newton import Rule, find_root, solve_each
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits


class RULE:
    """When a branch of cycles nears a homoclinic orbit."""

    grown: float = 2.0  # ratio of durations below which nothing is known
    near: float = 0.05  # distance of a cycle from the saddle, in scaled states
    beside: float = 1e-3  # the same where the parameters of a locus do not stand still
    nearby: float = 0.3  # the same of equilibria about to appear: it falls with a root
    proportional: float = 0.1  # relative change of a slope along a straight line
    stands: float = 1e-3  # change of the parameter over that of the duration, in spans
    crawls: int = 100  # points within `arc`: only growth round the cycle makes steps so short
    arc: float = 0.2  # scaled arclength, of which other steps take a tenth each
    snakes: float = 1e-5  # distance of two folds, in spans, after which others are nearer still
    alike: float = 1e-2  # relative difference of what two turns at one value add to the duration


NEWTON = Rule(close=1e-6, iterations=20)
"""Newton's steps from the slowest state of a cycle to an equilibrium."""


def stop_near_homoclinic(
    interval: StepInterval[OrbitPoint], largest: float
) -> MonitorResult[OrbitPoint]:
    """End a branch of cycles on its way to a homoclinic orbit, where it has practically ended.

    Near one the distance of the parameter from its value there falls exponentially with the
    duration (Kuznetsov, Elements of Applied Bifurcation Theory, section 6.4).

    `largest` is the largest duration, relative to that at the first point.
    """
    orbits, points = interval.traced.curve, [*interval.traced.points, interval.point]
    growth, value = _growth(orbits, points), orbits.value(interval.point.z)
    # Steps become short where multipliers of 1e60 leave no digits for longer ones.
    recent = points[-1].arclength - points[-min(RULE.crawls, len(points))].arclength
    crawls = len(points) > RULE.crawls and recent < RULE.arc
    stands = (RULE.stands, 1.0) if crawls else (STOP.constant, RULE.grown)
    kind = LOOPS[0]
    if _stands(orbits, points, *stands) and (neared := _neared(points[-1])):
        kind, loop = neared
        reason = (
            f"the duration grew to {growth:.3g} times that at first while {orbits.vary} stays "
            f"at {value:.9g}: the cycle nears {loop}"
        )
    elif _snakes(interval) and (neared := _neared(points[-1])):
        kind, loop = neared
        reason = (
            f"the last two folds lie within {RULE.snakes:g} of the span of each other, at "
            f"{orbits.vary} = {value:.7g}: the cycle nears {loop}, about which the branch "
            "turns without end"
        )
    elif (added := _added(interval)) is not None:
        first, last = orbits.width * _folds(interval, 2)[0]
        reason = (
            f"the branch turns again and again at {orbits.vary} = {first:.7g}, each time longer"
            f" by about {added[0]:.4g} s, and at {last:.7g}, by about {added[1]:.4g} s, as it "
            "does without end beside orbits homoclinic to a cycle"
        )
    elif growth > largest and (appear := _saddle_node(points)) is not None:
        reason = (
            f"the duration grew past {largest:g} times that at first, as one over the "
            f"root of the distance from about {orbits.vary} = {orbits.width * appear:.3g}, where "
            "equilibria appear on the cycle (a saddle-node on it)"
        )
    elif growth > largest:
        kind = "duration"
        reason = (
            f"the duration grew past {largest:g} times that at first, as it does towards "
            "a homoclinic orbit and in slow relaxation; allow a larger duration to continue"
        )
    else:
        return MonitorResult()
    return MonitorResult(stop=Stop(interval.point, End(kind, reason, (value,))))


def _folds(interval: StepInterval[OrbitPoint], count: int) -> tuple[Array, Array]:
    """Return the places of the last folds of cycles, in spans, and durations, if there are."""
    folds = [item.point for item in interval.traced.found if item.type == "LP"][-count:]
    durations = [point.z[-2] * point.curve.units[-2] for point in folds]
    return np.array([point.z[-1] for point in folds]), np.array(durations)


def _snakes(interval: StepInterval[OrbitPoint]) -> bool:
    """Whether folds of ever longer cycles lie ever closer together."""
    places, durations = _folds(interval, 2)
    return bool(((np.diff(durations) > 0) & (np.abs(np.diff(places)) < RULE.snakes)).any())


def _added(interval: StepInterval[OrbitPoint]) -> Array | None:
    """Return what each of the last two folds adds to the duration if two values take turns.

    Between two tangencies orbits are homoclinic to a saddle cycle (Kuznetsov, section 7.2), and
    cycles near them go round it once more each time; it lasts longer at one of the two.
    """
    places, durations = _folds(interval, 5)
    added = durations[2:] - durations[:-2]
    alike = len(places) == 5 and np.ptp(added[::2]) < RULE.alike * added.min()
    stays = (np.abs(places[2:] - places[:-2]) < RULE.snakes).all()
    return added[1:] if alike and stays else None


def snakes_about(
    found: Sequence[Found[OrbitPoint]], started: End | None, stopped: End | None
) -> list[float]:
    """Return about which values, in spans, a branch turns several times at its ends.

    Beside a saddle-focus it does so without end (Shilnikov; Kuznetsov, section 6.4), and between
    two values where orbits are homoclinic to a cycle.
    """
    folds = [float(item.point.z[-1]) for item in found if item.type == "LP"]
    about = list[float]()
    for end, ends in ((started, folds[:3]), (stopped, folds[:-4:-1])):
        if end is not None and end.kind in LOOPS and len(ends) == 3:
            last, before, third = ends
            about += [last, before] if abs(third - last) < RULE.snakes else [last]
    return about


def nears_homoclinic(orbits: Orbits, points: Sequence[OrbitPoint]) -> Neared:
    """Return which loop is near, and a clause for the sentence of another end."""
    neared = _neared(points[-1]) if _stands(orbits, points, RULE.stands, RULE.grown) else None
    return neared and (
        neared[0],
        f"the duration grew to {_growth(orbits, points):.3g} times that at first while "
        f"{orbits.vary} hardly changes: the cycle nears {neared[1]}",
    )


def _growth(orbits: Orbits, points: Sequence[OrbitPoint]) -> float:
    if not orbits.free_phase:  # of equilibria it is a unit of time
        return 1.0
    first, last = (point.curve.orbits.duration(point.z) for point in (points[0], points[-1]))
    assert first is not None
    assert last is not None
    return float(last / first)


def _stands(orbits: Orbits, points: Sequence[OrbitPoint], fraction: float, grown: float) -> bool:
    """Whether the parameter stands still while the duration grows; at a fold one point may."""
    values = [point.z[-1] for point in points]
    if _growth(orbits, points) < grown or np.ptp(values) < STOP.constant:  # a family of centers
        return False
    unit = points[0].z[-2]
    last = np.array([point.tangent[-2:] for point in points[-2:]])
    return bool((np.abs(last[:, 1]) < fraction * last[:, 0] / unit).all())


def locus_nears(orbits: Orbits, points: Sequence[OrbitPoint]) -> Neared:
    """Return the same of a locus of ever longer cycles that come close to a saddle."""
    growth = _growth(orbits, points)
    neared = _neared(points[-1], RULE.beside) if growth > RULE.grown else None
    return neared and (
        neared[0],
        f"the duration grew to {growth:.3g} times that at first, and the cycle nears {neared[1]}",
    )


def _neared(point: OrbitPoint, near: float = RULE.near) -> Neared:
    """Return which loop a cycle nears that is slowest beside a saddle, None if it is not.

    Only there does a longer one stay longer. Through a canard explosion the parameter stands still
    as well, but the duration has a bound, and no time is spent beside the equilibrium: to come
    `near` and to leave again takes log(1/near) over the largest rates at least.
    """
    saddles = list[Array]()
    for beside in _slow_places(point, point.z, near):
        growth = np.zeros(1) if beside is None else np.linalg.eigvals(beside[1]).real  # a duration
        if beside is not None and min(growth.max(), -growth.min()) > -np.log(near):
            turn = point.curve.orbits.model.angle_periods / point.curve.orbits.scales
            gaps = (np.abs(wrap_angles(beside[0] - other, turn)) for other in saddles)
            if all(gap.max() > RULE.near for gap in gaps):
                saddles.append(beside[0])
        elif not saddles:  # nor is it where the cycle is slowest
            return None
    if len(saddles) > 1:
        return LOOPS[1], f"a heteroclinic loop: orbits that connect {len(saddles)} saddles"
    return LOOPS[0], "a homoclinic orbit"


def _saddle_node(points: Sequence[OrbitPoint]) -> float | None:
    """Return the scaled parameter at which equilibria appear on a cycle, None if none seem to.

    Near there one over the square of the duration is proportional to the distance (Kuznetsov,
    section 7.1). Beyond it there must be an equilibrium where the cycle is slowest, before it none.
    """
    if len(points) < 3:
        return None
    last = points[-3:]
    weights = np.array([point.z[-2] for point in last]) ** -2.0
    values = np.array([point.z[-1] for point in last])
    slopes = np.diff(values) / np.diff(weights)
    if not abs(slopes[0] / slopes[1] - 1) < RULE.proportional:
        return None
    there = float(np.polynomial.Polynomial.fit(weights, values, 2)(0.0))
    beyond = last[-1].z.copy()
    beyond[-1] = 2 * there - beyond[-1]
    places = (_slow_places(last[-1], z, RULE.nearby) for z in (beyond, last[-1].z))
    appeared, before = (next(each) is not None for each in places)
    return there if appeared and not before else None


def _slow_places(point: OrbitPoint, z: Array, near: float) -> Iterator[tuple[Array, Array] | None]:
    """Yield the equilibrium beside each place where a cycle is slow, slowest first, or None.

    It has the parameters of z; its scaled state comes with its Jacobian.
    """
    orbits = point.curve.orbits
    constants, flow, zero = orbits.constants(z), orbits.flow, np.zeros(1)
    nodes = orbits.nodes(z)
    speeds = np.linalg.norm(
        flow.rates(nodes, np.zeros(len(nodes)), constants) / orbits.scales, axis=1
    )
    least = np.minimum(np.roll(speeds, 1), np.roll(speeds, -1)) >= speeds

    def step(scaled: Array, start: Array) -> Array:
        if not np.abs(scaled - start).max() < near:
            return np.full_like(scaled, np.nan)
        state = scaled[None] * orbits.scales
        slopes = flow.jacobians(state, zero, constants)
        return -solve_each(slopes, flow.rates(state, zero, constants))[0] / orbits.scales

    for start in nodes[least][speeds[least].argsort()] / orbits.scales:
        scaled = find_root(partial(step, start=start), start, NEWTON)
        yield (
            scaled
            if scaled is None
            else (scaled, flow.jacobians(scaled[None] * orbits.scales, zero, constants)[0])
        )
