"""One orbit as a spreadsheet and as labelled arrays, the schema slipfold.orbit/1 of netCDF."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.flow import flow_of
from slipfold.models.model import Model
from slipfold.models.output import Output
from slipfold.models.parameter import State
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.results.attributes import result_attributes
from slipfold.results.columns import Columns, state_labels
from slipfold.results.csv_text import csv_text, with_unit
from slipfold.results.labelled_table import LabelledTable
from slipfold.results.provenance import provenance

__all__ = ["SCHEMA", "orbit_csv", "orbit_table"]

SCHEMA = "slipfold.orbit/1"

SAMPLES = 256
"""Samples a forcing period."""


def orbit_csv(orbit: PeriodicOrbit) -> str:
    """Return time, states and outputs over one period, one row an instant."""
    time, values = _sampled(orbit)
    heads = ["time (s)", *(with_unit(item) for item in _quantities(orbit.model))]
    return csv_text(heads, np.column_stack([time, values]).tolist())


def orbit_table(orbit: PeriodicOrbit) -> LabelledTable:
    """Return time, states and outputs over one period, the nodes and the multipliers."""
    model = orbit.model
    time, values = _sampled(orbit)
    motion = Columns("time")
    for item, column in zip(_quantities(model), values.T, strict=True):
        motion.add(item.name, np.ascontiguousarray(column), item.doc or item.name, item.unit)
    motion.add("time", time, "time", "s")
    nodes, multipliers = Columns("node"), Columns("multiplier")
    nodes.add("nodes", orbit.nodes, "states that the orbit is computed from", None, "state")
    multipliers.add("multipliers", orbit.multipliers, "Floquet multipliers", "")
    labels = state_labels(model)
    given = {"period": orbit.period, "residual": orbit.residual}
    attributes = {
        **result_attributes(
            SCHEMA, f"periodic orbit of {model.name}", model, given, provenance(0.0)
        ),
        "period": orbit.period,
        **{f"parameter_{name}": value for name, value in model.values.items()},
    }
    variables = labels | motion.variables | nodes.variables | multipliers.variables
    return LabelledTable(variables, (*labels, "time"), attributes)


def _quantities(model: Model) -> list[State | Output]:
    return [*model.states, *model.outputs()]


def _sampled(orbit: PeriodicOrbit) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    flow = flow_of(orbit.model)
    constants = flow.constants_of(orbit.model)
    time, states = orbit.sample(SAMPLES * orbit.period)
    return time, flow.outputs(states, time / constants.period, constants)
