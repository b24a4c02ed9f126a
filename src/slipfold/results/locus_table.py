"""Loci as labelled arrays: the schema slipfold.locus/1 of netCDF files."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from slipfold.loci.locus import Locus
from slipfold.results.attributes import result_attributes
from slipfold.results.checked_parts import checked_attributes
from slipfold.results.columns import (
    Columns,
    integers,
    joined,
    named_parameter,
    padded,
    padded_integers,
    reals,
    stacked,
    state_labels,
    texts,
)
from slipfold.results.criticality import criticalities
from slipfold.results.labelled_table import LabelledTable, Variable
from slipfold.results.region_table import REGION_LABELS, region_variables

if TYPE_CHECKING:
    from slipfold.results.locus_diagram import LocusDiagram

__all__ = ["SCHEMA", "locus_table"]

SCHEMA = "slipfold.locus/1"

LABELS = ("locus", "locus_of_point", "locus_of_special", "special_of_normal_form")
"""Variables that say what belongs to what."""


def locus_table(diagram: LocusDiagram) -> LabelledTable:
    """Return all numbers of a diagram of loci with their names, units and meanings."""
    labels = state_labels(diagram.model) | _parameters(diagram)
    variables = labels | _loci(diagram) | _points(diagram) | _special(diagram)
    coordinates = (*labels, *LABELS)
    if diagram.regions is not None:
        variables |= region_variables(diagram.regions, diagram.model, diagram.vary)
        coordinates += REGION_LABELS
    title = f"bifurcations of {diagram.model.name} over {' and '.join(diagram.vary)}"
    attributes = {
        "vary": " ".join(diagram.vary),
        "window": np.array(diagram.window, dtype=float).ravel(),
        **result_attributes(SCHEMA, title, diagram.model, _input(diagram), diagram.provenance),
        **checked_attributes(diagram.checked),
    }
    return LabelledTable(variables, coordinates, attributes)


def _input(diagram: LocusDiagram) -> dict[str, Any]:
    return {
        "vary": list(diagram.vary),
        "window": [list(span) for span in diagram.window],
        "settings": asdict(diagram.settings),
        "regions": diagram.regions is not None,
        "interrupted": diagram.interrupted,
    }


def _parameters(diagram: LocusDiagram) -> dict[str, Variable]:
    described = [diagram.model.parameter(name) for name in diagram.vary]
    columns = Columns("parameter")
    columns.add("parameter", texts(item.name for item in described), "name of the parameter")
    units = texts(item.unit for item in described)
    columns.add("parameter_units", units, "unit of the parameter, empty for a number")
    meanings = texts(item.doc for item in described)
    columns.add("parameter_long_name", meanings, "meaning of the parameter")
    return columns.variables


def _loci(diagram: LocusDiagram) -> dict[str, Variable]:
    loci = diagram.loci
    columns = Columns("locus")
    add = columns.add
    add("locus", integers(item.id for item in loci), "number of the locus")
    add("locus_type", texts(item.type for item in loci), "type of bifurcation")
    add("locus_kind", texts(item.kind for item in loci), "what it consists of")
    add("locus_period", integers(item.period for item in loci), "in forcing periods", "")
    add("locus_parent", integers(item.parent or 0 for item in loci), "locus left, 0: none")
    add("node_count", integers(item.nodes.shape[1] for item in loci), "nodes of an orbit", "")
    given = (np.array([item.model.values[name] for name in diagram.vary]) for item in loci)
    about = "values of the parameters in the model that the locus was followed with"
    add("locus_base", stacked(given, (2,)), about, None, "parameter")
    for which, verb in (("begun", "begins"), ("stopped", "ends")):
        ends = [getattr(item, which) for item in loci]
        why = f"why the locus {verb} there"
        add(f"{which}_kind", texts(end.kind for end in ends), f"{why}, in one word")
        add(f"{which}_reason", texts(end.reason for end in ends), why)
        values = stacked((np.array(end.values) for end in ends), (2,))
        add(f"{which}_value", values, f"where the locus {verb}", None, "parameter")
    return columns.variables


def _points(diagram: LocusDiagram) -> dict[str, Variable]:
    loci, n = diagram.loci, len(diagram.model.states)
    ids = [np.full(len(item), item.id, np.int64) for item in loci]
    columns = Columns("point")
    add = columns.add
    add("locus_of_point", joined(ids, kind=np.int64), "locus the point lies on")
    values = joined((item.values for item in loci), (2,))
    add("value", values, _names(diagram), None, "parameter")
    add(
        "states", joined((item.states for item in loci), (n,)), "state at phase zero", None, "state"
    )
    nodes = padded((item.nodes for item in loci), (_most_nodes(diagram), n))
    about = "states at equal phases over the period, the first node_count of the locus"
    add("nodes", nodes, about, None, "node", "state")
    multipliers = joined((item.multipliers for item in loci), (n,), complex)
    add("multipliers", multipliers, "Floquet multipliers", "", "multiplier")
    coefficient = joined(item.coefficient for item in loci)
    add("coefficient", coefficient, "of the normal form of the bifurcation, NaN: not defined")
    words = texts(word or "" for item in loci for word in criticalities(item))
    add("criticality", words, "empty: no meaning, or not known")
    if not diagram.model.forced:
        durations = joined(_durations(item) for item in loci)
        about = "of one round; of an equilibrium, what multipliers are over"
        add("duration", durations, about, "s")
        eigenvalues = joined((_eigenvalues(item) for item in loci), (n,), complex)
        add("eigenvalues", eigenvalues, "of equilibria; NaN: a cycle", "1/s", "multiplier")
    residual = joined(item.residual for item in loci)
    add("residual", residual, "how far the orbit fails to close, in scaled states", "")
    add("arclength", joined(item.arclength for item in loci), "in scaled variables", "")
    return columns.variables


def _durations(locus: Locus) -> NDArray[np.float64]:
    if locus.durations is not None:
        return locus.durations
    return np.full(len(locus), locus.model.values["duration"])


def _eigenvalues(locus: Locus) -> NDArray[np.complex128]:
    found = locus.eigenvalues
    return np.full(locus.multipliers.shape, np.nan + 0j) if found is None else found


def _special(diagram: LocusDiagram) -> dict[str, Variable]:
    points, n = [item.point for item in diagram.special], len(diagram.model.states)
    columns = Columns("special")
    add = columns.add
    owners = integers(locus.id for locus, _ in diagram.special)
    add("locus_of_special", owners, "locus it lies on")
    add("special_type", texts(p.type for p in points), "type of special point")
    add("special_name", texts(p.name for p in points), "what the type means")
    add("special_kind", texts(p.kind for p in points), "what it is a point of")
    values = stacked((np.array(p.values) for p in points), (2,))
    add("special_value", values, _names(diagram), None, "parameter")
    uncertainty = stacked((np.array(p.uncertainty) for p in points), (2,))
    about = "computed uncertainty of special_value"
    add("special_uncertainty", uncertainty, about, None, "parameter")
    add("special_period", integers(p.period for p in points), "in forcing periods", "")
    if not diagram.model.forced:
        durations = reals(p.model.values["duration"] for p in points)
        about = "of one round; of an equilibrium, what multipliers are over"
        add("special_duration", durations, about, "s")
    add("special_node_count", integers(len(p.nodes) for p in points), "nodes of the orbit", "")
    nodes = padded((p.nodes[None] for p in points), (_most_nodes(diagram), n))
    about = "states at equal phases over the period, the first special_node_count"
    add("special_nodes", nodes, about, None, "node", "state")
    multipliers = stacked((p.multipliers for p in points), (n,), complex)
    add("special_multipliers", multipliers, "Floquet multipliers", "", "multiplier")
    residual = reals(p.residual for p in points)
    add("special_residual", residual, "how far the orbit fails to close, in scaled states", "")
    add("special_arclength", reals(p.arclength for p in points), "position on the locus", "")
    started = padded_integers(p.leads_to for p in points)
    add("special_leads_to", started, "loci begun here, 0: no more", None, "start")
    return columns.variables | _normal_forms(diagram)


def _normal_forms(diagram: LocusDiagram) -> dict[str, Variable]:
    """Coefficients of all special points: as many as a point has, one after the other."""
    rows = [
        (number, name, value)
        for number, (_, point) in enumerate(diagram.special)
        for name, value in point.coefficients.items()
    ]
    columns = Columns("normal_form")
    owners = integers(number for number, _, _ in rows)
    columns.add("special_of_normal_form", owners, "row of the special point, from 0")
    columns.add("normal_form_name", texts(name for _, name, _ in rows), "name of the coefficient")
    columns.add("normal_form_value", reals(value for _, _, value in rows), "the coefficient")
    return columns.variables


def _names(diagram: LocusDiagram) -> str:
    return "; ".join(named_parameter(diagram.model.parameter(name)) for name in diagram.vary)


def _most_nodes(diagram: LocusDiagram) -> int:
    counts = [locus.nodes.shape[1] for locus in diagram.loci]
    return max([*counts, *(len(point.nodes) for _, point in diagram.special)], default=0)
