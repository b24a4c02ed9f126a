"""The look of loci: colour tells the type, dashes the criticality, width the period."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from slipfold.loci.locus import CODIMENSION_TWO
from slipfold.plots.style import MARKERS

LOCUS_COLOURS: Mapping[str, str] = MappingProxyType(
    {"HB": "#000000", "PD": "#0b0774", "BP": "#074e03", "NS": "#a83b98", "LP": "#d56a14"}
)
"""Colour of each type of locus; they differ in lightness too, and from all pale areas."""

WIDTHS = {1: 1.9, 2: 1.0}
"""Line width by period."""

DASHES: Mapping[str, Any] = MappingProxyType(
    {"supercritical": "-", "subcritical": (0, (4.0, 1.6)), "": (0, (1.0, 1.2))}
)
"""Line style by criticality; dotted where it is not known."""

FOLD: Any = (0, (5.0, 1.4, 1.0, 1.4))
"""Line style of folds of cycles, which have no criticality; those of equilibria are solid."""

TOUCHING: Mapping[str, Any] = MappingProxyType(
    {
        "GRAZE": (0, (3.0, 1.0, 1.0, 1.0, 1.0, 1.0)),
        "LIFT": (0, (1.0, 1.0, 1.0, 3.0)),
        "STICK": (0, (6.0, 1.0, 1.0, 1.0)),
    }
)
"""Line styles of what is no bifurcation; all are black."""


def locus_colour(type_: str, colours: Mapping[str, str] = LOCUS_COLOURS) -> str:
    """Return the colour of a type of locus."""
    return colours.get(type_, "#000000")


def line_style(
    type_: str,
    period: int,
    criticality: str,
    colours: Mapping[str, str] = LOCUS_COLOURS,
    kind: str = "periodic",
) -> dict[str, Any]:
    """Return the line properties of a stretch of a locus."""
    own = {"LP": "-" if kind == "equilibrium" else FOLD, **TOUCHING}
    return {
        "color": locus_colour(type_, colours),
        "linestyle": own.get(type_, DASHES[criticality]),
        "linewidth": WIDTHS.get(period, 0.7),
    }


def mark_style(type_: str) -> dict[str, Any]:
    """Return the marker properties of a point of a bifurcation set."""
    style: dict[str, Any] = {"linestyle": "none", "color": "black", "zorder": 3}
    if type_ in CODIMENSION_TWO:
        return {**style, "marker": "o", "markersize": 3.8, "markeredgewidth": 0.0}
    if type_ in MARKERS:
        return {**style, "marker": MARKERS[type_], "markersize": 4.5, "markeredgewidth": 0.9}
    return {
        **style,
        "marker": "o",
        "markersize": 3.0,
        "markerfacecolor": "white",
        "markeredgewidth": 0.6,
    }
