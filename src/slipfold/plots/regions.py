"""Regions of a plane as pale areas that end exactly at the lines between them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from colorsys import hsv_to_rgb
from types import MappingProxyType
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, to_hex, to_rgba
from matplotlib.patches import Patch
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import KDTree

from slipfold.arrays import Array, Mask
from slipfold.bifurcations.loci.region_map import Region, RegionMap
from slipfold.bifurcations.loci.window import Window
from slipfold.plots.labels import Label

PALE: Mapping[tuple[int, ...], str] = MappingProxyType(
    {(1,): "#f6f7f2", (1, 2): "#e3efdc", (2,): "#c3ded6", (): "#b3b1b0"}
)
"""Color of a region by the periods of its stable responses; each is darker than the one before."""

OTHERS = (
    "#e0befa", "#ffbd99", "#71d0d5", "#f5dc98", "#f6dcfb", "#dcb87a",
    "#f3aece", "#e6f8b4", "#abe7b7", "#bcb4f4", "#d5c2b3", "#d5d1f5",
)  # fmt: skip
"""Colors of other combinations, in the order of `_rank`: each the one farthest, for full sight and
two kinds of color blindness, from all those before it, and lighter than any line."""

UNKNOWN: Mapping[str, str] = MappingProxyType(
    {"facecolor": "white", "edgecolor": "0.75", "hatch": "...."}
)
"""How a region is drawn whose label is contradicted."""

STICKS: Mapping[str, str] = MappingProxyType(
    {"facecolor": "none", "edgecolor": "0.72", "hatch": "///"}
)
"""How a region is marked in which contacts of stable responses stop."""


def region_color(stable: tuple[int, ...]) -> str:
    """Return the color of regions with these stable responses, the same in every figure.

    >>> region_color((1,)), region_color((1, 1)), region_color((2, 2))
    ('#f6f7f2', '#e0befa', '#ffbd99')
    """
    if stable in PALE:
        return PALE[stable]
    rank = _rank(stable)
    if rank < len(OTHERS):
        return OTHERS[rank]
    # The golden section of the circle of hues never returns to where it was.
    return to_hex(hsv_to_rgb(rank * 0.6180339887498949 % 1, 0.22, 0.95 - 0.03 * (rank % 4)))


def _rank(stable: tuple[int, ...]) -> int:
    """Number combinations from 0: those of periods 1 and 2 by how many there are, then others."""
    doubled, count = stable.count(2), len(stable)
    if set(stable) <= {1, 2}:
        # 2, 4, 5, 6 ... combinations of two, three, four, five ...; of two, (1, 2) has its own.
        before = (count - 2) * (count + 3) // 2 - (count > 2)
        return before + (doubled if count > 2 else doubled // 2)
    return 1000 + sum(period * 31**place for place, period in enumerate(sorted(stable)))


COLORS = {
    "period 1": "#eef0e2",
    "period 2": "#b7ddd0",
    "period 4": "#6fb7b0",
    "period 8": "#3a8a94",
    "other periods": "#8db4dc",
    "torus": "#f5c451",
    "chaos": "#b5322b",
    "sticks": "#8f7cc0",
    "stopped": "#9a9a9a",
    "undecided": "#ffffff",
    "not done": "#ffffff",
    "none": "#ffffff",
}
"""Color of each regime. Their lightness differs, so that they are distinct in gray."""


def grouped(names: Any) -> Any:
    """Return what motions do, with periods that have no color of their own together.

    >>> grouped(["torus", "period 4", "period 5"]).tolist()
    ['torus', 'period 4', 'other periods']
    """
    named = np.asarray(names).astype(object)
    named[~np.isin(named, list(COLORS))] = "other periods"
    return named


Labels = NDArray[np.int64]


def draw_region_motions(ax: Axes, regions: RegionMap, labels: Labels) -> None:
    """Paint each pixel of a region as the nearest motion in it does, within the axes' limits.

    Shapes: labels (rows, columns), of pixels that fill the axes.
    """
    picture = np.zeros((*labels.shape, 4))
    for region in regions.regions:
        if region.motions:
            rows, columns = np.nonzero(labels == region.id)
            picture[rows, columns] = _colors(ax, region, rows, columns, labels.shape)
    if picture.any():
        ax.imshow(
            picture,
            extent=(*ax.get_xlim(), *ax.get_ylim()),
            origin="lower",
            aspect="auto",
            interpolation="nearest",
            zorder=0.2,
        )


def _colors(
    ax: Axes,
    region: Region,
    rows: NDArray[np.intp],
    columns: NDArray[np.intp],
    shape: tuple[int, ...],
) -> NDArray[np.float64]:
    """Return the colors of pixels of a region, shape (n, 4)."""
    low = np.array([ax.get_xlim()[0], ax.get_ylim()[0]])
    pixel = np.array([np.ptp(ax.get_xlim()), np.ptp(ax.get_ylim())]) / shape[::-1]
    places = np.array([motion.values for motion in region.motions])
    nearest = KDTree((places - low) / pixel).query(np.column_stack([columns, rows]) + 0.5)[1]
    names = grouped([motion.name for motion in region.motions])
    return np.array([to_rgba(COLORS[name]) for name in names])[nearest]


def motion_shades(regions: RegionMap) -> list[Artist]:
    """Return what a legend shows of them."""
    found = {name for region in regions.regions for name in grouped([*region.regimes]).tolist()}
    return [
        Patch(facecolor=color, edgecolor="0.6", linewidth=0.4, label=f"simulated: {name}")
        for name, color in COLORS.items()
        if name in found
    ]


PIXELS = (1000, 800)
"""Size of the picture of the regions: finer than the map, so that its cells are not seen."""

PICTURE = "regions"
"""Name of the picture among what is drawn in the axes."""


def draw_regions(ax: Axes, regions: RegionMap, labels: Labels) -> None:
    """Paint regions below everything else, within the limits of the axes."""
    view = ax.get_xlim(), ax.get_ylim()
    colors = ["white", *map(_color, regions.regions)]
    ax.imshow(
        labels,
        ListedColormap(colors),
        vmin=-0.5,
        vmax=len(colors) - 0.5,
        extent=(*view[0], *view[1]),
        origin="lower",
        aspect="auto",
        interpolation="nearest",
        interpolation_stage="rgba",
        zorder=0,
        gid=PICTURE,
    )
    unknown = [item.id for item in regions.regions if not (item.known or item.motions)]
    sticks = [item.id for item in regions.regions if item.known and item.sticking]
    _hatch(ax, np.isin(labels, unknown), UNKNOWN)
    _hatch(ax, np.isin(labels, sticks), STICKS)
    draw_region_motions(ax, regions, labels)
    ax.set_xlim(view[0])
    ax.set_ylim(view[1])


def _color(region: Region) -> str:
    return region_color(region.stable) if region.known else UNKNOWN["facecolor"]


def _hatch(ax: Axes, mask: Mask, style: Mapping[str, str]) -> None:
    """Hatch some regions: those whose label is contradicted, or in which contacts stop."""
    if not mask.any():
        return
    axes = [
        _centers(*limits, count)
        for limits, count in zip((ax.get_xlim(), ax.get_ylim()), mask.shape[::-1], strict=True)
    ]
    drawn = ax.contourf(
        *axes, mask.astype(float), levels=[0.5, 1.5], colors="none", hatches=[style["hatch"]]
    )
    drawn.set_edgecolor(style["edgecolor"])
    drawn.set_linewidth(0.0)
    drawn.set_zorder(0.1)


def sharpen(
    regions: RegionMap, lines: Sequence[Array], window: Window, view: Window | None = None
) -> Labels:
    """Return the regions with borders that follow lines instead of the cells of the map.

    Shapes: lines (n, 2).

    A cell knows what is true at its center. A pixel near a line takes the number of a pixel away
    from all lines: of the one with the shortest way to it that crosses none.
    """
    labels = _sharpened(regions.first, regions.second, regions.labels, lines, window)
    if view is None or view == window:
        return labels
    # A region that is narrow in a part of the window is identified from where it is wide.
    first, second = (
        _centers(*interval, count) for interval, count in zip(window, PIXELS, strict=True)
    )
    return _sharpened(first, second, labels, lines, view)


def _sharpened(
    first: Array, second: Array, labels: Labels, lines: Sequence[Array], view: Window
) -> Labels:
    """Return the labels of cells with these centers as a picture of a part of the plane."""
    low = np.array([view[0][0], view[1][0]])
    pixel = (np.array([view[0][1], view[1][1]]) - low) / PIXELS
    columns, rows = (
        _nearest(cells, _centers(*view[i], PIXELS[i])) for i, cells in enumerate((first, second))
    )
    labels = labels[np.ix_(rows, columns)]
    barrier = _barrier(lines, low, pixel)
    if not barrier.any():
        return labels
    # Distances in cells of the map.
    sampling = [pixel[1] / _spacing(second), pixel[0] / _spacing(first)]
    # A strip three cells wide has no cells of its own: these may belong to the other side.
    sure = ndimage.distance_transform_edt(~barrier, sampling=sampling) > 3.0
    labels = _spread(labels, sure, ~(sure | barrier))
    nearest = ndimage.distance_transform_edt(barrier, return_distances=False, return_indices=True)
    return np.asarray(labels[tuple(nearest)])


def _spread(labels: Labels, known: Mask, open_: Mask) -> Labels:
    """Let known labels flow into open pixels, from neighbor to neighbor, all at one pace."""
    # A margin of closed pixels, so that a neighbor's place in the flat array is its own plus one.
    width = labels.shape[1] + 2
    flat, free = np.pad(labels, 1).ravel(), np.pad(open_, 1).ravel()
    front = np.flatnonzero(np.pad(known, 1).ravel())
    while front.size:
        reached = []
        for step in (1, -1, width, -width):
            source = front[free[front + step]]
            flat[source + step] = flat[source]
            free[source + step] = False
            reached.append(source + step)
        front = np.concatenate(reached)
    return flat.reshape(-1, width)[1:-1, 1:-1]


def region_labels(ax: Axes, regions: RegionMap) -> list[Label]:
    """Return the names of the regions with the places where each fits into its region."""
    size = 7.0  # of the font in points
    pictures = [image.get_array() for image in ax.images if image.get_gid() == PICTURE]
    if not pictures:
        return []
    labels = np.asarray(pictures[0])
    box = ax.get_window_extent()
    found = []
    for region in regions.regions:
        if region.motions:  # its colors say more than its name
            continue
        extent = _text_size(ax, region.name, size)
        # Half a character of free space around the text.
        width, height = (
            int(np.ceil((length + size) / whole * count))
            for length, whole, count in zip(extent, box.size, PIXELS, strict=True)
        )
        anchors = _places(labels == region.id, width, height)
        if len(anchors):
            low = np.array([ax.get_xlim()[0], ax.get_ylim()[0]])
            whole = np.array([np.ptp(ax.get_xlim()), np.ptp(ax.get_ylim())])
            found.append(
                Label(region.name, low + anchors * whole, "0.3", size, leader=False, centered=True)
            )
    return found


def shown_regions(regions: RegionMap) -> Iterator[Region]:
    """Yield one region of each kind, from the most quiet on; one that is not known comes last."""
    order = [*PALE]
    known = [region for region in reversed(regions.regions) if region.known]
    kinds = {(region.stable, region.name): region for region in known}
    yield from sorted(
        kinds.values(), key=lambda r: order.index(r.stable) if r.stable in order else len(order)
    )
    yield from [region for region in regions.regions if not region.known][:1]


def _centers(low: float, high: float, count: int) -> Array:
    """Return the centers of equal cells that fill an interval."""
    return low + (np.arange(count) + 0.5) * (high - low) / count


def _nearest(cells: Array, values: Array) -> NDArray[np.int64]:
    """Return the places of the cells whose centers lie nearest."""
    return np.asarray(np.searchsorted((cells[1:] + cells[:-1]) / 2, values), dtype=np.int64)


def _spacing(cells: Array) -> float:
    return float(np.diff(cells).mean()) if len(cells) > 1 else 1.0


def _barrier(lines: Sequence[Array], low: Array, pixel: Array) -> Mask:
    """Return the pixels on lines, with no gap through which their two sides would meet."""
    barrier = np.zeros(PIXELS[::-1], dtype=bool)
    for line in lines:
        places = (line - low) / pixel
        lengths = np.abs(np.diff(places, axis=0)).max(axis=1, initial=0.0)
        position = np.concatenate([[0.0], np.cumsum(lengths)])
        if len(places) < 2 or position[-1] == 0:
            continue
        dense = np.linspace(0.0, position[-1], min(int(2 * position[-1]) + 2, 200_000))
        points = np.column_stack([np.interp(dense, position, places[:, i]) for i in (0, 1)])
        inside = ((points >= 0) & (points < PIXELS)).all(axis=1)
        column, row = points[inside].astype(int).T
        barrier[row, column] = True
    return barrier


def _places(mask: Mask, width: int, height: int) -> Array:
    """Return centers of boxes that fit into an area, as fractions of the picture, shape (n, 2)."""
    sums = np.pad(mask.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    if width >= mask.shape[1] or height >= mask.shape[0]:
        return np.zeros((0, 2))
    inside = (
        sums[height:, width:]
        - sums[:-height, width:]
        - sums[height:, :-width]
        + sums[:-height, :-width]
    )
    row, column = np.nonzero(inside == width * height)
    chosen = np.linspace(0, len(row) - 1, min(len(row), 300)).astype(int)
    centers = np.column_stack([column + width // 2, row + height // 2])[chosen]
    # The roomiest first: it is taken where nothing else speaks against it.
    room = ndimage.distance_transform_edt(np.pad(mask, 1))[1:-1, 1:-1][*centers.T[::-1]]
    return np.asarray(centers[np.argsort(-room, kind="stable")] / mask.shape[::-1])


def _text_size(ax: Axes, text: str, size: float) -> Array:
    """Return width and height of a text in pixels of the figure."""
    trial = ax.text(0.5, 0.5, text, fontsize=size, transform=ax.transAxes)
    extent = trial.get_window_extent()
    trial.remove()
    return np.array([extent.width, extent.height])
