"""A simulation as labelled arrays: the schema slipfold.simulation/1 of netCDF files."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from slipfold.results.attributes import result_attributes
from slipfold.results.checked_parts import checked_attributes
from slipfold.results.columns import Columns, state_labels
from slipfold.results.labelled_table import LabelledTable

if TYPE_CHECKING:
    from slipfold.results.simulation import Simulation

__all__ = ["SCHEMA", "simulation_table"]

SCHEMA = "slipfold.simulation/1"


def simulation_table(motion: Simulation) -> LabelledTable:
    """Return the strobe states with their names, units and meanings."""
    labels = state_labels(motion.model)
    columns = Columns("strobe")
    forced = motion.model.forced
    counted = "forcing periods" if forced else "intervals of the duration"
    columns.add("strobe", np.arange(len(motion.strobe)), f"{counted} since the start", "")
    columns.add("time", motion.time, "time since the start", "s")
    columns.add(
        "states", motion.strobe, "state at phase zero" if forced else "state", None, "state"
    )
    title = f"simulation of {motion.model.name}"
    attributes = {
        "settlement": json.dumps(asdict(motion.settlement)),
        "stopped": json.dumps(None if motion.stopped is None else asdict(motion.stopped)),
        **result_attributes(SCHEMA, title, motion.model, _input(motion), motion.provenance),
        **checked_attributes(motion.checked),
    }
    return LabelledTable(labels | columns.variables, (*labels, "strobe", "time"), attributes)


def _input(motion: Simulation) -> dict[str, Any]:
    return {
        "periods": motion.asked,
        "state": motion.strobe[0].tolist(),
        "tolerance": motion.tolerance,
    }
