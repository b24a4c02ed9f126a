"""Points of codimension two along a locus."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from slipfold.bifurcations.branches.bifurcations import BIFURCATION, is_torus
from slipfold.bifurcations.branches.closed_branches import asymmetry, has_image
from slipfold.bifurcations.loci.locus_equations import LOCUS, LocusEquations
from slipfold.continuation.end import End
from slipfold.continuation.search import Zeros, contracts_between
from slipfold.continuation.traced_curve import Found, MonitorResult, StepInterval, Stop
from slipfold.errors import BREAKDOWNS
from slipfold.orbits.bifurcation_types import CODIMENSION_TWO, DOUBLED, PAIRED, CriticalMultiplier
from slipfold.orbits.critical import crossing_gap
from slipfold.orbits.orbit_curve import OrbitPoint


def on_branch_points(
    found: Found[OrbitPoint], curve: LocusEquations, test: str
) -> tuple[LocusEquations, Found[OrbitPoint]] | None:
    """Return where folds meet branch points as the locus of branch points has it, if it shows it.

    There the equations of folds are singular, or hold along the branch points as well: rounding
    decides how far they lead on, and whether they can be solved again.
    """
    crossing = LocusEquations(curve.orbits, "BP")
    try:
        known = _branch_point(crossing, found.point)
        there = None if known is None else _zero(crossing, known, test)
    except BREAKDOWNS:
        return None
    return None if there is None else (crossing, replace(there, type=found.type))


def has_branch_point(curve: LocusEquations, point: OrbitPoint) -> bool:
    """Whether families of orbits cross near a point: Newton's method converges to where they do."""
    try:
        crossing = LocusEquations(curve.orbits, "BP")
        there = _branch_point(crossing, point)
        return there is not None and float(np.linalg.norm(there.z - point.z)) < LOCUS.branch_points
    except BREAKDOWNS:
        return False


def _branch_point(crossing: LocusEquations, point: OrbitPoint) -> OrbitPoint | None:
    """Return the branch point next to a point, None if Newton's method finds none."""
    z = point.z
    along = np.linalg.svd(crossing.linearize(z).jacobian)[2][-1]
    return crossing.nearest(z, along, point.arclength)


def _zero(curve: LocusEquations, known: OrbitPoint, test: str) -> Found[OrbitPoint] | None:
    """Return the zero of a test function near a branch point, by secants."""
    places, values, place = [0.0], [known.tests[test]], LOCUS.first_secant
    for _ in range(LOCUS.secants):
        guess = known.z + place * known.tangent
        point = curve.nearest(guess, known.tangent, known.arclength)
        if point is None:
            return None
        places.append(place)
        values.append(point.tests[test])
        slope = (values[-1] - values[-2]) / (places[-1] - places[-2])
        if not (np.isfinite(slope) and slope):
            return None
        step = -values[-1] / slope
        if abs(step) < LOCUS.close or values[-1] == 0.0:
            return Found(test, point, slope)
        place += step
        if not abs(place) < LOCUS.branch_points:
            return None
    return None


MIRRORED = "the folds end where a pitchfork turns soft, DP: beyond are their mirror images"

LEFT = "the locus ends at {}, where its orbits become symmetric: beyond are their mirror images"

CROSSED = {("PD", "LPPD"): "BPPD", ("NS", "LPNS"): "BPNS"}
"""What a locus crosses, by its type and by what it would be, where that is no fold."""

CUBIC = ("GPD", "CH", "GH", "DP")
"""Where a coefficient of third order is zero."""

STANDING_STILL = ("first", "second")
"""Where one parameter stands still: an extremum."""

STANDS = {"HB": "ZH", "PD": "BPPD", "NS": "BPNS"}
"""What it is where a locus other than one of folds stands in both parameters: it leaves orbits of a
symmetry there, which have another critical multiplier."""

LEFT_AT = {"HB": ("ZH", "BT", "LPBP"), "PD": ("BPPD",), "NS": ("BPNS", "R1", "LPBP")}
"""The same where a critical pair may be one there too."""


def tests_of(kind: str, tests: Mapping[str, float]) -> tuple[str, ...]:
    """Return the test functions that vanish at a point of codimension two on a locus."""
    fold = next((test for (_, test), name in CROSSED.items() if name == kind), kind)
    names = (kind, fold, *(("R1", "BT") if kind == "LPBP" else ()))
    return next(((name,) for name in names if name in tests), ("first", "second"))


class SpecialPoints(Zeros[OrbitPoint]):
    """Records what is special along a locus, and ends one of tori at a strong resonance.

    Types are ``CPC GPD CH DP R1 R2 R3 R4 LPPD LPNS PDNS NSNS BPPD BPNS LPBP``, of equilibria
    ``CP DP BT GH ZH HH LPBP``, and for extrema ``first`` and ``second`` for the parameter that
    stands still.
    """

    def __init__(self, curve: LocusEquations) -> None:
        super().__init__(curve)
        self._curve = curve

    def __call__(self, interval: StepInterval[OrbitPoint]) -> MonitorResult[OrbitPoint]:
        """Return what is special between two points; the first step from another locus is not."""
        if interval.leaves:
            return MonitorResult()
        result = super().__call__(interval)
        return self._softened(result, interval) if self._curve.condition == "LP" else result

    def _softened(
        self, result: MonitorResult[OrbitPoint], interval: StepInterval[OrbitPoint]
    ) -> MonitorResult[OrbitPoint]:
        """End folds at a degenerate pitchfork, which they reach where the last point is beside it.

        There their equations are singular, and hold along the branch points as well: how far along
        which of the two Newton's method converges is rounding, and so are tests and tangents.
        """
        turns, before = [item for item in result.found if item.type == "DP"], interval.before
        may_be = _near_crossing(before, interval.point) and self._is_symmetric(interval.point)
        beside = turns or [Found("DP", interval.point, 0.0)] * may_be
        exact = on_branch_points(beside[0], self._curve, "DP") if beside else None
        if not (turns or exact):
            return result
        turn = exact[1] if exact else turns[0]
        there, away = turn.point, turn.point.z - before.z
        near = np.linalg.norm(there.z - interval.point.z) < LOCUS.near_parent
        if not turns and not (near and away @ before.tangent > 0):
            return result
        there = replace(there, arclength=before.arclength + float(np.linalg.norm(away)))
        last = replace(beside[0].point, z=there.z, arclength=there.arclength)
        last = replace(last, monodromy=there.monodromy, multipliers=there.multipliers)
        others = [item for item in result.found if item.type not in ("DP", *STANDING_STILL)
                  or np.linalg.norm(item.point.z - there.z) > LOCUS.pitchfork]  # fmt: skip
        end = End("codimension-2", MIRRORED, self._curve.place(there.z))
        return MonitorResult([*others, replace(turn, point=there)], Stop(last, end))

    def excludes(self, a: OrbitPoint, b: OrbitPoint) -> bool:
        """Whether nothing can be found between two points."""
        return contracts_between(a, b)

    def seen(
        self, found: Sequence[Found[OrbitPoint]], interval: StepInterval[OrbitPoint]
    ) -> MonitorResult[OrbitPoint]:
        """Record the points; a pair is real beyond R1 and R2, so that there a torus locus ends."""
        curve = self._curve
        found = without_repeats(self._joined([*found]))
        found = [
            item for item in found if not any(_are_one(old, item) for old in interval.traced.found)
        ]
        left = [item for item in found if item.type in LEFT_AT.get(curve.condition, ())]
        if left and _turns_back(interval) and self._leaves_symmetry(left[0].point):
            point = left[0].point
            found = [item for item in found if item is left[0] or item.type not in STANDING_STILL]
            end = End("codimension-2", LEFT.format(left[0].type), curve.place(point.z))
            return MonitorResult(found, Stop(point, end))
        resonances = [item for item in found if item.type in DOUBLED]
        if curve.condition not in PAIRED or not resonances:
            return MonitorResult(found)
        first = resonances[0]
        reason = f"the locus ends at a strong resonance, {first.type}"
        if first.type == "BT":
            reason = (
                "the locus ends at a Bogdanov-Takens point, BT: the equilibria beyond are neutral "
                "saddles, which are no bifurcation"
            )
        end = End("codimension-2", reason, curve.place(first.point.z))
        return MonitorResult(found, Stop(first.point, end))

    def located(
        self, known: list[OrbitPoint], a: OrbitPoint, b: OrbitPoint
    ) -> list[Found[OrbitPoint]]:
        """Return the special points where a test function changes sign between two points."""
        result = super().located(known, a, b)
        if self._curve.condition == "LP":
            result = _merged(result, "DP", self._is_symmetric, LOCUS.pitchfork)
        return self._joined([self._named(item) for item in result])

    def _joined(self, found: list[Found[OrbitPoint]]) -> list[Found[OrbitPoint]]:
        """Return extrema in both parameters as what stands there."""
        if self._curve.condition == "BP" or self._curve.quantity:
            return found
        if self._curve.condition in STANDS:
            name = STANDS[self._curve.condition]
            found = _merged(found, name, self._leaves_symmetry, LOCUS.pitchfork)
            return [self._doubled(item) if item.type == name else item for item in found]
        resting = self._curve.orbits.kind == "equilibrium"
        return _merged(found, "CP" if resting else "CPC", _stands, LOCUS.same_cusp)

    def _named(self, found: Found) -> Found:
        """Separate a branch point from a fold, where another multiplier is one as well."""
        if found.type in ("R1", "BT") and self._curve.condition in ("LP", "BP"):
            return replace(found, type="LPBP") if _two_vectors(found.point) else found
        name = CROSSED.get((self._curve.condition, found.type))
        crosses = name is not None and self._is_symmetric(found.point)
        return replace(found, type=name) if name is not None and crosses else found

    def _doubled(self, found: Found) -> Found:
        """Rename what is met where the critical pair is one as well, so that no other one is."""
        test = "BT" if self._curve.orbits.kind == "equilibrium" else "R1"
        if self._curve.condition not in PAIRED or found.point.tests[test] > LOCUS.vanishes:
            return found
        return replace(found, type="LPBP" if _two_vectors(found.point) else test)

    def _leaves_symmetry(self, point: OrbitPoint) -> bool:
        """Whether a locus of other orbits leaves those of a symmetry, with the square of both."""
        slopes = abs(point.tests["first"]), abs(point.tests["second"])
        return max(slopes) < LOCUS.double and self._is_symmetric(point)

    def _is_pole_alone(self, point: OrbitPoint) -> bool:
        """Whether a coefficient's zero is that of what is zero where other points have its pole.

        At a branch point that a symmetry keeps, and where what is critical drives nothing else,
        there is none.
        """
        condition, resting = self._curve.condition, self._curve.orbits.kind == "equilibrium"
        if condition == "BP":
            return abs(point.tests["BT" if resting else "R1"]) < LOCUS.vanishes
        fold = {"PD": "LPPD", "NS": "LPNS", "HB": "ZH"}.get(condition)
        return fold is not None and abs(point.tests[fold]) < LOCUS.vanishes

    def _turns_at_parent(self, point: OrbitPoint) -> bool:
        """Whether orbits become those that they emanate from, so that the locus turns as a whole.

        Parameters change with the square of the amplitude there, and both stand still.
        """
        standing = max(abs(point.tests["first"]), abs(point.tests["second"])) < LOCUS.near_parent
        orbits = self._curve.orbits
        if not standing or not has_image(orbits):
            return False
        return float(np.linalg.norm(asymmetry(orbits, point.z))) < LOCUS.near_parent

    def _is_symmetric(self, point: OrbitPoint) -> bool:
        """Whether families of orbits cross at a point, as at a pitchfork."""
        orbits = self._curve.orbits
        if has_image(orbits) and np.linalg.norm(asymmetry(orbits, point.z)) < LOCUS.near_parent:
            return False  # there all families of orbits are near that of their parents
        gap = crossing_gap(orbits, point.z)
        if gap < LOCUS.vanishes:  # with a double zero there, its own equations are singular
            return True
        return gap < LOCUS.pitchfork and has_branch_point(self._curve, point)

    def changes_sign(self, name: str, a: OrbitPoint, b: OrbitPoint) -> bool:
        """Whether a test function does, and not because it is zero along the locus to rounding."""
        largest = max(abs(a.tests[name]), abs(b.tests[name]))
        parallel = name in STANDING_STILL and largest < LOCUS.parallel
        neutral = name in CUBIC and not any(self._curve.coefficient(end.tests) for end in (a, b))
        return not (parallel or neutral) and super().changes_sign(name, a, b)

    def is_genuine(self, found: Found) -> bool:
        """Whether the multipliers are where the type says."""
        if found.type == "measure":  # where the other parameter turns it stands as well
            return abs(found.point.tests[self._curve.held]) > LOCUS.vanishes
        if not self._curve.is_spectral:
            return not (found.type in STANDING_STILL and self._turns_at_parent(found.point))
        condition = self._curve.condition
        others = found.point.beside(condition)
        if found.type in CUBIC and self._is_pole_alone(found.point):
            return False
        if found.type in STANDING_STILL:
            return not self._turns_at_parent(found.point)
        critical = _also_critical(condition, found)
        if critical == "pair":
            return is_torus(others)
        if critical is None:
            return True
        near = LOCUS.double if found.type in (*DOUBLED, "LPBP") else BIFURCATION.on_circle
        return bool(np.abs(others - critical).min() < near)

    def accounts_for(self, found: list[Found], a: OrbitPoint, b: OrbitPoint) -> bool:
        """Whether what was found explains the change in the number of unstable multipliers."""
        if not self._curve.is_spectral:  # multipliers of what continues are not watched
            return True
        change = abs(self._outside(b) - self._outside(a))
        others = [_also_critical(self._curve.condition, item) for item in found]
        pairs = others.count("pair")
        single = len(others) - pairs - others.count(None)
        return change <= single + 2 * pairs and (change - single) % 2 == 0

    def _outside(self, point: OrbitPoint) -> int:
        """Number of multipliers outside the unit circle besides the critical ones."""
        return int(np.count_nonzero(np.abs(point.beside(self._curve.condition)) > 1))


def _near_crossing(before: OrbitPoint, point: OrbitPoint) -> bool:
    """Whether families of orbits may cross just ahead: the distance from that falls so fast.

    It goes in proportion to the way that is left; a few times as much is allowed.
    """
    gaps = [crossing_gap(item.curve.orbits, item.z) for item in (before, point)]
    left = LOCUS.near_parent / (LOCUS.near_parent + point.arclength - before.arclength)
    return gaps[1] < max(2 * left * gaps[0], LOCUS.vanishes)


def _also_critical(condition: str, found: Found) -> CriticalMultiplier | None:
    """Return what is critical at a point besides what makes the locus; None if nothing is."""
    if found.type not in CODIMENSION_TWO:
        return None
    return next(iter(CODIMENSION_TWO[found.type].others(condition)), None)


def _merged(
    found: list[Found], name: str, holds: Callable[[OrbitPoint], bool], reach: float
) -> list[Found]:
    """Replace the extrema in both parameters where something holds by one, the best located."""
    alike = [item for item in found if item.type in STANDING_STILL and holds(item.point)]
    result = [item for item in found if item not in alike]
    places: list[float] = []
    for item in sorted(alike, key=lambda item: -abs(item.slope)):
        place = item.point.arclength
        if not any(abs(place - other) < reach for other in places):
            places.append(place)
            result.append(Found(name, item.point, item.slope))
    return result


def _turns_back(interval: StepInterval[OrbitPoint]) -> bool:
    """Whether both parameters, as far as they change, do so in the other direction after a step."""
    pairs = [(interval.before.tests[name], interval.point.tests[name]) for name in STANDING_STILL]
    changing = [(a, b) for a, b in pairs if max(abs(a), abs(b)) > LOCUS.parallel]
    return bool(changing) and all(a * b < 0 for a, b in changing)


def without_repeats(found: Sequence[Found[OrbitPoint]]) -> list[Found[OrbitPoint]]:
    """Return what was found in parts of a step, or in both directions, but for rounding's repeats.

    Next to each other, several zeros of a function are one if their number is odd, else none.
    """
    result: list[Found[OrbitPoint]] = []
    for item in found:
        near = next((old for old in result if _are_one(old, item)), None)
        if near is None:
            result.append(item)
        elif near.slope * item.slope < 0:
            result.remove(near)
    return result


def _are_one(first: Found[OrbitPoint], second: Found[OrbitPoint]) -> bool:
    """Whether two zeros of a function are so near to each other that rounding parts them."""
    gap = abs(first.point.arclength - second.point.arclength)
    same = getattr(first, "event", None) == getattr(second, "event", None)
    return same and first.type == second.type and gap < LOCUS.same_cusp


def _two_vectors(point: OrbitPoint) -> bool:
    """Whether a double multiplier one has two eigenvectors, as where a fold meets a pitchfork."""
    values, vectors = np.linalg.eig(point.monodromy)
    first, second = vectors[:, np.abs(values - 1).argsort()[:2]].T
    return bool(1 - abs(np.vdot(first, second)) ** 2 > LOCUS.independent**2)


def _stands(point: OrbitPoint) -> bool:
    return max(abs(point.tests["first"]), abs(point.tests["second"])) <= LOCUS.vanishes
