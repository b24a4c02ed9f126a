"""A view in any of the formats that it can be had in."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

from slipfold.computations.long_term import simulate
from slipfold.explorer.asked import asked_model
from slipfold.explorer.catalogue import Catalogue
from slipfold.explorer.computing import Computing
from slipfold.explorer.export.python_text import python_text
from slipfold.explorer.export.toml_text import toml_text
from slipfold.explorer.messages import (
    DiagramRequest,
    ExportRequest,
    OrbitRequest,
    PlaneRequest,
)
from slipfold.explorer.start import start_of, timed
from slipfold.results.orbit import orbit_csv, orbit_table
from slipfold.results.result import Result

MEDIA_TYPES = {
    "python": "text/x-python; charset=utf-8",
    "toml": "application/toml; charset=utf-8",
    "csv": "text/csv; charset=utf-8",
    "nc": "application/x-netcdf",
}
"""What each format is."""

SUFFIXES = {"python": "py", "toml": "toml", "csv": "csv", "nc": "nc"}
"""Ends of the names of files."""


def export_view(
    catalogue: Catalogue,
    computing: Computing,
    request: ExportRequest,
    check: Callable[[], None],
) -> bytes:
    """Make the content of a file."""
    view = request.view
    if request.format in ("python", "toml"):
        orbit = computing.orbit(view, check) if isinstance(view, OrbitRequest) else None
        model = asked_model(catalogue, view)
        file = catalogue.file(model)
        if request.format == "toml":
            return toml_text(model, view, file).encode()
        return python_text(model, view, orbit, file, request.readings).encode()
    if isinstance(view, OrbitRequest):
        found = computing.orbit(view, check)
        csv = request.format == "csv"
        return orbit_csv(found).encode() if csv else orbit_table(found).to_netcdf()
    result: Result
    if isinstance(view, DiagramRequest):
        result = computing.diagram(view, check)
    elif isinstance(view, PlaneRequest):
        result = computing.plane(view, check)
    else:
        model = asked_model(catalogue, view)
        result = simulate(timed(model, view), view.periods, start_of(model, view))
    return _written(result, request.format)


def _written(result: Result, form: str) -> bytes:
    """Let a result write itself; the name of the file is ours."""
    with tempfile.TemporaryDirectory(prefix="slipfold-") as folder:
        path = Path(folder) / "result"
        (result.save if form == "nc" else result.to_csv)(path)
        return path.read_bytes()
