"""Pale colours of regions: one for each combination of stable responses."""

from __future__ import annotations

from collections.abc import Mapping
from colorsys import hsv_to_rgb
from types import MappingProxyType

from matplotlib.colors import to_hex

PALE: Mapping[tuple[int, ...], str] = MappingProxyType(
    {(1,): "#f6f7f2", (1, 2): "#e3efdc", (2,): "#c3ded6", (): "#b3b1b0"}
)
"""Colour of a region by the periods of its stable responses; each is darker than the one before."""

OTHERS = (
    "#e0befa", "#ffbd99", "#71d0d5", "#f5dc98", "#f6dcfb", "#dcb87a",
    "#f3aece", "#e6f8b4", "#abe7b7", "#bcb4f4", "#d5c2b3", "#d5d1f5",
)  # fmt: skip
"""Colours of other combinations, in the order of `_rank`: each the one farthest, for full sight and
two kinds of colour blindness, from all those before it, and lighter than any line."""

UNKNOWN: Mapping[str, str] = MappingProxyType(
    {"facecolor": "white", "edgecolor": "0.75", "hatch": "...."}
)
"""How a region is drawn whose label is contradicted."""

STICKS: Mapping[str, str] = MappingProxyType(
    {"facecolor": "none", "edgecolor": "0.72", "hatch": "///"}
)
"""How a region is marked in which contacts of stable responses stop."""

GOLDEN = 0.6180339887498949
"""Turn of the hue, in circles, that never comes back to where it was."""


def region_colour(stable: tuple[int, ...]) -> str:
    """Return the colour of regions with these stable responses, the same in every figure.

    >>> region_colour((1,)), region_colour((1, 1)), region_colour((2, 2))
    ('#f6f7f2', '#e0befa', '#ffbd99')
    """
    if stable in PALE:
        return PALE[stable]
    rank = _rank(stable)
    if rank < len(OTHERS):
        return OTHERS[rank]
    return to_hex(hsv_to_rgb(rank * GOLDEN % 1, 0.22, 0.95 - 0.03 * (rank % 4)))


def _rank(stable: tuple[int, ...]) -> int:
    """Number combinations from 0: those of periods 1 and 2 by how many there are, then others."""
    doubled, count = stable.count(2), len(stable)
    if set(stable) <= {1, 2}:
        # 2, 4, 5, 6 ... combinations of two, three, four, five ...; of two, (1, 2) has its own.
        before = (count - 2) * (count + 3) // 2 - (count > 2)
        return before + (doubled if count > 2 else doubled // 2)
    return 1000 + sum(period * 31**place for place, period in enumerate(sorted(stable)))
