"""Arguments and options that several commands share."""

from __future__ import annotations

from typing import Annotated

import typer

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

Friction = Annotated[
    str | None,
    typer.Option(
        metavar="LAW",
        help="Friction law of the sliding oscillator, e.g. stribeck; its parameters are then set "
        "and varied like others, see slipfold models sliding --friction LAW.",
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

Csv = Annotated[
    str | None,
    typer.Option("--csv", metavar="FILE", help="Write all points as comma-separated values."),
]

MaxStep = Annotated[
    str | None,
    typer.Option(metavar="S", help="Largest step from point to point, in scaled arclength."),
]

Start = Annotated[
    list[str] | None,
    typer.Option(
        "--start",
        metavar="NAME=VALUE",
        help="Starting state, else the model's own: of a motion; of a response an orbit near it is "
        "followed, with --settled what a motion from it settles to. With a value of the parameter "
        "varied the branch begins there, in both directions. Repeatable.",
    ),
]

States = Annotated[
    list[str] | None,
    typer.Option(
        "--start",
        "--state",
        metavar="NAME=VALUE",
        help="Starting state at phase zero, else the model's own. Repeatable.",
    ),
]

Box = Annotated[
    list[str] | None,
    typer.Option(
        "--box",
        metavar="NAME=LEAST:LARGEST",
        help="Starting values of a state at phase zero; other states are at the model's start. "
        "Repeatable; by default all states, about their typical sizes.",
    ),
]

Starts = Annotated[
    str, typer.Option(metavar="N", help="Number of starts in the box, of each value if one varies.")
]

Seed = Annotated[str, typer.Option(metavar="N", help="Seed of starts or samples.")]

VaryOne = Annotated[
    list[str],
    typer.Option("--vary", metavar="NAME=FIRST:LAST", help="Parameter and its ends."),
]

PointsOfOne = Annotated[str, typer.Option(metavar="N", help="Values of the parameter.")]

SearchPeriods = Annotated[
    str | None,
    typer.Option(
        metavar="N",
        help="Forcing periods after which a motion that came to nothing known is measured by its "
        "exponents, 1024 by default; of an autonomous model intervals of its pace.",
    ),
]

Tolerance = Annotated[
    str | None, typer.Option(metavar="R", help="Largest residual of an orbit, in scaled states.")
]

MaxPoints = Annotated[
    str | None, typer.Option(metavar="N", help="Points after which a branch or locus stops.")
]
