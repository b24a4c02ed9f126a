"""Arguments and options that several commands share."""

from __future__ import annotations

from typing import Annotated

import typer

__all__ = ["Json", "ModelName", "Out", "Sets"]

ModelName = Annotated[
    str,
    typer.Argument(
        metavar="MODEL",
        help="Name of a built-in model (see slipfold models), or a case file, e.g. case.toml.",
    ),
]

Sets = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        help="Value of a parameter: in SI units, or with a unit, e.g. alpha=60deg. Repeatable.",
    ),
]

Json = Annotated[
    str | None,
    typer.Option(
        "--json",
        metavar="FILE",
        help="Write the result as JSON; - is standard output, where nothing else is printed then.",
    ),
]

Out = Annotated[
    str | None,
    typer.Option("--out", metavar="FILE.nc", help="Write everything as netCDF."),
]
