"""A diagram made again from its labelled arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.branch import Branch, End
from slipfold.branches.event import Event
from slipfold.branches.special_point import SpecialPoint
from slipfold.orbits.extrema import Extrema
from slipfold.results.checked_parts import read_checked
from slipfold.results.diagram import Diagram
from slipfold.results.saved_table import SavedTable

__all__ = ["read_diagram"]


def read_diagram(saved: SavedTable) -> Diagram:
    """Make a diagram from the arrays that `diagram_table` made of one."""
    given, vary = saved.given, str(saved.given["vary"])
    saved.model.parameter(vary)
    points = saved.rows("point", "branch_of_point")
    special = saved.rows("special", "branch_of_special")
    branches = tuple(
        _branch(saved, vary, row, points[identity], special[identity])
        for row, identity in enumerate(saved.columns["branch"].tolist())
    )
    first, last = given["span"]
    return Diagram(
        saved.model,
        vary,
        (float(first), float(last)),
        branches,
        saved.settings,
        tuple(Event(**event) for event in given["events"]),
        saved.provenance,
        read_checked(saved.attributes),
    )


def _branch(
    saved: SavedTable,
    vary: str,
    row: int,
    points: NDArray[np.int64],
    special: NDArray[np.int64],
) -> Branch:
    columns = saved.columns
    model, durations, kind = saved.model, None, str(columns["branch_kind"][row])
    if not model.forced and len(points):
        durations = columns["duration"][points]
        model = model.replace(duration=float(durations[0]))
    branch = Branch(
        id=int(columns["branch"][row]),
        kind=kind,
        period=int(columns["branch_period"][row]),
        parent=int(columns["branch_parent"][row]) or None,
        model=model,
        vary=vary,
        parameter=columns["parameter"][points],
        nodes=columns["nodes"][points, : int(columns["node_count"][row])],
        multipliers=saved.complex("multipliers", points),
        residual=columns["residual"][points],
        arclength=columns["arclength"][points],
        special=tuple(_special(saved, vary, int(each)) for each in special),
        stopped=_end(saved, "stopped", row),
        begun=_end(saved, "begun", row),
        durations=durations,
    )
    # What the branch would compute when asked is in the file already.
    names = tuple(columns["output"].tolist())
    vars(branch)["extrema"] = Extrema(names, columns["minimum"][points], columns["maximum"][points])
    vars(branch)["multiplier_uncertainty"] = columns["multiplier_uncertainty"][points]
    return branch


def _special(saved: SavedTable, vary: str, row: int) -> SpecialPoint:
    columns = saved.columns
    value = float(columns["special_value"][row])
    coefficient = float(columns["special_coefficient"][row])
    changes = {vary: value}
    if not saved.model.forced:
        changes["duration"] = float(columns["special_duration"][row])
    return SpecialPoint(
        type=str(columns["special_type"][row]),
        name=str(columns["special_name"][row]),
        model=saved.model.replace(**changes),
        vary=vary,
        value=value,
        uncertainty=float(columns["special_uncertainty"][row]),
        period=int(columns["special_period"][row]),
        nodes=columns["special_nodes"][row, : int(columns["special_node_count"][row])],
        multipliers=saved.complex("special_multipliers", row),
        multiplier_uncertainty=columns["special_multiplier_uncertainty"][row],
        residual=float(columns["special_residual"][row]),
        arclength=float(columns["special_arclength"][row]),
        criticality=str(columns["special_criticality"][row]) or None,
        coefficient=None if np.isnan(coefficient) else coefficient,
        leads_to=int(columns["special_leads_to"][row]) or None,
    )


def _end(saved: SavedTable, which: str, row: int) -> End:
    columns = saved.columns
    return End(
        str(columns[f"{which}_kind"][row]),
        str(columns[f"{which}_reason"][row]),
        float(columns[f"{which}_value"][row]),
    )
