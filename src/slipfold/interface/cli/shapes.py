"""``slipfold shapes``: modes of a structure on its mesh."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from slipfold.declarations import Option
from slipfold.errors import InputError
from slipfold.interface.cli.plot import FORMATS
from slipfold.interface.cli.running import note

if TYPE_CHECKING:
    from slipfold.models.model import Model

MeshFile = Annotated[
    str,
    Option("Nodes as CSV with the columns node, x, y, z in m, or a mesh that meshio reads.",
           metavar="FILE"),
]  # fmt: skip
Elements = Annotated[
    str | None, Option("Elements as CSV: columns node1, node2, ... of each.", metavar="FILE")
]
Directions = Annotated[
    tuple[str, ...],
    Option("Axis of displacements not called ux, uy, uz, e.g. w=z.", "texts", "NAME=AXIS"),
]
Modes = Annotated[int, Option("Modes, lowest first.")]
Mode = Annotated[int, Option("Mode that a figure shows.")]
Axis = Annotated[
    str | None, Option("Of a cyclic structure: the axis x, y or z of all sectors.", metavar="AXIS")
]
Out = Annotated[
    str, Option("File to write: .vtk for ParaView, or .png, .pdf or .svg.", metavar="FILE")
]


def shapes(
    model: Model,
    mesh: MeshFile,
    elements: Elements = None,
    directions: Directions = (),
    modes: Modes = 6,
    mode: Mode = 1,
    axis: Axis = None,
    out: Out = "shapes.vtk",
) -> None:
    """Write the modes of a structure on its mesh, or draw one of them."""
    from slipfold.models.structures.mesh import Mesh
    from slipfold.models.structures.structure import Structure
    from slipfold.writing import check_writable, write_file

    path = Path(out)
    form = path.suffix.lower().lstrip(".")
    if form not in ("vtk", *FORMATS):
        raise InputError(f"shapes cannot be written to {path}; give .vtk, .png, .pdf or .svg")
    check_writable(path)
    if not isinstance(model, Structure):
        raise InputError(f"{model.name} has no mesh; give a structure of matrices")
    named = dict(text.partition("=")[::2] for text in directions or ())
    found = model.shapes(
        Mesh.read(mesh, elements, named or None), modes=max(modes, mode), axis=axis
    )
    if form == "vtk":
        found.save(path)
    else:
        write_file(path, _figure(found.plot(shape=mode - 1), form))
    note(f"wrote {path}: {', '.join(found.labels)}")


def _figure(axes: Any, form: str) -> bytes:
    from matplotlib import pyplot

    content = io.BytesIO()
    axes.figure.savefig(content, format=form)
    pyplot.close(axes.figure)
    return content.getvalue()
