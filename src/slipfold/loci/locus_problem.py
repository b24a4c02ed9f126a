"""Loci as curves: the equations of critical orbits with the functions watched along them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.normal_form import critical_coefficient
from slipfold.loci.normal_forms import codimension_two_coefficients
from slipfold.loci.quintic import quintic_coefficient
from slipfold.loci.segment_map import SegmentMap
from slipfold.orbits.critical_problem import CriticalProblem
from slipfold.orbits.degeneracy import critical_pair
from slipfold.orbits.linearisation import Linearisation
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["LocusProblem", "critical_places"]

Array = NDArray[np.float64]
Multipliers = NDArray[np.complex128]

STILL = 1e-12
"""Component of a tangent that is rounding: the locus may be parallel to an axis of the plane."""

POLE = 1e-9
"""Product of test functions below which a coefficient with a pole there has no digits."""


class LocusProblem(CriticalProblem):
    """A locus of LP, PD or NS in two parameters: its equations and its test functions.

    Here of orbits of a forced model; `slipfold.loci.cycle_locus` and
    `slipfold.loci.equilibrium_locus` are those of an autonomous one.
    """

    odd = ("first", "second")

    orbits = "periodic"
    """What the locus consists of, ``"periodic"`` orbits or ``"equilibrium"``."""

    neutral = 1e-8
    """Least sin(angle)^2 at which the coefficient of a torus still has digits."""

    @property
    def ends_at_parent(self) -> bool:
        """Whether its orbits may become others passed twice, whose halves do not differ."""
        return self.period % 2 == 0

    @property
    def type(self) -> str:
        """What the bifurcation is called in results."""
        return self.kind

    def named(self, found: str) -> str:
        """Return what a special point is called in results."""
        return found

    def reported_multipliers(self, point: OrbitPoint) -> Multipliers:
        """Return the multipliers that results list, shape (n,)."""
        return point.multipliers

    def tests(
        self, z: Array, linearisation: Linearisation, multipliers: Multipliers, tangent: Array
    ) -> dict[str, float]:
        r"""Return the functions that change sign at points of codimension two.

        Besides those named for such points, ``first`` and ``second`` are the components of the
        tangent along the two parameters: zero where the locus has an extremum, and both at a cusp.

        ``GPD`` and ``CH`` are coefficients of normal forms, multiplied by what is zero where they
        have poles: at other points of codimension two.

        Shapes: multipliers (n,).
        """
        monodromy = linearisation.monodromy
        size = float(np.sqrt(1 + np.linalg.svdvals(monodromy) ** 2).prod())
        slopes = np.where(np.abs(tangent[-2:]) > STILL, tangent[-2:], 0.0)
        tests = {"first": float(slopes[0]), "second": float(slopes[1])}
        if self.kind == "NS":
            return {**tests, **self._torus_tests(z, linearisation, multipliers, size)}
        target = 1.0 if self.kind == "LP" else -1.0
        others = np.delete(multipliers, critical_places(self.kind, multipliers))
        n = len(multipliers)
        tests["LPPD"] = _product(target + multipliers, size)
        # The derivative of the characteristic polynomial: smooth where two multipliers meet.
        double = sum(np.delete(target - multipliers, i).prod() for i in range(n)).real / size
        tests["R1" if self.kind == "LP" else "R2"] = float(double)
        pairs = _pair_product(others, size)
        if self.kind == "LP":
            return {**tests, "LPNS": pairs}
        poles = tests["LPPD"] * float(double)
        # On a pole the product is rounding noise.
        coefficient = self._coefficient(z, linearisation) if abs(poles) > POLE else np.nan
        return {**tests, "PDNS": pairs, "GPD": coefficient * poles}

    def _torus_tests(
        self, z: Array, linearisation: Linearisation, multipliers: Multipliers, size: float
    ) -> dict[str, float]:
        places = critical_places("NS", multipliers)
        cosine = float(multipliers[places].sum().real / 2)
        others = np.delete(multipliers, places)
        folded = _product(1 - others, size)
        sine2 = 1 - cosine * cosine
        coefficient = self._coefficient(z, linearisation) if sine2 > self.neutral else np.nan
        return {
            "R1": 1 - cosine,
            "R2": 1 + cosine,
            "R3": cosine + 0.5,
            "R4": cosine,
            "LPNS": folded,
            "PDNS": _product(1 + others, size),
            "NSNS": _pair_product(others, size),
            "CH": coefficient * sine2 * folded,
        }

    def coefficient(self, tests: dict[str, float]) -> float:
        """Return the normal form coefficient that a point's test functions were made of."""
        if self.kind == "LP":
            return np.nan
        if self.kind == "PD":
            poles = tests["LPPD"] * tests["R2"]
            return tests["GPD"] / poles if poles else np.nan
        poles = tests["R1"] * (2 - tests["R1"]) * tests["LPNS"]
        return tests["CH"] / poles if poles else np.nan

    def own_length(self, point: OrbitPoint) -> float:
        """Return the length of the unit critical vector in the scales of the orbit's own model."""
        places = critical_places(self.kind, point.multipliers)
        values, vectors = np.linalg.eig(point.monodromy)
        vector = vectors[:, np.abs(values - point.multipliers[places[0]]).argmin()]
        return float(np.linalg.norm(vector * self.scales / self.model_at(point.z).unit_scales()))

    def codimension_two(self, point: OrbitPoint, kind: str) -> dict[str, float]:
        """Return the coefficients that decide what happens near a point of codimension two."""
        own = self.model_at(point.z).unit_scales()
        if kind == "GPD":
            quintic = quintic_coefficient(self, point, own)
            return {} if quintic is None else {"e": quintic}
        constants, linearisation = self.constants(point.z), self.linearise(point.z)
        map_ = SegmentMap(self, point.z, constants, linearisation, own)
        return codimension_two_coefficients(map_, map_.rescaled(point.monodromy), kind)

    def _coefficient(self, z: Array, linearisation: Linearisation) -> float:
        map_ = SegmentMap(self, z, self.constants(z), linearisation)
        try:
            return critical_coefficient(map_, linearisation.monodromy, self.kind)
        except np.linalg.LinAlgError:
            return np.nan


def critical_places(kind: str, multipliers: Multipliers) -> NDArray[np.int64]:
    """Return the places of the multipliers that make an orbit critical.

    Shapes: multipliers (n,).
    """
    if kind == "NS":
        return np.array(critical_pair(multipliers) or (), dtype=np.int64)
    target = 1.0 if kind == "LP" else -1.0
    return np.array([np.abs(multipliers - target).argmin()], dtype=np.int64)


def _product(factors: Multipliers, size: float) -> float:
    return float(factors.prod().real / size)


def _pair_product(values: Multipliers, size: float) -> float:
    """Product of 1 - a b over all pairs, of order one."""
    n = len(values)
    if n < 2:
        return 1.0
    first, second = np.triu_indices(n, k=1)
    return float((1 - values[first] * values[second]).prod().real / size ** (n - 1))
