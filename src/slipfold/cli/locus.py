"""``slipfold locus``: bifurcations followed in two parameters, and the regions between them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from slipfold.cli.carry_out import carry_out
from slipfold.cli.case_file import find_model
from slipfold.cli.options import Csv, Friction, Json, MaxPoints, MaxStep, Out, Sets, Tolerance
from slipfold.cli.outputs import Outputs
from slipfold.cli.parsing import (
    parse_assignments,
    parse_points,
    parse_whole,
    parse_window,
    refuse_varied,
)
from slipfold.cli.settings import parse_settings
from slipfold.cli.special_points import labelled_points, load_response, matching_points
from slipfold.cli.status import DONE, FAILED, INTERRUPTED, note
from slipfold.errors import InputError

if TYPE_CHECKING:
    from slipfold.results.locus_diagram import LocusDiagram

Given = Annotated[
    str,
    typer.Argument(
        metavar="MODEL|RESPONSE.nc",
        help="Name of a built-in model (see slipfold models), or a case file, e.g. case.toml: all "
        "bifurcations in the window. Or a file that slipfold response --out wrote: those that pass "
        "its special points.",
    ),
]
Vary = Annotated[
    list[str],
    typer.Option(
        metavar="NAME=FIRST:LAST",
        help="One of the two parameters and its range, e.g. f=11.5:13.5Hz; give it twice.",
    ),
]
Types = Annotated[
    list[str] | None,
    typer.Option(
        "--type",
        metavar="LP|PD|NS|BP|HB|GRAZE|LIFT|STICK",
        help="Type of bifurcation to follow: fold, period doubling, Neimark-Sacker, branch point, "
        "Hopf of an autonomous model, where contacts begin to stick or to lift off; all by "
        "default. With RESPONSE.nc, type of its points to start from. Repeatable.",
    ),
]
Periods = Annotated[
    list[str] | None,
    typer.Option(
        "--period",
        metavar="1|2",
        help="Period of the orbits in forcing periods; both by default. With RESPONSE.nc, any "
        "period of its points to start from; all by default. Repeatable.",
    ),
]
Labels = Annotated[
    list[str] | None,
    typer.Option(
        "--label",
        metavar="LAB",
        help="With RESPONSE.nc, its special point to start from, by its number under LAB in the "
        "printed table; all by default. Repeatable.",
    ),
]
Only = Annotated[
    bool,
    typer.Option(
        "--only",
        help="With RESPONSE.nc, follow the loci through its special points alone, and none that "
        "start at points of codimension two on them.",
    ),
]
Regions = Annotated[
    bool,
    typer.Option(
        "--regions",
        help="Find the regions between the loci and the stable responses in each, checked by "
        "simulations; takes a forced model, all types and both periods.",
    ),
]
Regimes = Annotated[
    str | None,
    typer.Option(
        metavar="N1xN2",
        help="With --regions, simulate on a grid of so many places what happens where no response "
        "of period 1 or 2 is stable: higher periods, tori, chaos; e.g. 60x50.",
    ),
]


def locus(
    model: Given,
    vary: Vary,
    set_: Sets = None,
    friction: Friction = None,
    label: Labels = None,
    only: Only = False,
    type_: Types = None,
    period: Periods = None,
    regions: Regions = False,
    regimes: Regimes = None,
    json: Json = None,
    out: Out = None,
    csv: Csv = None,
    max_step: MaxStep = None,
    tolerance: Tolerance = None,
    max_points: MaxPoints = None,
) -> int:
    """Find all bifurcations in a window of two parameters, and follow them through it.

    With a saved response, follow those that pass its special points, and what starts on them.

    Ctrl-C keeps what is finished. Exit status: 0 done, 2 bad input, 3 a locus could not be followed
    to its end, 130 interrupted.
    """
    from slipfold.loci.bifurcation_set import PERIODS

    outputs = Outputs(json, out, csv).checked()
    types = [text.upper() for text in type_] if type_ else None
    periods = [parse_whole(text, "--period") for text in period] if period else None
    settings = parse_settings(max_step, tolerance, max_points)
    compute: partial[LocusDiagram]
    if model.lower().endswith(".nc"):
        from slipfold.computations.locus import locus as follow

        given = [f"--set {item}" for item in set_ or ()]
        given += [] if friction is None else [f"--friction {friction}"]
        _refuse(model, given, regions or regimes is not None, bool(label and (types or periods)))
        response = load_response(model)
        chosen = response.model
        plane, window = parse_window(vary, chosen)
        if label:
            points = labelled_points(response, model, label)
        else:
            points = matching_points(response, model, (plane, window), types, periods)
        compute = partial(follow, points, plane, window, switch=not only)
    else:
        from slipfold.computations.bifurcation_set import bifurcation_set

        if label:
            raise InputError(
                f"--label {label[0]} is for a saved response, but {model} is a model; give a file "
                "that slipfold response --out wrote, or leave out --label"
            )
        if only:
            raise InputError(
                f"--only is for a saved response, but {model} is a model, whose loci are looked "
                "for; give a file that slipfold response --out wrote, or --type"
            )
        if regimes is not None and not regions:
            raise InputError(f"--regimes {regimes} needs --regions; give both")
        values = parse_assignments(set_)
        chosen = find_model(model, values, friction)
        plane, window = parse_window(vary, chosen, "a bifurcation set")
        refuse_varied(values, plane)
        compute = partial(
            bifurcation_set,
            chosen,
            plane,
            window,
            types=types,
            periods=periods or PERIODS,
            regions=regions,
            regimes=None if regimes is None else parse_points(regimes, "--regimes", 1),
        )
    diagram = carry_out(lambda observer: compute(settings=settings, observer=observer), outputs)
    return _conclude(diagram, outputs)


def _refuse(path: str, given: Sequence[str], regions: bool, both: bool) -> None:
    """Refuse what does not go with a saved response."""
    if given:
        raise InputError(
            f"{given[0]} is for a model, but the parameters of {path} are those it was "
            f"computed with; leave out {given[0].split()[0]}"
        )
    if regions:
        raise InputError(
            f"--regions needs all loci in the window, but only those of {path} are followed; give "
            "a model, or leave out --regions"
        )
    if both:
        raise InputError(
            "--label says already which special points are meant; leave out --type and --period"
        )


def _conclude(diagram: LocusDiagram, outputs: Outputs) -> int:
    if diagram.interrupted:
        points = sum(len(item) for item in diagram.loci)
        number = len(diagram.loci)
        loci = "1 locus" if number == 1 else f"{number} loci"
        note(f"interrupted after {points} points on {loci}; {outputs.kept}")
        return INTERRUPTED
    for item in diagram.loci:
        for end in (item.begun, item.stopped):
            if end.early:
                note(f"locus {item.id} stopped early: {end.reason}")
    return FAILED if diagram.failed else DONE
