"""Branches that close: on themselves, or on a period doubling or Hopf point."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.end import End
from slipfold.continuation.interpolation import POINTS, hermite, well_spaced
from slipfold.continuation.locate import LostCurveError, point_at
from slipfold.continuation.step_length import STEP
from slipfold.continuation.traced_curve import MonitorResult, StepInterval, Stop, TracedCurve
from slipfold.models.angles import wrap_angles
from slipfold.newton import zero_between
from slipfold.orbits.bifurcation_types import CONTACT_TYPES
from slipfold.orbits.orbit_curve import OrbitCurve, OrbitPoint, Orbits


class CLOSING:
    """When branches close."""

    near_one: float = 0.5  # distance of the critical multiplier from one at the last regular orbit
    attempts: int = 12  # to find an orbit nearer to the meeting
    near_origin: float = 0.05  # distance of the end from a bifurcation, interpolated over a step
    small: float = 0.1  # difference of halves, in scales, below which errors of orbits matter
    noise: float = 1e-7  # of multipliers there, of orbits with a residual of 1e-10
    around: float = 1.5  # steps within which a closed curve may pass its first point
    corrections: int = 3  # of the place where the first point lies abeam: each squares the error


SAME_ORBIT = 1e-5
"""Two orbits this close are one: each is known to 1e-9 or better, and steps are much longer."""


def same_orbit(orbits: Orbits, z: Array, point: OrbitPoint) -> bool:
    """Whether an orbit is that of a point of a branch, whatever its phase."""
    return orbits.distance(orbits.adopt(point.curve, point.z), z) < SAME_ORBIT


def has_image(orbits: Orbits) -> bool:
    """Whether each orbit, started half its period later, is another point of the same curve.

    So it is with even periods, and with cycles: they may end where both coincide.
    """
    return orbits.free_phase or orbits.period % 2 == 0


def _meets_its_image(orbits: Orbits, before: OrbitPoint, point: OrbitPoint) -> bool:
    """Whether a branch of doubled period passed its parent and continues as its own copy.

    The copy is the same orbit half a period later, so the difference between the halves of the
    orbit changes sign.
    """
    here, there = asymmetry(orbits, before.z), asymmetry(orbits, point.z)
    # Where angles of the halves come to differ by half a turn, none of them is zero.
    there = here + wrap_angles(there - here, _turns(orbits))
    # A step may also land beside the parent, within what Newton's method can resolve. There
    # small steps leave from, too.
    near = np.linalg.norm(there) < min(0.1 * STEP.emanating, float(np.linalg.norm(here)))
    return bool(here @ there < 0 or near)


def halves_pass_alike(point: OrbitPoint) -> bool:
    """Whether both halves of an orbit pass through the same modes of contacts.

    Others become one only where modes change: there the smooth piece of the branch ends.
    """
    modes = point.piece or ()
    halves = ((each[: len(each) // 2], each[len(each) // 2 :]) for each in modes if len(each) > 1)
    return all(one == other for one, other in halves)


def step_beside_parent(point: OrbitPoint) -> float:
    """Return the longest step that cannot pass the parent by more than its distance.

    Near the parent the halves of the orbit differ by about 1.4 times the arclength to it. A longer
    step could land on another branch that leaves the same parent nearby. The first step, from the
    parent itself, was tried before.
    """
    apart = float(np.linalg.norm(asymmetry(point.curve.orbits, point.z)))
    return max(STEP.emanating, 0.9 * apart) if apart > CLOSING.noise else np.inf


def asymmetry(orbits: Orbits, z: Array) -> Array:
    """Return by how much the halves of an orbit differ, in scaled states.

    Of one node the other half begins half a period later.
    """
    if orbits.segments == 1 and orbits.kind == "periodic":
        nodes, constants = orbits.nodes(z), orbits.constants(z)
        later = orbits.by.states(nodes, constants, np.array([orbits.phase + orbits.period / 2]))
        return wrap_angles((nodes - later)[0] / orbits.scales, _turns(orbits))
    half = orbits.size // 2
    return wrap_angles(z[:half] - z[half : orbits.size], _turns(orbits))


def _turns(orbits: Orbits) -> Array:
    """Return the length of a revolution of each angle in the difference of the halves."""
    if not orbits.by.revolves or (orbits.segments == 1 and orbits.kind == "periodic"):
        return orbits.by.angle_periods
    return np.resize(orbits.by.angle_periods, orbits.size // 2) / np.sqrt(orbits.segments)


def noise_beside_parent(point: OrbitPoint) -> tuple[float, float]:
    """Return what errors make of multipliers, and of the tangent along the parameter.

    Near the equilibrium that cycles emanate from, they do not change with the parameter to first
    order: that component of the tangent vanishes with the amplitude, by which errors of the orbit
    are divided. Elsewhere zeros are returned.
    """
    orbits = point.curve.orbits
    amplitude = float(np.linalg.norm(asymmetry(orbits, point.z))) if orbits.free_phase else np.inf
    if amplitude > CLOSING.small:
        return 0.0, 0.0
    noise = max(CLOSING.noise, orbits.noise)
    return noise, noise / max(amplitude, noise)


def meets_image(
    interval: StepInterval[OrbitPoint], stop: Callable[[OrbitPoint, Array], Stop[OrbitPoint]]
) -> MonitorResult[OrbitPoint]:
    """End a curve where it meets its own copy, the same orbits started half a period later.

    There the orbit is that of the parent's period doubling, or an equilibrium, and Newton's method
    is singular, so the last regular orbit lies a short step before it.

    `stop` says how it ends, of its last regular orbit and the unknown where it meets its copy.
    """
    before, point = interval.before, interval.point
    orbits = interval.traced.curve.orbits
    if interval.leaves or not _meets_its_image(orbits, before, point):
        return MonitorResult()
    if not halves_pass_alike(point):
        if asymmetry(orbits, before.z) @ asymmetry(orbits, point.z) < 0:
            raise LostCurveError("a step led onto the same orbits half their period later")
        return MonitorResult()
    place, meeting = _meeting(interval)
    last = _last(interval, place)
    return MonitorResult(stop=stop(*_approached(interval, last, meeting)))


def _meeting(interval: StepInterval[OrbitPoint]) -> tuple[float, Array]:
    """Return where the halves of the interpolated orbit become the same."""
    orbits, before, point = interval.traced.curve.orbits, interval.before, interval.point
    direction = asymmetry(orbits, before.z)
    near = well_spaced(interval.history, before.arclength, point.arclength, POINTS)
    place = point.arclength
    if direction @ asymmetry(orbits, point.z) < 0:
        place = zero_between(
            lambda s: float(direction @ asymmetry(orbits, hermite(near, s)[0])),
            before.arclength,
            point.arclength,
            close=1e-6,
        )
    return place, hermite(near, place)[0]


def _last(interval: StepInterval[OrbitPoint], place: float) -> OrbitPoint:
    curve, before = interval.traced.curve, interval.before
    orbits = curve.orbits
    direction = asymmetry(orbits, before.z)
    direction /= np.linalg.norm(direction)
    for back in (STEP.emanating, 4 * STEP.emanating, 16 * STEP.emanating):
        if back < place - before.arclength:
            last = point_at(curve, interval.history, place - back)
            # Newton's method may fall onto the parent, where the halves do not differ, or onto
            # the copy, of which beside a Hopf point any phase is near.
            if direction @ asymmetry(orbits, last.z) > 0.3 * back:
                return last
    return before


def _approached(
    interval: StepInterval[OrbitPoint], last: OrbitPoint, meeting: Array
) -> tuple[OrbitPoint, Array]:
    """Return an orbit so near to the meeting that nothing lies between, and where that is."""
    curve = interval.traced.curve
    known = [item for item in interval.history if item.arclength < last.arclength] + [last]
    for _ in range(CLOSING.attempts):
        if len(known) < 2 or np.abs(known[-1].multipliers - 1).min() < CLOSING.near_one:
            break
        nearer = _nearer(curve, known[-2], known[-1])
        if nearer is None:
            break
        known.append(nearer)
    if len(known) > 1:
        further = _extrapolated(curve.orbits, known[-2], known[-1], fraction=0.0)
        meeting = meeting if further is None else further
    return known[-1], meeting


def _nearer(curve: OrbitCurve, before: OrbitPoint, last: OrbitPoint) -> OrbitPoint | None:
    """Return an orbit whose halves differ a fourth as much as those of the last one.

    There this difference distinguishes orbits, and the parameter does not.
    """
    guess = _extrapolated(curve.orbits, before, last, fraction=1 / 4)
    if guess is None:
        return None
    row = -_odd(curve.orbits, last.z)
    point = curve.nearest(guess, row / np.linalg.norm(row))
    if point is None:
        return None
    return replace(point, arclength=last.arclength + float(np.linalg.norm(point.z - last.z)))


def _extrapolated(
    orbits: Orbits, before: OrbitPoint, last: OrbitPoint, fraction: float
) -> Array | None:
    """Return the orbit whose halves differ by a fraction of what they do at the last of two.

    What halves have in common goes with the square of that, beside where a curve meets its copy.
    """
    wider, odd = _odd(orbits, before.z), _odd(orbits, last.z)
    first, second = abs(float(wider @ odd)), float(odd @ odd)
    if not second < first:
        return None
    rise = ((last.z - odd) - (before.z - wider)) / ((first / second) ** 2 - 1)
    return np.asarray(last.z - odd + (1 - fraction**2) * rise + fraction * odd)


def _odd(orbits: Orbits, z: Array) -> Array:
    """Return the part of an orbit that changes sign where it is started half its period later."""
    half = asymmetry(orbits, z) / 2
    halves = [half] if orbits.segments == 1 else [half, -half]
    return np.concatenate([*halves, np.zeros(len(z) - orbits.size)])


def close_on_parent(
    orbits: Orbits,
    children: Sequence[OrbitPoint],
    first: OrbitPoint,
    last: OrbitPoint,
    meeting: Array,
    several: bool = False,
) -> Stop[OrbitPoint]:
    """Return the end of a branch that meets its copy: where another is known to begin, if any.

    `children` are the first points of those. Unless `several` branches leave its first point, it
    cannot come back there.
    """
    alike = {
        child: orbits.adopt(child.curve, child.z)
        for child in children
        if (child.curve.kind, child.curve.period) == (orbits.kind, orbits.period)
    }
    gaps = {child: orbits.distance(z, meeting) for child, z in alike.items()}
    child = min(gaps, key=gaps.__getitem__, default=None)
    if child is not None and not gaps[child] < CLOSING.near_origin:
        child = None
    elif child and first in alike and not several:
        same = orbits.distance(alike[first], alike[child]) < SAME_ORBIT
        child = first if same else child  # it may have been found on another branch as well
    value = orbits.value(meeting if child is None else alike[child])
    where = _place_of_meeting(orbits, meeting)
    if child is first and not several:
        reason = (
            f"no orbit was found away from {where} at {orbits.vary} = {value:.9g}, where the "
            "branch begins: errors of its orbits are as large as the steps that lead to others"
        )
        return Stop(last, End("failed", reason, (value,)))
    reason = f"the branch closed on {where} at {orbits.vary} = {value:.9g}"
    end = End("closed", reason, (value,))
    if child is None:
        return Stop(last, end, reached=replace(last, z=meeting))
    z = orbits.in_phase(alike[child], last.z)
    at = last.arclength + float(np.linalg.norm(z - last.z))
    beyond = orbits.derived_point(z, last.tangent, at, child.monodromy, child.residual)
    return Stop(last, end, beyond)


def _place_of_meeting(orbits: Orbits, meeting: Array) -> str:
    if orbits.period % 2 == 0:
        return "its parent's period doubling"
    doubling = "the period doubling of a cycle of half its duration"
    return "a Hopf point" if rests_at(orbits, meeting) else doubling


def rests_at(orbits: Orbits, z: Array) -> bool:
    """Whether a cycle is hardly more than an equilibrium."""
    states = orbits.evenly(z) / orbits.scales
    apart = float(np.linalg.norm(states - states.mean(axis=0)))
    return orbits.free_phase and apart < CLOSING.near_origin * len(states) ** 0.5


def half_orbit(orbits: Orbits, z: Array) -> tuple[Orbits, Array]:
    """Return the orbit of half the period that is nearest to one whose halves hardly differ."""
    half, free, start = orbits, orbits.free_values(z), orbits.by.start / 2
    if orbits.period % 2 == 0:
        half = orbits.with_period(orbits.period // 2)
        start = half.by.start
    else:  # a cycle, of half the duration
        free[0] /= 2
    rounds = np.concatenate([start, start + orbits.period / 2])
    states = orbits.by.states(orbits.nodes(z), orbits.constants(z), rounds)
    return half, half.join(states.reshape(2, len(start), -1).mean(axis=0), free)


def closes_at_change(traced: TracedCurve[OrbitPoint]) -> bool:
    """End a doubled branch on the orbit of half its period, if it is that whose contacts change.

    The change is a special point of that orbit's branch.
    """
    after, before = traced.points[-1], traced.points[-2 if len(traced.points) > 1 else -1]
    orbits = after.curve.orbits
    if halves_pass_alike(before) or not has_image(orbits):
        return False
    if np.linalg.norm(asymmetry(orbits, after.z)) > SAME_ORBIT:
        return False
    if after.piece != before.piece:
        traced.points.pop()
    assert traced.end is not None
    place = traced.end.values
    last = traced.found[-1] if traced.found else None
    if last and last.type in CONTACT_TYPES and abs(last.point.z[-1] - after.z[-1]) < SAME_ORBIT:
        traced.found.pop()
    # Orbits of twice the period know the place to 1e-8
    reason = (
        "the branch closed on the orbit of half its period, where contacts of that change, at "
        f"{orbits.vary} = {place[0]:.7g}"
    )
    traced.end = End("closed", reason, place)
    return True


class Returns:
    """Ends a curve where it comes back to its first point, which may be a `singular` one."""

    def __init__(self, curve: OrbitCurve, reason: str, singular: bool = False) -> None:
        self._curve = curve
        self._reason = reason
        self._singular = singular
        self._first: tuple[OrbitPoint | None, Array | None] = None, None

    def __call__(self, interval: StepInterval[OrbitPoint]) -> MonitorResult[OrbitPoint]:
        """Return where the step passed the first point again, if it did."""
        before, point = interval.before, interval.point
        if len(interval.traced.points) < 4:
            return MonitorResult()
        length = point.arclength - before.arclength
        first = self._started_alike(interval.traced.points[0], before.z, length)
        if first is None:
            return MonitorResult()
        along = float((first - before.z) @ before.tangent)
        if not 0 < along < 1.5 * length or np.linalg.norm(first - before.z) > 1.5 * length:
            return MonitorResult()
        passed = self._abeam(interval.history[-3:], first, before.arclength + min(along, length))
        if passed is None:
            return MonitorResult()
        if self._singular:
            return MonitorResult(stop=self._beside(interval, passed.arclength - STEP.emanating))
        end = End("closed", self._reason, self._curve.place(passed.z))
        return MonitorResult(stop=Stop(passed, end, closes=True))

    def _beside(self, interval: StepInterval[OrbitPoint], place: float) -> Stop[OrbitPoint]:
        """End a curve a short step before its first point, which follows from there."""
        first, last, orbits = interval.traced.points[0], interval.before, self._curve.orbits
        if place > last.arclength:
            last = point_at(self._curve, interval.history, place)
        assert self._first[1] is not None
        z = orbits.in_phase(self._first[1], last.z)
        at = last.arclength + float(np.linalg.norm(z - last.z))
        beyond = orbits.derived_point(z, last.tangent, at, first.monodromy, first.residual)
        return Stop(last, End("closed", self._reason, orbits.place(z)), beyond, closes=True)

    def _started_alike(self, first: OrbitPoint, last: Array, length: float) -> Array | None:
        """Return the first orbit started where it lies nearest to the last, None if it is far away.

        Round a closed curve, cycles come back started elsewhere, and on another mesh.
        """
        orbits = self._curve.orbits
        free = len(orbits.units)
        if np.linalg.norm(first.z[-free:] - last[-free:]) > CLOSING.around * length:
            return None
        known, adopted = self._first
        if adopted is None or known is not first:
            adopted = orbits.adopt(first.curve.orbits, first.z)
            self._first = first, adopted
        return orbits.in_phase(adopted, last)

    def _abeam(self, known: list[OrbitPoint], first: Array, place: float) -> OrbitPoint | None:
        """Return the orbit within the step that is the first one; None if there is none.

        The phase that lies nearest to the first is another at each orbit of the step.
        """
        orbits, (before, point) = self._curve.orbits, known[-2:]
        try:
            passed = point_at(self._curve, known, place)
            for _ in range(CLOSING.corrections):
                first = orbits.in_phase(first, passed.z)
                place += float((first - passed.z) @ passed.tangent)
                if not before.arclength < place <= point.arclength + STEP.edge:
                    return None
                passed = point_at(self._curve, known, place)
        except LostCurveError:
            return None
        return passed if orbits.distance(first, passed.z) < SAME_ORBIT else None
