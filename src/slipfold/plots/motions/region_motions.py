"""What motions do in regions without stable responses of theirs: a colour for each regime."""

from __future__ import annotations

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.patches import Patch
from numpy.typing import NDArray
from scipy.spatial import KDTree

from slipfold.loci.region_map import Region, RegionMap
from slipfold.plots.motions.regime_colours import COLOURS, grouped

Labels = NDArray[np.int64]


def draw_region_motions(ax: Axes, regions: RegionMap, labels: Labels) -> None:
    """Paint each pixel of a region as the nearest motion in it does, within the axes' limits.

    Shapes: labels (rows, columns), of pixels that fill the axes.
    """
    picture = np.zeros((*labels.shape, 4))
    for region in regions.regions:
        if region.motions:
            rows, columns = np.nonzero(labels == region.id)
            picture[rows, columns] = _colours(ax, region, rows, columns, labels.shape)
    if picture.any():
        ax.imshow(
            picture,
            extent=(*ax.get_xlim(), *ax.get_ylim()),
            origin="lower",
            aspect="auto",
            interpolation="nearest",
            zorder=0.2,
        )


def _colours(
    ax: Axes,
    region: Region,
    rows: NDArray[np.intp],
    columns: NDArray[np.intp],
    shape: tuple[int, ...],
) -> NDArray[np.float64]:
    """Return the colours of pixels of a region, shape (n, 4)."""
    low = np.array([ax.get_xlim()[0], ax.get_ylim()[0]])
    pixel = np.array([np.ptp(ax.get_xlim()), np.ptp(ax.get_ylim())]) / shape[::-1]
    places = np.array([motion.values for motion in region.motions])
    nearest = KDTree((places - low) / pixel).query(np.column_stack([columns, rows]) + 0.5)[1]
    names = grouped([motion.name for motion in region.motions])
    return np.array([to_rgba(COLOURS[name]) for name in names])[nearest]


def motion_shades(regions: RegionMap) -> list[Artist]:
    """Return what a legend shows of them."""
    found = {name for region in regions.regions for name in grouped([*region.regimes]).tolist()}
    return [
        Patch(facecolor=colour, edgecolor="0.6", linewidth=0.4, label=f"simulated: {name}")
        for name, colour in COLOURS.items()
        if name in found
    ]
