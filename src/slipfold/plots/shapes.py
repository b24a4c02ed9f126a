"""Shapes of a structure on its mesh."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Normalize
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.models.structures.component import is_whole
from slipfold.models.structures.mesh import AXES, Mesh, MeshShapes
from slipfold.models.units import parse_quantity
from slipfold.plots.style import add_title, axes_or_new

COLORS = colormaps["viridis"]
"""Colors of displacements."""

SHARE = 0.1
"""Largest displacement drawn, over the size of the structure."""

TICKS = (5, 2)
"""Numbers along the longest axis in space, and along shorter ones."""


def draw_shape(
    shapes: MeshShapes, *, shape: int = 0, scale: float | None = None, ax: Any = None
) -> Axes:
    """Draw a shape over the mesh at rest; colors are displacements.

    A mesh in a plane of two axes that stays in it is drawn in this plane, others in space.
    """
    if not is_whole(shape, 0, len(shapes.labels) - 1):
        raise InputError(f"shape = {shape!r}; give a place from 0 to {len(shapes.labels) - 1}")
    if scale is not None and not np.isfinite(parse_quantity(scale, "", "scale")):
        raise InputError(f"scale = {scale}; give a finite number")
    mesh, moved = shapes.mesh, shapes.displacements[shape]
    sizes = np.linalg.norm(moved, axis=1)
    extent = float(np.ptp(mesh.points, axis=0).max())
    if scale is None:
        scale = SHARE * extent / float(sizes.max()) if sizes.any() else 1.0
    axes = _axes(shapes)
    if ax is None:
        projection = "3d" if len(axes) == 3 else None
        ax = plt.figure(layout="constrained").add_subplot(projection=projection)
    ax = axes_or_new(ax)
    still, deflected = mesh.points[:, axes], (mesh.points + scale * moved)[:, axes]
    norm = Normalize(0.0, float(sizes.max()) or 1.0)
    _add(ax, mesh, still, None, norm)
    _add(ax, mesh, deflected, sizes, norm)
    _frame(ax, np.vstack([still, deflected]), [AXES[axis] for axis in axes])
    bar = plt.cm.ScalarMappable(norm, COLORS)
    beside = 0.14 if len(axes) == 3 else 0.05  # a name stands between
    ax.figure.colorbar(bar, ax=ax, label="displacement (m)", shrink=0.7, pad=beside)
    times = "" if scale == 1 else f", drawn times {scale:.3g}"
    add_title(ax, f"{shapes.labels[shape]}{times}")
    return ax


def _axes(shapes: MeshShapes) -> list[int]:
    """Return the two axes of a plane in which mesh and shapes are, or all three."""
    extent = np.ptp(shapes.mesh.points, axis=0) + np.abs(shapes.displacements).max(axis=(0, 1))
    return [axis for axis in range(3) if extent[axis]] if np.sum(extent > 0) == 2 else [0, 1, 2]


def _add(ax: Any, mesh: Mesh, points: Array, sizes: Array | None, norm: Normalize) -> None:
    """Draw lines and faces, in colors of displacements or, at rest, as thin gray edges."""
    faces = mesh.faces()
    if not faces:
        shown = {"c": "0.7"} if sizes is None else {"c": sizes, "norm": norm, "cmap": COLORS}
        ax.scatter(*points.T, s=8, **shown)
    flat = points.shape[1] == 2
    for line, *makers in (
        (True, LineCollection, Line3DCollection),
        (False, PolyCollection, Poly3DCollection),
    ):
        nodes = [list(face) for face in faces if (len(face) == 2) == line]
        if not nodes:
            continue
        tints: Any = "none"
        style: dict[str, Any] = {"edgecolors": "0.75", "linewidths": 0.6}
        if sizes is not None:
            tints = COLORS(norm([sizes[face].mean() for face in nodes]))
            style = {"edgecolors": tints if line else "0.3", "linewidths": 2.0 if line else 0.3}
        if not line:
            style["facecolors"] = tints
        maker: Any = makers[0 if flat else 1]
        ax.add_collection(maker([points[face] for face in nodes], **style))


def _frame(ax: Any, points: Array, names: list[str]) -> None:
    """Set limits and names of the axes, the same scale on all. Shapes: points (m, 2 or 3)."""
    middle, half = (points.max(axis=0) + points.min(axis=0)) / 2, np.ptp(points, axis=0) / 2
    for axis, center, reach in zip(names, middle, half, strict=True):
        least = 0.1 * half.max() or 1.0
        span = 1.05 * max(float(reach), float(least))
        drawn = AXES[names.index(axis)]  # x and y of a drawing in a plane
        getattr(ax, f"set_{drawn}lim")(center - span, center + span)
        getattr(ax, f"set_{drawn}label")(f"{axis} (m)")
        if len(names) == 3:
            getattr(ax, f"{drawn}axis").set_major_locator(
                MaxNLocator(TICKS[int(span < half.max())])
            )
    if len(names) == 2:
        ax.set_aspect("equal")
    else:
        ax.set_box_aspect(np.maximum(half, 0.1 * half.max()))
