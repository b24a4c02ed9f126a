"""Nodes and elements of a structure, and shapes of it on them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np

from slipfold.arrays import Array, Indices, as_numbers
from slipfold.drawing import Drawn
from slipfold.errors import InputError, suggest
from slipfold.models.structures.component import brief, is_whole
from slipfold.models.structures.matrix_files import csv_table, node_name
from slipfold.read_only import Documented
from slipfold.text import OneLine, PrintedTable, listed, number_text
from slipfold.writing import to_read, write_file


class CellKind(NamedTuple):
    """What the nodes of an element mean."""

    vtk: int  # its number in VTK files
    size: int  # its corner nodes
    faces: tuple[tuple[int, ...], ...]  # corners around each face; of a line its two ends


CELLS: Mapping[str, CellKind] = {
    "line": CellKind(3, 2, ((0, 1),)),
    "triangle": CellKind(5, 3, ((0, 1, 2),)),
    "quad": CellKind(9, 4, ((0, 1, 2, 3),)),
    "tetra": CellKind(10, 4, ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))),
    "hexahedron": CellKind(
        12, 8, ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
    ),
    "wedge": CellKind(13, 6, ((0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))),
}
"""Kinds of elements by name, with their corners in the order of VTK and meshio."""

AXES = ("x", "y", "z")


@dataclass(frozen=True, eq=False, repr=False)
class Mesh(OneLine):
    """Nodes and elements of a structure, for pictures of its motion.

    A degree of freedom such as ``uz17`` is the displacement of node ``17`` along ``uz``.

    Parameters
    ----------
    nodes
        Names of the m nodes.
    points
        Their coordinates in m, shape (m, 3) or (m, 2).
    cells
        Elements, each as its kind and the places of its nodes: ``("line", (0, 1))``. Kinds are
        line, triangle, quad, tetra, hexahedron and wedge.
    directions
        Axis x, y or z of each direction in the names of degrees of freedom; ``ux uy uz`` if None.

    Examples
    --------
    >>> Mesh(["1", "2"], [[0, 0], [1, 0]], [("line", (0, 1))])
    <Mesh: 2 nodes, 1 elements>
    """

    nodes: tuple[str, ...]
    points: Array
    cells: tuple[tuple[str, tuple[int, ...]], ...]
    directions: Mapping[str, str] | None = None

    def __post_init__(self) -> None:
        """Check that all parts fit each other."""
        named: Any = self.nodes
        cells: Any = self.cells
        axes: Any = {} if self.directions is None else self.directions
        several = isinstance(named, Iterable) and not isinstance(named, str | bytes)
        nodes = tuple(map(str, named)) if several else ()
        if len(set(nodes)) < len(nodes) or not nodes:
            raise InputError(
                "a node of the mesh is there twice; give each once"
                if nodes
                else f"nodes = {brief(named)}; give the names of the nodes"
            )
        object.__setattr__(self, "nodes", nodes)
        object.__setattr__(self, "points", self._checked_points())
        given = cells if isinstance(cells, list | tuple) else [cells]
        object.__setattr__(self, "cells", tuple(map(self._checked_cell, given)))
        if not isinstance(axes, Mapping):
            raise InputError(f"directions = {brief(axes)}; give e.g. {{'w': 'z'}}")
        for name, axis in axes.items():
            if not isinstance(name, str) or axis not in AXES:
                raise InputError(
                    f"the direction {brief(name)} of the mesh is along {brief(axis)}; give x, y "
                    "or z"
                )

    def _checked_points(self) -> Array:
        points, count = as_numbers(self.points), len(self.nodes)
        if points.ndim != 2 or points.shape[1] not in (2, 3) or len(points) != count:
            raise InputError(
                f"{count} nodes have coordinates of shape {points.shape}; give two or three "
                "numbers a node"
            )
        if not np.isfinite(points).all():
            bad = self.nodes[int(np.argmin(np.isfinite(points).all(axis=1)))]
            raise InputError(f"the coordinates of node {bad} are not finite; give numbers in m")
        return np.hstack([points, np.zeros((count, 3 - points.shape[1]))])

    def _checked_cell(self, given: Any) -> tuple[str, tuple[int, ...]]:
        pair = given if isinstance(given, list | tuple) and len(given) == 2 else (given, ())
        kind, places = pair
        if not isinstance(kind, str) or kind not in CELLS:
            near = suggest(kind, CELLS) if isinstance(kind, str) else ""
            raise InputError(
                f"the mesh has the element {brief(kind)}, which is unknown; {near}give a kind, "
                f"{', '.join(CELLS)}, and the places of its nodes"
            )
        size, count = CELLS[kind].size, len(self.nodes)
        known = isinstance(places, list | tuple) and len(places) == size
        if not known or not all(is_whole(one, 0, count - 1) for one in places):
            raise InputError(
                f"a {kind} of the mesh has the nodes {brief(places)}; give {size} places from 0 "
                f"to {count - 1}"
            )
        return kind, tuple(map(int, places))

    @classmethod
    def read(
        cls,
        path: str | Path,
        elements: str | Path | None = None,
        directions: Mapping[str, str] | None = None,
    ) -> Mesh:
        """Read a mesh from CSV files, or from a file of a finite-element program.

        Parameters
        ----------
        path
            A CSV file with the columns ``node``, ``x``, ``y`` and perhaps ``z`` in m; or any file
            that meshio reads, for which ``pip install slipfold[mesh]`` is needed. Nodes of such
            a file are called 1, 2, and so on.
        elements
            A CSV file whose columns that begin with ``node`` name the nodes of an element, two to
            eight a row, and perhaps a column ``type``; without it two nodes are a line, three a
            triangle, four a quad, six a wedge and eight a hexahedron.
        directions
            As of the class.
        """
        path = to_read(path)
        if path.suffix.lower() != ".csv":
            return _by_meshio(path, directions)
        rows = _table(path, ("node", "x", "y"))
        nodes = [row["node"] for row in rows]
        points = [[_coordinate(row, axis, path) for axis in AXES] for row in rows]
        cells: list[tuple[str, tuple[int, ...]]] = []
        if elements is not None:
            cells = _cells(Path(elements), {name: place for place, name in enumerate(nodes)})
        return cls(tuple(nodes), np.array(points).reshape(-1, 3), tuple(cells), directions)

    def around(self, sectors: int, axis: str = "z") -> Mesh:
        """Return the mesh of equal sectors, of which this is one.

        Parameters
        ----------
        sectors
            Their number; each is turned by a part of a revolution from the one before.
        axis
            The axis x, y or z about which.

        Returns
        -------
        Mesh
            Nodes of the others end in ``_s1``, ``_s2`` and so on.
        """
        turns = turns_about(axis, sectors)
        size = len(self.nodes)
        names = (f"{name}_s{at}" if at else name for at in range(sectors) for name in self.nodes)
        cells = (
            (kind, tuple(size * at + place for place in places))
            for at in range(sectors)
            for kind, places in self.cells
        )
        points = np.vstack([self.points @ turn.T for turn in turns])
        return Mesh(tuple(names), points, tuple(cells), self.directions)

    def faces(self) -> list[tuple[int, ...]]:
        """Return the places of nodes: of lines, and of faces that are not between two elements."""
        seen: dict[frozenset[int], list[tuple[int, ...]]] = {}
        for kind, places in self.cells:
            for face in CELLS[kind].faces:
                nodes = tuple(places[corner] for corner in face)
                seen.setdefault(frozenset(nodes), []).append(nodes)
        return [faces[0] for faces in seen.values() if len(faces) == 1]

    def rows(self, names: Sequence[str]) -> Indices:
        """Return where displacements of nodes are among degrees of freedom, -1 for none.

        Parameters
        ----------
        names
            Names of degrees of freedom.

        Returns
        -------
        Array
            Places, shape (m, 3).
        """
        known = {name: place for place, name in enumerate(names)}
        result = np.full((len(self.nodes), 3), -1, dtype=np.int64)
        directions = self.directions or {f"u{axis}": axis for axis in AXES}
        for direction, axis in directions.items():
            places = [known.get(node_name(node, direction), -1) for node in self.nodes]
            result[:, AXES.index(axis)] = places
        if not (result >= 0).any():
            raise InputError(
                f"no degree of freedom is that of a node of the mesh along "
                f"{' '.join(directions)}: it has {listed(self.nodes)}, the structure "
                f"{listed(names)}; give directions such as {{'w': 'z'}}, or names by node"
            )
        return result

    def _line(self) -> str:
        return f"Mesh: {len(self.nodes)} nodes, {len(self.cells)} elements"

    def _rows(self) -> PrintedTable:
        rows = zip(self.nodes, self.points, strict=True)
        lines = [[node, *map(number_text, point)] for node, point in rows]
        return PrintedTable(["node", *(f"{axis} (m)" for axis in AXES)], lines)


def turns_about(axis: str, sectors: int) -> Array:
    """Return the rotations about an axis from one sector to each, shape (sectors, 3, 3)."""
    if axis not in AXES:
        raise InputError(f"axis = {axis!r} is none; give x, y or z")
    first = AXES.index(axis)
    a, b = (first + 1) % 3, (first + 2) % 3
    angles = 2 * np.pi * np.arange(sectors) / sectors
    turns = np.tile(np.eye(3), (sectors, 1, 1))
    turns[:, a, a] = turns[:, b, b] = np.cos(angles)
    turns[:, b, a] = np.sin(angles)
    turns[:, a, b] = -turns[:, b, a]
    return turns


def _table(path: Path, needed: Sequence[str]) -> list[dict[str, str]]:
    """Return the rows of a CSV file by its columns."""
    columns, rows = csv_table(path, "a CSV file of the mesh")
    if missing := [name for name in needed if name not in columns]:
        raise InputError(
            f"{path} has the columns {listed(columns, 'nothing')}; its first row must hold "
            f"{', '.join(needed)}, of which {missing[0]} is missing"
        )
    return rows


def _coordinate(row: Mapping[str, str], axis: str, path: Path) -> float:
    try:
        return float(row.get(axis, "0"))
    except ValueError:
        raise InputError(
            f"{path} has {axis} = {row[axis][:40]!r} for the node {row['node']}; give a number in m"
        ) from None


_BY_SIZE = {2: "line", 3: "triangle", 4: "quad", 6: "wedge", 8: "hexahedron"}


def _cells(path: Path, places: Mapping[str, int]) -> list[tuple[str, tuple[int, ...]]]:
    """Read elements by the names of their nodes."""
    result = []
    for line, row in enumerate(_table(path, ()), 2):
        named = [value for key, value in row.items() if key.startswith("node") and value]
        for name in named:
            if name not in places:
                raise InputError(
                    f"{path} has the node {name[:40]!r} in line {line}, which has no coordinates; "
                    f"{suggest(name, places)}the mesh has {listed(places)}"
                )
        kind = row.get("type") or _BY_SIZE.get(len(named), "")
        if not kind:
            raise InputError(
                f"{path} has an element of {len(named)} nodes in line {line}; give 2, 3, 4, 6 or "
                "8 in columns that begin with node, or its type"
            )
        result.append((kind, tuple(places[name] for name in named)))
    return result


def _by_meshio(path: Path, directions: Mapping[str, str] | None) -> Mesh:
    """Read a mesh with meshio; elements with nodes between corners keep their corners."""
    try:
        import meshio
    except ImportError:
        raise InputError(
            f"{path} is read by the package meshio, which is not installed; install "
            "slipfold[mesh], or save nodes and elements as CSV files"
        ) from None
    try:
        found: Any = meshio.read(path)
    except (Exception, SystemExit) as error:  # its readers fail in many ways, and may exit
        raise InputError(f"{path} cannot be read as a mesh ({error}); save it again") from None
    cells = []
    for block in found.cells:
        kind = block.type.rstrip("0123456789")
        if kind in CELLS:
            corners = np.asarray(block.data)[:, : CELLS[kind].size]
            cells += [(kind, tuple(map(int, places))) for places in corners]
    nodes = tuple(str(number + 1) for number in range(len(found.points)))
    return Mesh(nodes, np.asarray(found.points, dtype=float), tuple(cells), directions)


@dataclass(frozen=True, eq=False, repr=False)
class MeshShapes(OneLine, Drawn, Documented):
    """Displacements of the nodes of a mesh: modes of a structure, or its motion at some times.

    `plot` draws one of them: ``shape`` is its place, ``scale`` multiplies displacements, of which
    the largest is a tenth of the structure if None, and ``ax`` has the axes.
    """

    mesh: Annotated[Mesh, "The mesh."]
    displacements: Annotated[
        Array, "In m, shape (k, m, 3); those of nodes without degrees of freedom are zero."
    ]
    labels: Annotated[tuple[str, ...], "What each of the k shapes is."]

    @property
    def amplitude(self) -> MeshShapes:
        """Half of the range of each displacement over all shapes, as one shape."""
        half = np.ptp(self.displacements, axis=0)[None] / 2
        return MeshShapes(self.mesh, half, (f"amplitude over {len(self.labels)} times",))

    def save(self, path: str | Path) -> Path:
        """Write mesh and shapes to a VTK file, which ParaView and others read.

        Parameters
        ----------
        path
            Path of the file; it ends in ``.vtk``.
        """
        path = Path(path)
        if path.suffix != ".vtk":
            raise InputError(f"{path} ends in {path.suffix or 'nothing'}; shapes are saved as .vtk")
        cells = self.mesh.cells
        count = len(self.mesh.nodes)
        lines = ["# vtk DataFile Version 3.0", "shapes of a structure", "ASCII"]
        lines += [
            "DATASET UNSTRUCTURED_GRID",
            f"POINTS {count} double",
            *_vectors(self.mesh.points),
        ]
        lines.append(f"CELLS {len(cells)} {sum(1 + len(places) for _, places in cells)}")
        lines += [" ".join(map(str, (len(places), *places))) for _, places in cells]
        lines.append(f"CELL_TYPES {len(cells)}")
        lines += [str(CELLS[kind].vtk) for kind, _ in cells]
        lines.append(f"POINT_DATA {count}")
        for number, (label, shape) in enumerate(
            zip(self.labels, self.displacements, strict=True), 1
        ):
            # Names have no blanks in this format.
            name = f"{number}_{'_'.join(label.replace('=', ' ').split())}"
            lines += [f"VECTORS {name} double", *_vectors(shape)]
        write_file(path, ("\n".join(lines) + "\n").encode())
        return path

    def _line(self) -> str:
        return f"MeshShapes: {len(self.labels)} shapes of {len(self.mesh.nodes)} nodes"

    def _rows(self) -> PrintedTable:
        largest = np.linalg.norm(self.displacements, axis=2).max(axis=1)
        rows = zip(self.labels, largest, strict=True)
        return PrintedTable(["shape", "largest (m)"], [[name, number_text(u)] for name, u in rows])


def _vectors(rows: Array) -> list[str]:
    return [" ".join(f"{value:.17g}" for value in row) for row in rows]
