"""Loci as curves: the equations of critical orbits with the functions watched along them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.normal_forms.forms import forms_of
from slipfold.orbits.critical import Critical
from slipfold.orbits.grazing import MET, MarginalShooting
from slipfold.orbits.linearisation import Linearisation
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
from slipfold.orbits.test_functions import PAIRED, critical_places

Multipliers = NDArray[np.complex128]

NO_SLOPE = 1e-12
"""Component of a tangent that is rounding: the locus may be parallel to an axis of the plane."""

POLE = 1e-9
"""Product of test functions below which a coefficient with a pole there has no digits."""


class LocusEquations(Critical):
    """A locus of bifurcations or touches in two parameters: its equations and test functions."""

    odd = ("first", "second")

    def __init__(self, orbits: Orbits, condition: str) -> None:
        super().__init__(orbits, condition)
        self.forms = forms_of(orbits)
        self._resting = orbits.kind == "equilibrium"

    def tests(
        self, z: Array, linearisation: Linearisation, multipliers: Multipliers, tangent: Array
    ) -> dict[str, float]:
        """Return the functions that change sign at points of codimension two.

        Besides those named for such points, ``first`` and ``second`` are the components of the
        tangent along the two parameters: zero where the locus has an extremum, and both at a cusp.

        ``GPD``, ``CH``, ``DP`` and ``GH`` are coefficients of normal forms, multiplied by what is
        zero where they have poles: at other points of codimension two.
        """
        slopes = np.where(np.abs(tangent[-2:]) > NO_SLOPE, tangent[-2:], 0.0)
        standing = {"first": float(slopes[0]), "second": float(slopes[1])}
        if self.condition in MET:
            return standing
        monodromy = linearisation.monodromy
        size = float(np.sqrt(1 + np.linalg.svdvals(monodromy) ** 2).prod())
        parts = z, linearisation, multipliers, size
        more = self._pair_tests if self.condition in PAIRED else self._real_tests
        return {**standing, **more(*parts)}

    def _real_tests(
        self, z: Array, linearisation: Linearisation, multipliers: Multipliers, size: float
    ) -> dict[str, float]:
        target = -1.0 if self.condition == "PD" else 1.0
        others = np.delete(multipliers, critical_places(self.condition, multipliers))
        # The derivative of the characteristic polynomial: smooth where two multipliers meet.
        factors = [np.delete(target - multipliers, i).prod() for i in range(len(multipliers))]
        double, pairs = float(sum(factors).real / size), _pair_product(others, size)
        crossing = self.condition == "BP"
        if self._resting:
            more = {"DP": self._cubic(z, linearisation, double)} if crossing else {}
            return {"BT": double, "ZH": pairs, **more}
        flips = _product(target + multipliers, size)
        if self.condition == "LP":
            return {"LPPD": flips, "R1": double, "LPNS": pairs}
        if crossing:
            cubic = self._cubic(z, linearisation, double)
            return {"BPPD": flips, "R1": double, "BPNS": pairs, "DP": cubic}
        cubic = self._cubic(z, linearisation, flips * double)
        return {"LPPD": flips, "R2": double, "PDNS": pairs, "GPD": cubic}

    def _cubic(self, z: Array, linearisation: Linearisation, poles: float) -> float:
        """Coefficient of third order times what is zero at its poles."""
        # On a pole the product is rounding noise.
        return self._coefficient(z, linearisation) * poles if abs(poles) > POLE else np.nan

    def _pair_tests(
        self, z: Array, linearisation: Linearisation, multipliers: Multipliers, size: float
    ) -> dict[str, float]:
        places = critical_places(self.condition, multipliers)
        cosine = float(multipliers[places].sum().real / 2)
        others = np.delete(multipliers, places)
        folds, pairs = _product(1 - others, size), _pair_product(others, size)
        sine2 = 1 - cosine * cosine
        defined = sine2 > self.forms.neutral
        cubic = (self._coefficient(z, linearisation) if defined else np.nan) * sine2 * folds
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
        """Return the unknown of a point; of a touch that keeps some slip, where it keeps none.

        There is no direction of slip at none at all, but everything goes with its least value.
        """
        by = self.orbits.by
        if not isinstance(by, MarginalShooting) or not by.level:
            return point.z
        last = np.zeros(len(point.z))
        last[-2] = by.level  # the condition comes last, but for the tangent
        linearisation = point.linearisation or self.linearise(point.z)
        return np.asarray(point.z - linearisation.bordered(point.tangent).solve(last))

    def coefficient(self, tests: dict[str, float]) -> float:
        """Return the normal form coefficient that a point's test functions were made of."""
        if self.condition == "LP" or self.condition in MET:
            return np.nan
        if self.condition == "PD":
            value, poles = tests["GPD"], tests["LPPD"] * tests["R2"]
        elif self.condition == "BP":
            value, poles = tests["DP"], tests["BT" if self._resting else "R1"]
        else:
            names = ("GH", "BT", "ZH") if self._resting else ("CH", "R1", "LPNS")
            value, still, folds = (tests[name] for name in names)
            poles = still * (2 - still) * folds
        return value / poles if poles else np.nan

    def _coefficient(self, z: Array, linearisation: Linearisation) -> float:
        if not self.orbits.by.smooth:
            return np.nan
        try:
            return self.forms.coefficient(self, z, linearisation)
        except np.linalg.LinAlgError:
            return np.nan


def _product(factors: Multipliers, size: float) -> float:
    return float(factors.prod().real / size)


def _pair_product(values: Multipliers, size: float) -> float:
    """Product of 1 - a b over all pairs, of order one."""
    n = len(values)
    if n < 2:
        return 1.0
    first, second = np.triu_indices(n, k=1)
    return float((1 - values[first] * values[second]).prod().real / size ** (n - 1))
