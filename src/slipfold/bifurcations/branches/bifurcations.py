"""The bifurcations of a branch: which zeros of test functions are bifurcations, and which."""

from __future__ import annotations

import operator
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.bifurcations.branches.branch_point import find_crossing
from slipfold.bifurcations.branches.closed_branches import noise_beside_parent, same_orbit
from slipfold.bifurcations.branches.standing import (
    collisions,
    counts,
    rounding,
    seen_without,
    standing_between,
)
from slipfold.continuation.end import End
from slipfold.continuation.interpolation import hermite, lagrange
from slipfold.continuation.locate import ZERO, LostCurveError, insert, locate, point_at
from slipfold.continuation.newton import NEWTON
from slipfold.continuation.search import Zeros, contracts_between, locate_test
from slipfold.continuation.step_length import STEP
from slipfold.continuation.traced_curve import Found, MonitorResult, StepInterval, Stop
from slipfold.orbits.bifurcation_types import BIFURCATION_TYPES, EXTREMUM_TYPES, PAIRED
from slipfold.orbits.continued import parameter_rounding
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
from slipfold.orbits.test_functions import (
    PRODUCTS,
    angles_on_circle,
    evaluate_tests,
    floquet_multipliers,
)
from slipfold.orbits.uncertainty import recomputed

CLOSED = "the branch closed on itself"
"""How a closed curve ends."""


class BIFURCATION:
    """How near is near at bifurcations and ends of branches."""

    # Distance of a critical multiplier from its place; located ones have 1e-8 or less
    on_circle: float = 1e-4
    noise: float = 1e-9  # what rounding leaves of a test function, or of a distance from the circle
    # Arclength to a branch point: nearer to it Newton is singular along the branch
    located: float = 1e-6
    clear: float = 1e-3  # arclength from a branch point at which the tangent is known
    turning: float = 1e-5  # component of the tangent along the parameter that counts as none
    vanished: float = 1e-3  # the same at a fold, over that at its neighbors
    real: float = 1e-7  # imaginary part of a real multiplier: pairs part as a square root
    # Distance from the end of the span, in spans, that may explain a failure
    near_edge: float = 0.01
    steps_over: int = 10  # steps after which a branch is taken to turn before the end
    # Factor of a bound above zero within which a failure is due to the limit
    close_to_limit: float = 5.0
    # States, in their scales, of an orbit without a bound, as at a resonance
    runs_away: float = 1e4
    # Multiplier beyond which a step of 1e-9 is as good as one to another orbit
    sensitive: float = 1e3
    # Arclength from a bifurcation, over the branch, within which the side is undecided
    undecided: float = 1e-5
    outside: float = 1.001  # modulus of a critical multiplier that left the circle between points
    # Arclength over which multipliers are differenced: six digits are left
    differenced: float = 1e-6
    # Difference of the parameter, in spans, of two branch points that are one
    same_value: float = 1e-7
    # Distance from where a branch snakes, in spans, in which nothing is followed
    tail: float = 0.01
    radius: float = 1e-2  # distance around a double branch point at which branches are looked for
    # Difference of multipliers that rounding may make. Spectra of branches that are no images may
    # differ by the square of what the parameter changes by: they are compared over all of this
    alike: float = 1e-9
    compared: float = 0.1  # of the span, for images
    ratio: float = 2.0  # of one change of the parameter at which they are compared to the next
    directions: int = 24  # directions from which they are: twice those of a symmetry D6
    sphere: int = 128  # the same around a point where more than two multipliers are critical
    # Amplitude of cycles looked for beside a Hopf point of several pairs, and directions at a time
    amplitude: float = 0.1
    round: int = 32
    times: int = 3  # directions from which each branch must be found, else more are tried
    most: int = 8  # times as many, at most
    crowded: int = 20  # doublings above which longer periods are on request; a cascade has eight


@dataclass(frozen=True, eq=False)
class SeveralCritical(Found[OrbitPoint]):
    """A point at which several real multipliers are critical at once, as by a symmetry."""

    count: int = 2  # how many
    error: float = np.inf  # of its arclength
    images: int = 0  # branches that are not followed, since they are images of others
    rare: int = 0  # branches that were found from few directions: others may be missing


class Bifurcations(Zeros[OrbitPoint]):
    """The monitor that records the bifurcations of a branch.

    It ends the branch where the branch leaves the span and turns back outside, and where it returns
    to the branch point at which it began.
    """

    def __init__(self, orbits: Orbits, span: tuple[float, float]) -> None:
        super().__init__(orbits)
        self._orbits = orbits
        self._span = span

    def values(self, point: OrbitPoint) -> Array:
        """Return the functions at a point, with zero for a tangent component that is rounding.

        In a canard explosion the parameter is constant to all digits. The sign of its change is
        then that of a rounding error and may differ between any two points.
        """
        values, orbits = point.values, point.curve.orbits
        if orbits.standing is not None:  # what stands may leave the circle and return
            whole = evaluate_tests(point.multipliers, orbits.spectrum.tests)
            values = np.append(values, list(whole.values()))
        if abs(point.tests["LP"]) <= BIFURCATION.noise:
            values = values.copy()
            values[list(point.tests).index("LP")] = 0.0
        return values

    def __call__(self, interval: StepInterval[OrbitPoint]) -> MonitorResult[OrbitPoint]:
        """Return the bifurcations between two points; the first step of a branch has none."""
        if interval.leaves:
            return MonitorResult()
        found = self.between(interval.history, interval.before, interval.point)
        ended = self._left(found, interval) or self._closed(found, interval)
        return ended or self._repeated(found, interval) or MonitorResult(found)

    def between(self, known: list[OrbitPoint], a: OrbitPoint, b: OrbitPoint) -> list[Found]:
        """Return the bifurcations between two points."""
        found = self.search(known, a, b) + collisions(known, a, b, self._orbits)
        found.sort(key=lambda item: item.point.arclength)
        turns = [item.point.arclength for item in found if _turns(item)]
        return [
            item
            for item in found
            if item.type != "LP"
            or all(abs(item.point.arclength - turn) > BIFURCATION.clear for turn in turns)
        ]

    def search(
        self, history: list[OrbitPoint], a: OrbitPoint, b: OrbitPoint, depth: int = 0
    ) -> list[Found]:
        """Return the bifurcations between two points, of what does not stand there.

        What is critical at both ends makes functions zero throughout. It may be fewer in a part.
        """
        orbits, standing = self._orbits, standing_between(a, b)
        if counts(standing) == counts(orbits.standing):
            return super().search(history, a, b, depth)
        points = {id(item): item for item in (a, b, *history)}
        curve, seen = seen_without(standing, orbits, [*points.values()])
        own = dict(zip(points, seen, strict=True))
        known = [own[id(item)] for item in history]
        return Bifurcations(curve, self._span).search(known, own[id(a)], own[id(b)], depth)

    def _left(
        self, found: list[Found], interval: StepInterval[OrbitPoint]
    ) -> MonitorResult[OrbitPoint] | None:
        """Return where the branch leaves the span, if it turns back outside it."""
        low, high = min(self._span), max(self._span)
        value, on = self._orbits.value, STEP.edge * (high - low)
        outside = [item.point for item in found if not low - on <= value(item.point.z) <= high + on]
        if not outside:
            return None
        bound = high if value(outside[0].z) > high else low
        ends = interval.before, outside[0]
        at = locate(self._orbits, interval.history, *ends, lambda item: value(item.z) - bound)
        before = [item for item in found if item.point.arclength < at.arclength]
        return MonitorResult(before, Stop(at, span_end(self._orbits, at)))

    def _closed(
        self, found: list[Found], interval: StepInterval[OrbitPoint]
    ) -> MonitorResult[OrbitPoint] | None:
        """Return the branch point that the branch began at, if it reaches it again."""
        if not interval.traced.departs:
            return None
        orbits, start = self._orbits, interval.traced.points[0]
        for place, item in enumerate(found):
            if item.type != "BP":
                continue
            if same_orbit(orbits, item.point.z, start):
                end = End("closed", CLOSED, orbits.place(item.point.z))
                return MonitorResult(found[:place], Stop(item.point, end, closes=True))
        return None

    def _repeated(
        self, found: list[Found], interval: StepInterval[OrbitPoint]
    ) -> MonitorResult[OrbitPoint] | None:
        """Return where the branch passes two special points again.

        A smooth curve does so only if it is closed.
        """
        passed = [*interval.traced.found, *found]
        for place, item in enumerate(found):
            last = place + len(passed) - len(found)
            again = (
                self._same(passed[earlier], item)
                and self._same(passed[earlier - 1], passed[last - 1])
                for earlier in range(1, last - 1)
            )
            if any(again):
                values = self._orbits.place(item.point.z)
                reason = (
                    f"from {self._orbits.vary} = {values[0]:.9g} on the branch repeats what it "
                    "passed before: a step led onto another branch that comes very close; limit "
                    "the step"
                )
                return MonitorResult(
                    found[:place], Stop(item.point, End("contradiction", reason, values))
                )
        return None

    def _same(self, first: Found, second: Found) -> bool:
        """Whether two special points of the branch are one."""
        if first.type != second.type:
            return False
        orbits, z = self._orbits, second.point.z
        if abs(first.point.z[-1] - z[-1]) > ZERO.blurred:
            return False
        return orbits.distance(orbits.adopt(first.point.curve, first.point.z), z) < ZERO.blurred

    def excludes(self, a: OrbitPoint, b: OrbitPoint) -> bool:
        """Whether perturbations shrink on all orbits between two points."""
        return contracts_between(a, b)

    def located(self, known: list[OrbitPoint], a: OrbitPoint, b: OrbitPoint) -> list[Found]:
        """Return the bifurcations where a test function changes sign between two points."""
        found = []
        if a.orientation != b.orientation:
            found.append(self._branch_point(known, a, b))
        # Where the branch turns at a branch point there is no fold.
        turns = any(_turns(item) for item in found)
        for kind in a.tests:
            if kind != "fold" and not (turns and kind == "LP") and self.changes_sign(kind, a, b):
                test = "fold" if kind == "LP" and _stands(a, b) else kind
                found.append(locate_test(self._orbits, known, a, b, kind, test))
        return [
            item
            for item in found
            if (is_genuine(item) or _is_seen(item, a, b)) and not _undamped(item, a, b)
        ]

    def _branch_point(self, known: list[OrbitPoint], a: OrbitPoint, b: OrbitPoint) -> Found:
        """Locate the branch point where the bordered determinant changes its sign.

        Unlike det(I - M) it does so on both branches, also where one of them turns.
        """

        def determinant(point: OrbitPoint) -> float:
            if point.orientation == 0:  # it is singular, and its volume is not known
                return 0.0
            return point.orientation * float(np.exp(point.volume - a.volume))

        try:
            point = locate(self._orbits, known, a, b, determinant, BIFURCATION.located)
        except LostCurveError:  # so near to it that Newton's method is singular along the branch
            point = self._beside_branch_point(known, a, b)
        # Of the points between, one may lie on the other branch; a and b lie on this one.
        along = hermite([a, b], point.arclength)[1]
        crossing = find_crossing(self._orbits, point, along, float(np.linalg.norm(b.z - a.z)))
        if crossing is None:
            slope = (b.tests["fold"] - a.tests["fold"]) / (b.arclength - a.arclength)
            return Found("BP", point, slope)
        return Found("BP", crossing.point, np.inf, crossing.other, crossing.unsure)

    def _beside_branch_point(
        self, known: list[OrbitPoint], a: OrbitPoint, b: OrbitPoint
    ) -> OrbitPoint:
        """Return a point near a branch point: where the branch turns there, else between two."""
        if self.changes_sign("LP", a, b):
            with suppress(LostCurveError):
                return locate_test(self._orbits, known, a, b, "LP", "LP").point
        near = _narrowest(known, a, b)
        if near is None:
            raise LostCurveError("Newton's method is singular near a branch point")
        arclength = 0.5 * (near[0].arclength + near[1].arclength)
        aside = _on_other_branch(near, b.z - a.z)
        z = hermite(near, arclength)[0] if aside is None else aside.z
        return replace(a, z=z, arclength=arclength)

    def accounts_for(self, found: list[Found], a: OrbitPoint, b: OrbitPoint) -> bool:
        """Whether what was found explains the change in the number of unstable multipliers."""
        change = abs(b.unstable - a.unstable)
        turned = (a.tests["LP"] > 0) != (b.tests["LP"] > 0)
        if not (found or change or turned) or not all(map(is_off_circle, (a, b))):
            return True  # nothing differs, or which side of the circle it is on is not known
        turning = sum(_turns(item) for item in found)
        folds = turning + sum(item.type == "LP" for item in found)
        pairs = sum(item.type in PAIRED for item in found)
        single = len(found) - pairs - turning
        if (turning or not _stands(a, b)) and turned != (folds % 2 == 1):
            return False
        return change <= single + 2 * pairs and (change - single) % 2 == 0

    def changes_sign(self, name: str, a: OrbitPoint, b: OrbitPoint) -> bool:
        """Whether a test function is positive at one of two points only, beyond rounding.

        Along a family of centers, which have one value of the parameter, it is zero throughout,
        with a multiplier on the circle; without damping that of NS is so everywhere, with a pair
        whose product is one. A function alone may be small where none is: it is a product over all
        multipliers, which lie close together where fast decay sets the unit of time. Two real
        multipliers with the product one are a neutral saddle, or both are one, as by a symmetry:
        there Newton's method is singular.
        """
        if name == "LP" and _stands(a, b):  # the sign of the tangent is rounding
            passes = (a.tests["fold"] > 0) != (b.tests["fold"] > 0)
            if not passes or a.orientation * b.orientation < 0:
                return False
            return all(map(is_off_circle, (a, b))) and _passes_one(a, b)
        before, after = a.tests[name], b.tests[name]
        if (before > 0) == (after > 0):
            return False
        if name in PAIRED and _has_real_pair(a) and _has_real_pair(b):
            return False
        off = _off_pair if name in PAIRED else _off_circle
        sizes = (max(abs(point.tests[name]), off(point)) for point in (a, b))
        return any(map(operator.gt, sizes, map(rounding, (a, b))))

    def hidden(
        self, found: list[Found], known: list[OrbitPoint], a: OrbitPoint, b: OrbitPoint
    ) -> list[Found]:
        """Return where several multipliers cross the unit circle at once, which no function shows.

        Functions have double or triple zeros where two or three multipliers or pairs cross at once,
        as symmetry or equal parts of a structure make them do; a triple one is known to the third
        root of rounding. The function of pairs is also zero everywhere where two real multipliers
        have the product one, as those of x'' = x.
        """
        change, turned = abs(b.unstable - a.unstable), any(item.type == "LP" for item in found)
        if turned or change < 2:
            return found
        place = min(a.unstable, b.unstable)

        def critical(point: OrbitPoint) -> Complex:
            return point.moving[place : place + change]

        def growth(point: OrbitPoint) -> float:  # of a volume: that of one direction has corners
            return float(np.log(np.abs(critical(point))).sum())

        point, error = locate(self._orbits, known, a, b, growth, BIFURCATION.located), 0.0
        if np.abs(np.abs(critical(point)) - 1).max() > BIFURCATION.located:
            middle = self._parting(known, a, b)
            if middle is not None:
                sides = (a, middle), (middle, b)
                return [item for side in sides for item in self.search(known, *side, ZERO.depth)]
        if (np.abs(critical(point).imag) < BIFURCATION.real).any():
            point, error = self._interpolated(known, point, growth)
        else:
            point = locate(self._orbits, known, a, b, growth)
        values = critical(point)
        if (np.abs(np.abs(values) - 1) >= BIFURCATION.on_circle).any():
            return found
        slope = (growth(b) - growth(a)) / (b.arclength - a.arclength)
        paired, located = (
            np.abs(values.imag) > BIFURCATION.real,
            {item.type: item for item in found},
        )
        pair = next(name for name in PAIRED if name in a.tests)
        each = {"BP": ~paired & (values.real > 0), "PD": ~paired & (values.real < 0), pair: paired}
        return [
            SeveralCritical(kind, point, slope, count=count, error=error)
            if count > 1 and kind != pair
            else (count <= 2 and located.get(kind)) or Found(kind, point, slope)
            for kind, count in ((kind, int(own.sum())) for kind, own in each.items())
            if count
        ]

    def _parting(self, known: list[OrbitPoint], a: OrbitPoint, b: OrbitPoint) -> OrbitPoint | None:
        """Return a point between the bifurcations of two multipliers, None if none is found."""
        few, many = sorted((a.unstable, b.unstable))
        while b.arclength - a.arclength > BIFURCATION.located:
            places = (a.arclength + part * (b.arclength - a.arclength) for part in ZERO.elsewhere)
            points = (self._point_between(known, a, b, place) for place in places)
            middle = next(filter(is_off_circle, points), None)
            if middle is None or not few <= middle.unstable <= many:
                return None
            insert(known, middle)
            if few < middle.unstable < many:
                return middle
            a, b = (middle, b) if middle.unstable == a.unstable else (a, middle)
        return None

    def _interpolated(
        self, known: list[OrbitPoint], near: OrbitPoint, function: Callable[[OrbitPoint], float]
    ) -> tuple[OrbitPoint, float]:
        """Return the zero of a function at which Newton's method is singular, and its error."""
        places = near.arclength + BIFURCATION.clear * np.array([-2.0, -1.0, 1.0, 2.0])
        around = [point_at(self._orbits, known, place) for place in places.tolist()]
        values, own = [function(point) for point in around], [item.arclength for item in around]
        arclength = float(lagrange(values, 0.0) @ own)
        fewer = [float(lagrange(values[part], 0.0) @ own[part]) for part in (slice(1, 4), slice(3))]
        error = max(abs(arclength - each) for each in fewer)
        z, direction = hermite(around, arclength)
        linearization = self._orbits.linearize(z)
        point = replace(
            near,
            z=z,
            tangent=direction / np.linalg.norm(direction),
            arclength=arclength,
            residual=float(np.abs(linearization.residual).max()),
            linearization=linearization,
            monodromy=linearization.monodromy,
            multipliers=floquet_multipliers(linearization.monodromy),
        )
        return point, error


def span_end(orbits: Orbits, last: OrbitPoint) -> End:
    """Say that a branch reached the end of the span."""
    value = orbits.value(last.z)
    return End("span", f"reached the end of the span at {orbits.vary} = {value:g}", (value,))


def _is_known(point: OrbitPoint) -> bool:
    """Whether a second computation, on another mesh, finds the largest multiplier again.

    Along a canard perturbations grow by 1e30 and decay again: no digit is left, nor the sign.
    """
    again, _ = recomputed(point.curve, point)
    largest = point.multipliers[0]
    return again is None or bool(abs(again.multipliers[0] - largest) < 0.5 * abs(largest))


def _passes_one(a: OrbitPoint, b: OrbitPoint) -> bool:
    """Whether a second computation, on another mesh, also finds that a multiplier passes one.

    In a family, as round a center, one of them is one; towards a homoclinic orbit its rounding
    grows without end. Beside a fold both computations agree at the end that is farther from it.
    """
    first = np.array([point.tests["fold"] for point in (a, b)])
    others = [recomputed(point.curve, point)[0] for point in (a, b)]
    again = np.array([np.nan if other is None else other.tests["fold"] for other in others])
    farther = int(np.abs(first).argmax())
    known = abs(again[farther] - first[farther]) < 0.5 * abs(first[farther])
    return bool(known and again[0] * again[1] < 0)


def _stands(a: OrbitPoint, b: OrbitPoint) -> bool:
    """Whether the sign of the parameter's change is rounding at both points, or an error at one.

    So it is along a family, and through a canard explosion, in which there may be a fold, and
    near a bifurcation that cycles emanate from. A fold then is where a multiplier passes one.
    """
    slopes = [abs(point.tests["LP"]) for point in (a, b)]
    if max(slopes) <= BIFURCATION.noise:
        return True
    if min(slopes) > BIFURCATION.turning and not a.curve.orbits.free_phase:
        return False
    noises = [max(noise_beside_parent(point)[1], slope_noise(point)) for point in (a, b)]
    return any(slope <= noise for slope, noise in zip(slopes, noises, strict=True))


def slope_noise(point: OrbitPoint) -> float:
    """Return what errors of derivatives, magnified beside a branch point, make of the tangent."""
    part = point.linearization
    if part is None or abs(point.tests["LP"]) > BIFURCATION.turning:
        return 0.0
    return parameter_rounding(part.bordered(point.tangent), point.z, NEWTON.still)


def is_off_circle(point: OrbitPoint) -> bool:
    """Whether it is known on which side of the unit circle all multipliers are."""
    return _off_circle(point) > max(BIFURCATION.noise, noise_beside_parent(point)[0])


def _off_circle(point: OrbitPoint) -> float:
    """Return the least distance of a multiplier from the unit circle."""
    return float(np.abs(np.abs(point.moving) - 1).min(initial=np.inf))


def _off_pair(point: OrbitPoint) -> float:
    """Return the least distance of a product of two multipliers from one."""
    return float(np.abs(1 - PRODUCTS["NS"](point.moving)).min(initial=np.inf))


def _has_real_pair(point: OrbitPoint) -> bool:
    """Whether the two multipliers whose product is nearest to one are real."""
    # Two multipliers that meet are known to the root of rounding.
    return bool(np.abs(_nearest_pair(point.moving).imag).max(initial=0.0) < BIFURCATION.located)


def _nearest_pair(values: Complex) -> Complex:
    """Return the two multipliers whose product is nearest to one. Shapes: values (n,)."""
    first, second = np.triu_indices(len(values), k=1)
    if not len(first):
        return values[:0]
    closest = np.abs(1 - values[first] * values[second]).argmin()
    return values[[first[closest], second[closest]]]


def _undamped(found: Found, a: OrbitPoint, b: OrbitPoint) -> bool:
    """Whether several pairs come to the unit circle where the branch ends, without damping.

    Which of them crosses it, if any, is rounding. So it is if others stand and one hardly leaves.
    """
    off = [_off_circle(point) for point in (a, b)]
    standing = found.point.curve.orbits.standing is not None
    several = len(angles_on_circle(found.point.moving)) > 1
    near = (standing and max(off) < BIFURCATION.located) or (
        several and min(off) < max(map(rounding, (a, b)))
    )
    return found.type in PAIRED and near


def may_cross(found: Found) -> int:
    """Count the multipliers that may pass the unit circle where something was located."""
    if found.type not in BIFURCATION_TYPES:  # where contacts change, all may jump
        return 0 if found.type in ("EVENT", *EXTREMUM_TYPES) else len(found.point.multipliers)
    return max(1 + (found.type in PAIRED), count_on_circle(found.point, BIFURCATION.on_circle))


def count_on_circle(point: OrbitPoint, within: float = BIFURCATION.located) -> int:
    """Count the multipliers on the unit circle."""
    return int(np.count_nonzero(np.abs(np.abs(point.moving) - 1) < within))


def _narrowest(known: list[OrbitPoint], a: OrbitPoint, b: OrbitPoint) -> list[OrbitPoint] | None:
    """Return the first two neighbors between two points between which there is a branch point.

    None where one of the two was lost, as beside a branch point at the end of the span.
    """
    between = [item for item in known if a.arclength <= item.arclength <= b.arclength]
    pairs = map(list, pairwise(between))
    return next((pair for pair in pairs if pair[0].orientation != pair[1].orientation), None)


def _on_other_branch(near: list[OrbitPoint], chord: Array) -> OrbitPoint | None:
    """Return the point that lies on the branch that crosses a chord, where there is one.

    Newton's method leaves a branch only next to the crossing.
    """
    least = ZERO.along * float(np.linalg.norm(chord))
    return next((point for point in near if abs(float(point.tangent @ chord)) < least), None)


def _is_seen(found: Found, a: OrbitPoint, b: OrbitPoint) -> bool:
    """Whether the branch shows what was found between two points, whatever multipliers are there.

    Near a homoclinic orbit they pass the unit circle within 1e-6 of arclength, so that rounding
    keeps located ones from it. But the parameter turns there, or branches cross, or the largest
    one, which is known best, changes its sign.
    """
    if found.type == "BP":
        return found.other is not None
    if found.type == "PD":
        first, last = (point.multipliers[0] for point in (a, b))
        changes = min(abs(first), abs(last)) > 1 and bool((first.real < 0) != (last.real < 0))
        return changes and all(map(_is_known, (a, b)))
    steepest = max(abs(a.tests["LP"]), abs(b.tests["LP"]))
    vanished = abs(found.point.tests["LP"]) < BIFURCATION.vanished * steepest
    return found.type == "LP" and vanished and not _stands(a, b)


def is_genuine(found: Found) -> bool:
    """Whether a multiplier is where the type says.

    A neutral saddle has real multipliers whose product is one. Beside a multiplier of 1e7,
    rounding may change the sign of a test function where nothing is on the unit circle.
    """
    values = found.point.multipliers
    if found.type in PAIRED:
        return is_torus(found.point.moving)
    critical = BIFURCATION_TYPES[found.type].critical
    return bool(np.abs(values - critical).min(initial=np.inf) < BIFURCATION.on_circle)


def _turns(found: Found) -> bool:
    """Whether a branch turns at a branch point: its multiplier reaches one and returns.

    If less of the other branch's direction is along the parameter, it is that one which turns, and
    this one has a fold nearby.
    """
    if found.type != "BP":
        return False
    own, other = abs(found.point.tangent[-1]), found.other
    return bool(own < BIFURCATION.turning and (other is None or own <= abs(other[-1])))


def is_torus(values: Complex) -> bool:
    """Whether the product nearest to one is that of a complex pair on the unit circle.

    Shapes: values (n,).
    """
    pair = _nearest_pair(values)
    return bool(
        (np.abs(pair.imag) > BIFURCATION.real).all()
        and (np.abs(np.abs(pair) - 1) < BIFURCATION.on_circle).all()
    )
