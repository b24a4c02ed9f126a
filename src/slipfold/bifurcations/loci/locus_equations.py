"""The equations of a locus of any kind, and whether a point lies on a known one."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from itertools import pairwise

import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.bifurcations.branches.closed_branches import asymmetry, has_image
from slipfold.bifurcations.branches.known_curves import KNOWN, runs
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.continuation.interpolation import hermite
from slipfold.continuation.locate import LostCurveError, point_at
from slipfold.errors import BREAKDOWNS
from slipfold.orbits.bifurcation_types import BIFURCATION_TYPES, EXTREMUM_TYPES, PAIRED
from slipfold.orbits.critical import Critical
from slipfold.orbits.eigenvalues import eigenvalues_of
from slipfold.orbits.kinds import Equilibria
from slipfold.orbits.linearization import Conditions, Linearization
from slipfold.orbits.marginal import MarginalShooting
from slipfold.orbits.measures import Extremal
from slipfold.orbits.normal_forms.forms import forms_of
from slipfold.orbits.normal_forms.maps import FORMS
from slipfold.orbits.orbit_curve import OrbitCurve, OrbitPoint, Orbits
from slipfold.orbits.test_functions import (
    PRODUCTS,
    Degeneracy,
    Standing,
    collision,
    critical_places,
    floquet_multipliers,
    others_of,
)

PROJECTIONS = 3
"""Corrections of the first orbit of a locus to one of any kind: each squares the error."""


class LOCUS:
    """How near is near along loci: distances in scaled variables, numbers of order one."""

    # Component of a tangent that is rounding: the locus is parallel to an axis
    no_slope: float = 1e-12
    pole: float = 1e-9  # product of test functions at which a coefficient with a pole has no digits
    same_values: float = 1e-7  # parameters, in windows, at which orbits may be symmetric images
    vanishes: float = 1e-6  # test function of order one that is zero where another one was located
    # Tangent along a parameter of a locus that is parallel to the other axis
    parallel: float = 1e-9
    double: float = 1e-3  # distance of a second critical multiplier: a double one parts as a root
    same_cusp: float = 1e-7  # arclength within which two extrema are one cusp
    # The same at a degenerate pitchfork, of third order; its distance to a crossing
    pitchfork: float = 1e-2
    # Halves of an orbit this close: the locus is a parabola and loses digits
    near_parent: float = 0.02
    # Sine between eigenvectors that are two; of one, located to 1e-8, it is 1e-4
    independent: float = 1e-2
    branch_points: float = 0.1  # distance at which folds end at branch points, or cross them
    first_secant: float = 1e-3  # first step along branch points to a degenerate pitchfork
    close: float = 1e-12  # distance to which it is located
    secants: int = 20  # secants to it
    # Smallest singular value, over the largest, of equations that define a curve
    undefined: float = 1e-9
    first_step: float = 0.01  # first step from a regular point: a locus may bend there, near a cusp
    aside: float = 1e-2  # distance from a double Hopf point at which the second locus starts
    moved: float = 1e-3  # distance by which Newton may move a point before it is another one
    resolved: float = 0.1  # fraction of the first step that is not known to be more than rounding
    parent: float = 4.0  # parents lie within so many distances between the halves of an orbit
    parent_points: int = 16  # points of their locus on either side
    # Rounding times the square of the growth in a period: above it cubic coefficients differ by
    # more than some per cent between two computations
    no_digits: float = 1e-4


class LocusEquations(Critical):
    """A locus of bifurcations or of grazing in two parameters: its equations and test functions."""

    odd: tuple[str, ...] = ("first", "second")

    quantity = held = ""
    """What is measured, as in ``"max x"``, on a locus of extrema; else empty."""

    def __init__(self, orbits: Orbits, condition: str) -> None:
        super().__init__(orbits, condition)
        self.forms = forms_of(orbits)
        self._resting = orbits.kind == "equilibrium"

    @property
    def sort(self) -> tuple[Hashable, ...]:
        """Type and quantity, too, are those of curves that may be one."""
        return self.condition, self.quantity, *super().sort

    @property
    def is_spectral(self) -> bool:
        """Whether its orbits have a critical multiplier."""
        return self.condition in BIFURCATION_TYPES

    def aligned(self, guess: Array, known: Array) -> Array:
        """Return a guess in the phase of an orbit; beside one without amplitude, an orbit.

        There the equation of the locus vanishes with a power of the amplitude. Newton's method
        converges only if the others, which do not, are met first.
        """
        guess = super().aligned(guess, known)
        if not has_image(self.orbits) or asymmetry(self.orbits, known).any():
            return guess
        row = guess - known
        for _ in range(PROJECTIONS):
            plain = self.orbits.linearize(guess)
            if not plain.is_finite:
                break
            rows, right = np.vstack([plain.jacobian, row]), np.append(-plain.defect, 0.0)
            guess = guess + np.linalg.lstsq(rows, right, rcond=None)[0]
        return np.asarray(guess)

    def tests(
        self, z: Array, linearization: Linearization, multipliers: Complex, tangent: Array
    ) -> dict[str, float]:
        """Return the functions that change sign at points of codimension two.

        Besides those named for such points, ``first`` and ``second`` are the components of the
        tangent along the two parameters: zero where the locus has an extremum, and both at a cusp.

        ``GPD``, ``CH``, ``DP`` and ``GH`` are coefficients of normal forms, multiplied by what is
        zero where they have poles: at other points of codimension two.
        """
        standing = self._standing(tangent)
        if not self.is_spectral:
            return standing
        monodromy = linearization.monodromy
        size = float(np.sqrt(1 + np.linalg.svdvals(monodromy) ** 2).prod())
        parts = z, linearization, multipliers, size
        more = self._pair_tests if self.condition in PAIRED else self._real_tests
        return {**standing, **more(*parts)}

    def _standing(self, tangent: Array) -> dict[str, float]:
        slopes = np.where(np.abs(tangent[-2:]) > LOCUS.no_slope, tangent[-2:], 0.0)
        return {"first": float(slopes[0]), "second": float(slopes[1])}

    def _real_tests(
        self, z: Array, linearization: Linearization, multipliers: Complex, size: float
    ) -> dict[str, float]:
        target = -1.0 if self.condition == "PD" else 1.0
        others = multipliers[others_of(self.condition, multipliers)]
        # The derivative of the characteristic polynomial: smooth where two multipliers meet.
        factors = np.where(np.eye(len(multipliers), dtype=bool), 1.0, target - multipliers)
        double, pairs = float(factors.prod(axis=1).sum().real / size), _pair_product(others, size)
        crossing = self.condition == "BP"
        if self._resting:
            more = {"DP": self._cubic(z, linearization, double)} if crossing else {}
            return {"BT": double, "ZH": pairs, **more}
        flips = _product(target + multipliers, size)
        if self.condition == "LP":
            return {"LPPD": flips, "R1": double, "LPNS": pairs}
        if crossing:
            cubic = self._cubic(z, linearization, double)
            return {"BPPD": flips, "R1": double, "BPNS": pairs, "DP": cubic}
        cubic = self._cubic(z, linearization, flips * double)
        return {"LPPD": flips, "R2": double, "PDNS": pairs, "GPD": cubic}

    def _cubic(self, z: Array, linearization: Linearization, poles: float) -> float:
        """Coefficient of third order times what is zero at its poles."""
        # On a pole the product is rounding noise.
        return self._coefficient(z, linearization) * poles if abs(poles) > LOCUS.pole else np.nan

    def _pair_tests(
        self, z: Array, linearization: Linearization, multipliers: Complex, size: float
    ) -> dict[str, float]:
        standing = self.orbits.standing
        places = critical_places(self.condition, multipliers, standing)
        cosine = float(multipliers[places].sum().real / 2)
        moving = multipliers[others_of(self.condition, multipliers, standing)]
        others = np.delete(multipliers, places)
        folds, pairs = _product(1 - others, size), _pair_product(moving, size)
        sine2 = 1 - cosine * cosine
        defined = sine2 > self.forms.neutral and np.abs(1 - others).min(initial=1.0) > LOCUS.pole
        cubic = (self._coefficient(z, linearization) if defined else np.nan) * sine2 * folds
        if self._resting:
            return {"BT": 1 - cosine, "ZH": folds, "HH": pairs, "GH": cubic}
        return {
            "R1": 1 - cosine,
            "R2": 1 + cosine,
            "R3": cosine + 0.5,
            "R4": cosine,
            "LPNS": folds,
            "PDNS": _product(1 + others, size),
            "NSNS": pairs,
            "CH": cubic,
        }

    def landed(self, point: OrbitPoint) -> Array:
        """Return the unknown of a point; of grazing that keeps some slip, where it keeps none.

        There is no direction of slip at none at all, but everything goes with its least value.
        """
        by = self.orbits.by
        if not isinstance(by, MarginalShooting) or not by.met.level:
            return point.z
        last = np.zeros(len(point.z))
        last[-2] = by.met.level  # the condition comes last, but for the tangent
        linearization = point.linearization or self.linearize(point.z)
        return np.asarray(point.z - linearization.bordered(point.tangent).solve(last))

    def coefficient(self, tests: dict[str, float]) -> float:
        """Return the coefficient that a point's test functions were made of, zero if rounding."""
        if self.condition == "LP" or not self.is_spectral:
            return np.nan
        if self.condition == "PD":
            value, poles = tests["GPD"], tests["LPPD"] * tests["R2"]
        elif self.condition == "BP":
            value, poles = tests["DP"], tests["BT" if self._resting else "R1"]
        else:
            names = ("GH", "BT", "ZH") if self._resting else ("CH", "R1", "LPNS")
            value, still, folds = (tests[name] for name in names)
            poles = still * (2 - still) * folds
        known = value / poles if poles else np.nan
        return 0.0 if abs(known) <= FORMS.degenerate else known

    def _coefficient(self, z: Array, linearization: Linearization) -> float:
        if not self.orbits.by.smooth:
            return np.nan
        # Perturbations that grow enter derivatives of higher order with the square of their growth.
        if np.abs(linearization.monodromy).max() ** 2 * np.finfo(float).eps > LOCUS.no_digits:
            return np.nan
        try:
            return self.forms.coefficient(self, z, linearization)
        except np.linalg.LinAlgError:
            return np.nan


class CollisionEquations(LocusEquations):
    """A locus on which two pairs meet on the unit circle and leave it, as without damping."""

    @property
    def is_spectral(self) -> bool:
        """No: of what is critical besides, and of a normal form, nothing is known."""
        return False

    def _measured(self, plain: Linearization) -> Degeneracy:
        return collision(plain.monodromy)


class ExtremumEquations(LocusEquations):
    """A locus of extrema of a measure along branches in one of two parameters.

    Its test function ``measure`` is the derivative of the measure along the locus. Where it is zero
    the measure has an extremum or a saddle in both parameters, or the held one turns.
    """

    odd = ("measure", "first", "second")

    def __init__(self, orbits: Orbits, condition: str, extremal: Extremal) -> None:
        super().__init__(orbits, condition)
        self._extremal = extremal
        self.quantity = f"{extremal.measure} {extremal.output}"
        self.held = self.odd[extremal.held]

    @property
    def directions(self) -> int:
        """The two parameters."""
        return 2

    def tests(
        self, z: Array, linearization: Linearization, multipliers: Complex, tangent: Array
    ) -> dict[str, float]:
        """Return the functions that change sign where a parameter or the measure is extremal."""
        rate = self._extremal.gradient(self.orbits, z) @ tangent
        return {**self._standing(tangent), "measure": float(rate)}

    def _values(self, plain: Linearization, z: Array) -> Array:
        return np.array([self._extremal.value(self.orbits, plain, z)])

    def _conditions(self, plain: Linearization, z: Array) -> Conditions:
        return self._extremal.conditions(self.orbits, plain, z)


def equations_of(orbits: Orbits, point: SpecialPoint, z: Array) -> LocusEquations:
    """Return the equations of the locus of a special point, which is an unknown of theirs."""
    if point.collides:
        return CollisionEquations(orbits, point.type)
    if point.type not in EXTREMUM_TYPES:
        if not np.isnan(point.angle):
            multiplier = np.exp(1j * point.angle)
            if isinstance(orbits, Equilibria):
                multiplier = orbits.multiplier(z, 2 * np.pi / point.duration)
            known = floquet_multipliers(orbits.linearize(z).monodromy)
            orbits = orbits.leaving_out(Standing.beside(multiplier, known))
        return LocusEquations(orbits, point.type)
    assert point.measured is not None
    held = -2 if list(orbits.varied)[-1] == point.vary else -1
    return ExtremumEquations(orbits, point.type, Extremal(*point.measured, held))


def _product(factors: Complex, size: float) -> float:
    return float(factors.prod().real / size)


def _pair_product(values: Complex, size: float) -> float:
    """Product of 1 - a b over all pairs, of order one."""
    n = len(values)
    if n < 2:
        return 1.0
    return float((1 - PRODUCTS["NS"](values)).prod().real / size ** (n - 1))


def mirrors(points: Sequence[OrbitPoint], orbits: Orbits, z: Array) -> bool:
    """Whether an orbit is the symmetric image of one on a locus, with all that lie beside it.

    At the same values of both parameters it has the same multipliers, and its locus leads in the
    same direction: where a symmetry changes a parameter too, loci only cross their images.
    """
    try:
        values, equations = _spectrum(orbits, z), points[0].curve.with_orbits(orbits)
        along = np.linalg.svd(equations.linearize(z).jacobian)[2][-1, -2:]
    except BREAKDOWNS:  # an orbit that cannot be integrated is compared with none
        return False
    for curve, run in runs(points):
        target = curve.orbits.adopt(orbits, z)[-2:]
        for a, b in pairwise(run):
            length = float(np.linalg.norm(b.z[-2:] - a.z[-2:]))
            gap = min(float(np.linalg.norm(item.z[-2:] - target)) for item in (a, b))
            if gap >= length + KNOWN.near:
                continue
            point = _beside(curve, a, b, target)
            if point is not None and _same_spectrum(point, values) and _parallel(point, along):
                return True
    return False


def _beside(curve: OrbitCurve, a: OrbitPoint, b: OrbitPoint, target: Array) -> OrbitPoint | None:
    """Return the point of a locus at a place in the plane; None if there is none.

    Shapes: target (2,).
    """
    grid = np.linspace(a.arclength, b.arclength, KNOWN.samples + 1)
    gaps = [float(np.linalg.norm(hermite([a, b], s)[0][-2:] - target)) for s in grid]
    s = float(grid[int(np.argmin(gaps))])
    try:
        for _ in range(4):  # each squares the distance
            point = point_at(curve, [a, b], s)
            along, gap = point.tangent[-2:], target - point.z[-2:]
            if np.linalg.norm(gap) < LOCUS.same_values:
                return point
            s = float(np.clip(s + along @ gap / (along @ along), a.arclength, b.arclength))
    except LostCurveError:
        return None
    return None


def _spectrum(orbits: Orbits, z: Array) -> Complex:
    """Return multipliers; of an equilibrium, whose unit of time is its own, eigenvalues."""
    if isinstance(orbits, Equilibria):
        return np.asarray(eigenvalues_of(orbits.jacobian(z)) / orbits.unit(z))
    return floquet_multipliers(orbits.linearize(z).monodromy)


def _parallel(point: OrbitPoint, along: Array) -> bool:
    """Whether a locus leads in a direction of the plane. Shapes: along (2,)."""
    own = point.tangent[-2:]
    sine = own[0] * along[1] - own[1] * along[0]
    return bool(abs(sine) < KNOWN.same * np.linalg.norm(own) * np.linalg.norm(along))


def _same_spectrum(point: OrbitPoint, values: Complex) -> bool:
    own = _spectrum(point.curve.orbits, point.z)
    if len(own) != len(values):
        return False
    apart = np.abs(own[:, None] - values) / np.maximum(1.0, np.abs(values))
    return bool(max(apart.min(axis=0).max(), apart.min(axis=1).max()) < KNOWN.same)
