"""A diagram as labelled arrays: the schema slipfold.response/1 of netCDF files."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.branch import Branch
from slipfold.results.attributes import result_attributes
from slipfold.results.checked_parts import checked_attributes
from slipfold.results.columns import (
    Columns,
    integers,
    joined,
    named_parameter,
    padded,
    quantity_labels,
    reals,
    stacked,
    texts,
)
from slipfold.results.labelled_table import LabelledTable, Variable

if TYPE_CHECKING:
    from slipfold.results.diagram import Diagram

__all__ = ["SCHEMA", "diagram_table"]

SCHEMA = "slipfold.response/1"

LABELS = ("branch", "branch_of_point", "branch_of_special", "parameter", "special_value")
"""Variables that label points and special points rather than hold results."""


def diagram_table(diagram: Diagram) -> LabelledTable:
    """Return all numbers of a diagram with their names, units and meanings."""
    labels = quantity_labels(diagram.model)
    variables = labels | _branches(diagram) | _points(diagram) | _special(diagram)
    model, vary = diagram.model, diagram.vary
    title = f"periodic responses of {model.name} over {vary}"
    attributes = {
        "vary": vary,
        "span": np.array(diagram.span, dtype=float),
        **result_attributes(SCHEMA, title, model, _input(diagram), diagram.provenance),
        **checked_attributes(diagram.checked),
    }
    return LabelledTable(variables, (*labels, *LABELS), attributes)


def _input(diagram: Diagram) -> dict[str, Any]:
    return {
        "vary": diagram.vary,
        "span": list(diagram.span),
        "settings": asdict(diagram.settings),
        "events": [asdict(event) for event in diagram.events],
    }


def _branches(diagram: Diagram) -> dict[str, Variable]:
    branches = diagram.branches
    unit = diagram.model.parameter(diagram.vary).unit
    columns = Columns("branch")
    columns.add("branch", integers(b.id for b in branches), "number of the branch")
    columns.add("branch_kind", texts(b.kind for b in branches), "kind of the branch")
    columns.add("branch_period", integers(b.period for b in branches), "in forcing periods", "")
    columns.add("branch_parent", integers(b.parent or 0 for b in branches), "branch left, 0: none")
    columns.add("node_count", integers(b.nodes.shape[1] for b in branches), "nodes of an orbit", "")
    for which, verb in (("begun", "begins"), ("stopped", "ends")):
        ends = [getattr(branch, which) for branch in branches]
        why = f"why the branch {verb} there"
        columns.add(f"{which}_kind", texts(end.kind for end in ends), f"{why}, in one word")
        columns.add(f"{which}_reason", texts(end.reason for end in ends), why)
        where = f"{diagram.vary} where the branch {verb}"
        columns.add(f"{which}_value", reals(end.value for end in ends), where, unit)
    return columns.variables


def _points(diagram: Diagram) -> dict[str, Variable]:
    branches, model = diagram.branches, diagram.model
    parameter = model.parameter(diagram.vary)
    n = len(model.states)
    outputs = (n + len(model.outputs()),)
    ids = [np.full(len(branch), branch.id, np.int64) for branch in branches]
    columns = Columns("point")
    add = columns.add
    add("branch_of_point", joined(ids, kind=np.int64), "branch the point lies on")
    about = named_parameter(parameter)
    add("parameter", joined(b.parameter for b in branches), about, parameter.unit)
    add("states", joined((b.states for b in branches), (n,)), "state at phase zero", None, "state")
    nodes = padded((b.nodes for b in branches), (_most_nodes(diagram), n))
    about = "states at equal phases over the period, the first node_count of the branch"
    add("nodes", nodes, about, None, "node", "state")
    multipliers = joined((b.multipliers for b in branches), (n,), complex)
    add("multipliers", multipliers, "Floquet multipliers", "", "multiplier")
    uncertainty = joined((b.multiplier_uncertainty for b in branches), (n,))
    about = "computed uncertainty of the multipliers"
    add("multiplier_uncertainty", uncertainty, about, "", "multiplier")
    unstable = joined((b.unstable for b in branches), kind=np.int64)
    add("unstable", unstable, "number of multipliers outside the unit circle", "")
    residual = joined(b.residual for b in branches)
    add("residual", residual, "how far the orbit fails to close, in scaled states", "")
    add("arclength", joined(b.arclength for b in branches), "in scaled variables", "")
    if not diagram.model.forced:
        durations = joined(_durations(b) for b in branches)
        add(
            "duration", durations, "of one round; of an equilibrium, what multipliers are over", "s"
        )
    for which in ("minimum", "maximum"):
        values = joined((getattr(b.extrema, which) for b in branches), outputs)
        add(which, values, f"{which} over the continuous orbit", None, "output")
    return columns.variables


def _special(diagram: Diagram) -> dict[str, Variable]:
    points, model = [item.point for item in diagram.special], diagram.model
    parameter = model.parameter(diagram.vary)
    n = len(model.states)
    outputs = (n + len(model.outputs()),)
    columns = Columns("special")
    add = columns.add
    add("branch_of_special", integers(b.id for b, _ in diagram.special), "branch it lies on")
    add("special_type", texts(p.type for p in points), "type of special point")
    add("special_name", texts(p.name for p in points), "what the type means here")
    add("special_value", reals(p.value for p in points), named_parameter(parameter), parameter.unit)
    uncertainty = reals(p.uncertainty for p in points)
    about = "computed uncertainty of special_value"
    add("special_uncertainty", uncertainty, about, parameter.unit)
    add("special_period", integers(p.period for p in points), "in forcing periods", "")
    add("special_node_count", integers(len(p.nodes) for p in points), "nodes of the orbit", "")
    nodes = padded((p.nodes[None] for p in points), (_most_nodes(diagram), n))
    about = "states at equal phases over the period, the first special_node_count"
    add("special_nodes", nodes, about, None, "node", "state")
    multipliers = stacked((p.multipliers for p in points), (n,), complex)
    add("special_multipliers", multipliers, "Floquet multipliers", "", "multiplier")
    uncertainty = stacked((p.multiplier_uncertainty for p in points), (n,))
    about = "computed uncertainty of the multipliers"
    add("special_multiplier_uncertainty", uncertainty, about, "", "multiplier")
    residual = reals(p.residual for p in points)
    add("special_residual", residual, "how far the orbit fails to close, in scaled states", "")
    add("special_arclength", reals(p.arclength for p in points), "position on the branch", "")
    add("special_criticality", texts(p.criticality or "" for p in points), "empty: none")
    add("special_coefficient", reals(p.coefficient for p in points), "of the normal form")
    add("special_leads_to", integers(p.leads_to or 0 for p in points), "branch begun, 0: none")
    if not model.forced:
        durations = reals(p.model.values["duration"] for p in points)
        add("special_duration", durations, "of one round", "s")
    extrema = [point.orbit.extrema for point in points]
    for which in ("minimum", "maximum"):
        values = stacked((getattr(item, which)[0] for item in extrema), outputs)
        add(f"special_{which}", values, f"{which} over the continuous orbit", None, "output")
    return columns.variables


def _durations(branch: Branch) -> NDArray[np.float64]:
    """Durations of one round at every point of a branch of an autonomous model."""
    if branch.durations is not None:
        return branch.durations
    return np.full(len(branch), branch.model.values["duration"])


def _most_nodes(diagram: Diagram) -> int:
    counts = [branch.nodes.shape[1] for branch in diagram.branches]
    return max([*counts, *(len(point.nodes) for _, point in diagram.special)], default=0)
