"""The types of special points: what is critical at each, and what it is called and drawn as."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal

from slipfold.flow.modes import MET

CriticalMultiplier = float | Literal["pair"]
"""A critical multiplier, 1 or -1, or a pair of them on the unit circle."""


@dataclass(frozen=True)
class PointType:
    """A type of special point of a branch."""

    title: str
    critical: float = math.nan  # the critical multiplier; NaN of a pair and where contacts change
    pair: bool = False  # whether a pair is critical
    # Cubic coefficient of the normal form along a locus: its name, its sign where the bifurcation
    # is supercritical, and the points of codimension two at which it has a zero or a pole
    coefficient: str = ""
    soft: float = -1.0
    sign_changes: tuple[str, ...] = ()
    marker: str = "o"  # as Matplotlib names it
    # Color and line of its locus
    color: str = "#000000"
    dashes: Any = None


BIFURCATION_TYPES: Mapping[str, PointType] = MappingProxyType(
    {
        "LP": PointType("fold", 1.0, marker="^", color="#d56a14"),
        "PD": PointType(
            "period doubling",
            -1.0,
            coefficient="b",
            soft=1.0,
            sign_changes=("GPD", "LPPD", "R2"),
            color="#0b0774",
        ),
        "NS": PointType(
            "Neimark-Sacker (torus)",
            pair=True,
            coefficient="d",
            sign_changes=("CH", "LPNS"),
            marker="s",
            color="#a83b98",
        ),
        "BP": PointType(
            "branch point",
            1.0,
            coefficient="c",
            sign_changes=("DP", "R1", "BT"),
            marker="D",
            color="#074e03",
        ),
        "HB": PointType("Hopf", pair=True, coefficient="l1", sign_changes=("GH", "ZH"), marker="p"),
    }
)
"""Types of bifurcation: fold, period doubling, Neimark-Sacker, branch point, Hopf.

A new type also needs a test function (`orbits.test_functions.PRODUCTS`), a normal form
(`orbits.normal_forms`) and, if a branch emanates there, its start (`branches.switching`).
"""

CONTACT_TYPES: Mapping[str, PointType] = MappingProxyType(
    {
        "GRAZE": PointType(
            "touches Vrel = 0", marker="v", dashes=(0, (3.0, 1.0, 1.0, 1.0, 1.0, 1.0))
        ),
        "STICK": PointType(
            "a crossing of Vrel = 0 begins to stick", marker="<", dashes=(0, (6.0, 1.0, 1.0, 1.0))
        ),
        "LIFT": PointType(
            "contact is lost for a moment", marker=">", dashes=(0, (1.0, 1.0, 1.0, 3.0))
        ),
        "MEET": PointType("two changes of contacts meet", marker="1"),
    }
)
"""Types of points where contacts begin or cease to do something."""

EXTREMUM_TYPES: Mapping[str, PointType] = MappingProxyType(
    {
        "MAX": PointType("largest", marker="2", dashes=(0, (9.0, 1.2))),
        "MIN": PointType("smallest", marker="1", dashes=(0, (4.0, 1.2))),
    }
)
"""Types of points where what is measured of an output has an extremum along a branch."""

POINT_TYPES: Mapping[str, PointType] = MappingProxyType(
    {**BIFURCATION_TYPES, **CONTACT_TYPES, **EXTREMUM_TYPES}
)

REQUESTED_TYPES = ("EVENT", *EXTREMUM_TYPES)
"""Types of points that are located on request; the orbits change in no way there."""

LOCUS_TYPES = (*BIFURCATION_TYPES, *MET)
"""Types of special points that have a locus in two parameters, and are always located."""

FOLLOWED_TYPES = (*LOCUS_TYPES, *EXTREMUM_TYPES)
"""Types of special points whose locus can be followed."""

PAIRED = tuple(name for name, item in BIFURCATION_TYPES.items() if item.pair)
"""Bifurcations at which a pair is critical: of orbits, and of equilibria."""

COLLISIONS = {"HB": "Hamiltonian Hopf", "NS": "Krein collision"}
"""What they are called where two pairs meet on the unit circle and leave it, as without damping."""


@dataclass(frozen=True)
class CodimensionTwoType:
    """A type of point of codimension two of a locus."""

    title: str
    critical: tuple[CriticalMultiplier, ...]
    # Types of the loci that pass through it or end there
    through: tuple[str, ...] = ()
    # Types of the loci of cycles that emanate from an equilibrium, or of orbits of twice the
    # period; of cycles also the number of the critical pair
    emanating: tuple[tuple[str, int], ...] = ()

    def others(self, locus: str) -> tuple[CriticalMultiplier, ...]:
        """Return what is critical besides what makes a locus of some type."""
        own = "pair" if BIFURCATION_TYPES[locus].pair else BIFURCATION_TYPES[locus].critical
        if own not in self.critical:  # a pair that meets on the real axis
            return ()
        place = self.critical.index(own)
        return self.critical[:place] + self.critical[place + 1 :]


CODIMENSION_TWO: Mapping[str, CodimensionTwoType] = MappingProxyType(
    {
        "CPC": CodimensionTwoType("cusp of cycles", (1.0,)),
        "GPD": CodimensionTwoType("generalized period doubling", (-1.0,), emanating=(("LP", 0),)),
        "CH": CodimensionTwoType("Chenciner", ("pair",)),
        "R1": CodimensionTwoType("1:1 resonance", (1.0, 1.0), ("LP", "NS")),
        "R2": CodimensionTwoType("1:2 resonance", (-1.0, -1.0), ("PD", "NS"), (("NS", 0),)),
        "R3": CodimensionTwoType("1:3 resonance", ("pair",)),
        "R4": CodimensionTwoType("1:4 resonance", ("pair",)),
        "DP": CodimensionTwoType("degenerate pitchfork", (1.0,), ("LP", "BP")),
        "LPBP": CodimensionTwoType("fold and branch point", (1.0, 1.0), ("LP", "BP")),
        "LPPD": CodimensionTwoType("fold-flip", (1.0, -1.0), ("LP", "PD")),
        "LPNS": CodimensionTwoType("fold and Neimark-Sacker", (1.0, "pair"), ("LP", "NS")),
        "PDNS": CodimensionTwoType("flip and Neimark-Sacker", (-1.0, "pair"), ("PD", "NS")),
        "NSNS": CodimensionTwoType("double Neimark-Sacker", ("pair", "pair")),
        "BPPD": CodimensionTwoType("branch point and flip", (1.0, -1.0), ("BP", "PD")),
        "BPNS": CodimensionTwoType("branch point and Neimark-Sacker", (1.0, "pair"), ("BP", "NS")),
        "CP": CodimensionTwoType("cusp", (1.0,)),
        "BT": CodimensionTwoType("Bogdanov-Takens", (1.0, 1.0), ("LP", "BP", "HB")),
        "GH": CodimensionTwoType("generalized Hopf (Bautin)", ("pair",), emanating=(("LP", 0),)),
        "ZH": CodimensionTwoType(
            "zero-Hopf", (1.0, "pair"), ("LP", "BP", "HB"), (("NS", 0), ("BP", 0))
        ),
        "HH": CodimensionTwoType("double Hopf", ("pair", "pair"), emanating=(("NS", 0), ("NS", 1))),
    }
)
"""Types of points of codimension two; the last five are those of equilibria."""

DOUBLED = ("R1", "R2", "BT")
"""Where a second multiplier joins a critical one, or a critical pair meets on the real axis."""

TWO_PAIRS = tuple(name for name, item in CODIMENSION_TWO.items() if item.critical == ("pair",) * 2)
"""Where two pairs are critical: two loci of the same type cross."""
