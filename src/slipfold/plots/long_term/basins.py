"""Basins of attraction: the plane of starts, a colour for each attractor."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch

from slipfold.arrays import Array
from slipfold.long_term.attractor import Attractor
from slipfold.long_term.basin_boundaries import WITHIN_CELL, WITHIN_ERROR
from slipfold.long_term.search import ENDED, UNDECIDED, UNFINISHED
from slipfold.plots.axes import axes_or_new, label_of
from slipfold.plots.region_colours import OTHERS
from slipfold.results.motions.basins import PHASE, Basins
from slipfold.results.motions.found_attractors import in_words

NOTHING = {
    UNFINISHED: ("white", "not finished"),
    ENDED: ("0.35", "ended"),
    UNDECIDED: ("0.75", "undecided"),
}
"""Colours and names of starts that came to no attractor."""


UNCERTAIN = {
    WITHIN_CELL: ((1.0, 1.0, 1.0, 0.6), "changes within the cell"),
    WITHIN_ERROR: ((0.55, 0.55, 0.55, 1.0), "changes within the error"),
}
"""What is laid over cells whose label is uncertain."""

COLOURS = ("#c3ded6", "#0d0887", *OTHERS)
"""Of basins, in the order of their attractors: the first two differ most in lightness."""


def draw_basins(found: Basins, ax: Axes | None = None, *, legend: bool = True) -> Axes:
    """Draw each start in the colour of the attractor that its motion came to.

    Cells within which the label changes are paler, those where it changes within the error of the
    integration are grey.
    """
    ax = axes_or_new(ax)
    colours = [colour for colour, _ in NOTHING.values()]
    own = [COLOURS[number % len(COLOURS)] for number in range(len(found))]
    colours += own
    place: dict[str, Any] = {
        "origin": "lower",
        "extent": (*_ends(found.first), *_ends(found.second)),
        "aspect": "auto",
        "interpolation": "nearest",
    }
    shown = found.labels - UNFINISHED  # from zero
    ax.imshow(shown, cmap=ListedColormap(colours), vmin=-0.5, vmax=len(colours) - 0.5, **place)
    doubts = [(level, *UNCERTAIN[level]) for level in UNCERTAIN if (found.uncertain == level).any()]
    if doubts:
        over = np.zeros((*found.labels.shape, 4))
        for level, colour, _ in doubts:
            over[found.uncertain == level] = colour
        ax.imshow(over, **place)
    across, up = (
        f"{axis.name} ({axis.unit})" if axis is PHASE else label_of(found.model, axis.name)
        for axis in found.axes
    )
    ax.set_xlabel(across)
    ax.set_ylabel(up)
    if legend:
        handles = [
            Patch(facecolor=colour, label=_text(found, item))
            for colour, item in zip(own, found, strict=True)
        ]
        handles += [
            Patch(facecolor=colour, edgecolor="0.55", linewidth=0.4, label=name)
            for label, (colour, name) in NOTHING.items()
            if (found.labels == label).any()
        ]
        handles += [
            Patch(facecolor=_over_grey(colour), edgecolor="0.55", linewidth=0.4,
                  label=f"{name}: {100 * (found.uncertain == level).mean():.3g} %")
            for level, colour, name in doubts
        ]  # fmt: skip
        ax.legend(
            handles=handles, loc="upper center", bbox_to_anchor=(0.5, 0.0), borderaxespad=4.0,
            ncols=min(len(handles), 3),
        )  # fmt: skip
    return ax


def _ends(values: Array) -> tuple[float, float]:
    """Return where the outermost cells end: half a step beyond their starts."""
    half = 0.5 * (values[-1] - values[0]) / (len(values) - 1)
    return float(values[0] - half), float(values[-1] + half)


def _over_grey(colour: tuple[float, ...]) -> str:
    """Return what a shade of grey looks like over a medium one."""
    shade, opaque = colour[0], colour[-1]
    return str(opaque * shade + 0.5 * (1 - opaque))


def _text(found: Basins, item: Attractor) -> str:
    return f"{in_words(item)}: {100 * found.share(item).value:.3g} %"
