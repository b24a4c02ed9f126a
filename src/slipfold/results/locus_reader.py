"""A diagram of loci made again from its labelled arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.loci.locus import Locus, LocusEnd, LocusPoint
from slipfold.results.checked_parts import read_checked
from slipfold.results.locus_diagram import LocusDiagram
from slipfold.results.region_table import read_regions
from slipfold.results.saved_table import SavedTable

__all__ = ["read_locus_diagram"]


def read_locus_diagram(saved: SavedTable) -> LocusDiagram:
    """Make a diagram of loci from the arrays that `locus_table` made of one."""
    given = saved.given
    first, second = (saved.model.parameter(name).name for name in given["vary"])
    (a, b), (c, d) = given["window"]
    return LocusDiagram(
        saved.model,
        (first, second),
        ((float(a), float(b)), (float(c), float(d))),
        _loci(saved, (first, second)),
        read_regions(saved) if given["regions"] else None,
        saved.settings,
        saved.provenance,
        bool(given["interrupted"]),
        read_checked(saved.attributes),
    )


def _loci(saved: SavedTable, vary: tuple[str, str]) -> tuple[Locus, ...]:
    points = saved.rows("point", "locus_of_point")
    special = saved.rows("special", "locus_of_special")
    coefficients = saved.rows("normal_form", "special_of_normal_form")
    loci = []
    for row, identity in enumerate(saved.columns["locus"].tolist()):
        found = tuple(
            _point(saved, vary, int(each), coefficients[int(each)]) for each in special[identity]
        )
        loci.append(_locus(saved, vary, row, points[identity], found))
    return tuple(loci)


def _locus(
    saved: SavedTable,
    vary: tuple[str, str],
    row: int,
    points: NDArray[np.int64],
    special: tuple[LocusPoint, ...],
) -> Locus:
    columns = saved.columns
    base = dict(zip(vary, saved.pair("locus_base", row), strict=True))
    kind = str(columns["locus_kind"][row])
    durations = None if saved.model.forced else columns["duration"][points]
    if durations is not None:
        base["duration"] = float(durations[0])
    return Locus(
        id=int(columns["locus"][row]),
        type=str(columns["locus_type"][row]),
        kind=kind,
        period=int(columns["locus_period"][row]),
        parent=int(columns["locus_parent"][row]) or None,
        model=saved.model.replace(**base),
        vary=vary,
        values=columns["value"][points],
        nodes=columns["nodes"][points, : int(columns["node_count"][row])],
        multipliers=saved.complex("multipliers", points),
        coefficient=columns["coefficient"][points],
        residual=columns["residual"][points],
        arclength=columns["arclength"][points],
        special=special,
        begun=_end(saved, "begun", row),
        stopped=_end(saved, "stopped", row),
        durations=durations if kind == "periodic" else None,
    )


def _point(
    saved: SavedTable, vary: tuple[str, str], row: int, coefficients: NDArray[np.int64]
) -> LocusPoint:
    columns = saved.columns
    values = saved.pair("special_value", row)
    changes = dict(zip(vary, values, strict=True))
    if not saved.model.forced:
        changes["duration"] = float(columns["special_duration"][row])
    return LocusPoint(
        type=str(columns["special_type"][row]),
        name=str(columns["special_name"][row]),
        kind=str(columns["special_kind"][row]),
        model=saved.model.replace(**changes),
        vary=vary,
        values=values,
        uncertainty=saved.pair("special_uncertainty", row),
        period=int(columns["special_period"][row]),
        nodes=columns["special_nodes"][row, : int(columns["special_node_count"][row])],
        multipliers=saved.complex("special_multipliers", row),
        residual=float(columns["special_residual"][row]),
        arclength=float(columns["special_arclength"][row]),
        coefficients={
            str(columns["normal_form_name"][each]): float(columns["normal_form_value"][each])
            for each in coefficients
        },
        leads_to=saved.integers("special_leads_to", row),
    )


def _end(saved: SavedTable, which: str, row: int) -> LocusEnd:
    return LocusEnd(
        str(saved.columns[f"{which}_kind"][row]),
        str(saved.columns[f"{which}_reason"][row]),
        saved.pair(f"{which}_value", row),
    )
