"""The look of all figures: fonts, colours safe in grey and for colour blindness, lines, markers."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager
from types import MappingProxyType
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.colors import to_hex

COLUMN = 3.45
"""Width of a journal column in inches."""

LINES: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "stable": {"linestyle": "-", "linewidth": 1.5},
        "period doubling": {"linestyle": (0, (4.5, 2.0)), "linewidth": 1.0},
        "fold or torus": {"linestyle": (0, (1.0, 1.2)), "linewidth": 1.2},
    }
)
"""Line properties of each kind."""

MARKERS: Mapping[str, str] = MappingProxyType(
    {
        "PD": "o",
        "NS": "s",
        "LP": "^",
        "BP": "D",
        "HB": "p",
        "LIMIT": "x",
        "FAILED": "|",
        "EVENT": "+",
        "GRAZE": "v",
        "STICK": "<",
        "LIFT": ">",
        "MEET": "1",
    }
)
"""Marker of each type of special point, and of the end of a branch that could not be followed."""

_STYLE: dict[Any, Any] = {
    "axes.grid": False,
    "axes.labelsize": 9,
    "axes.linewidth": 0.7,
    "axes.titlelocation": "left",
    "axes.titlesize": 9,
    "axes.xmargin": 0.0,
    "figure.dpi": 100,
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 8,
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "lines.dash_capstyle": "butt",
    "lines.markersize": 4.5,
    "lines.solid_capstyle": "butt",
    "mathtext.fontset": "dejavusans",
    # Type 42 keeps text as text: editable and searchable in the PDF.
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
    "svg.fonttype": "none",
    "savefig.dpi": 300,
    "xtick.direction": "in",
    "xtick.labelsize": 8,
    "xtick.minor.visible": True,
    "xtick.top": True,
    "ytick.direction": "in",
    "ytick.labelsize": 8,
    "ytick.minor.visible": True,
    "ytick.right": True,
}


def figure_style() -> AbstractContextManager[None]:
    """Return a context in which matplotlib draws and saves in the style of the package.

    >>> with figure_style():
    ...     mpl.rcParams["pdf.fonttype"]
    42
    """
    return mpl.rc_context(_STYLE)


def palette(count: int) -> tuple[str, ...]:
    """Return colours that differ in lightness too, from dark to light.

    They lie on matplotlib's perceptually uniform map *plasma*, short of its yellow, which is too
    faint for a line on white.

    >>> palette(2)[0]
    '#0d0887'
    """
    positions = np.linspace(0.0, 0.74, count) if count > 1 else [0.0]
    return tuple(to_hex(mpl.colormaps["plasma"](position)) for position in positions)
