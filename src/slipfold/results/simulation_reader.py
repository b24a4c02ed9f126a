"""A simulation made again from its labelled arrays."""

from __future__ import annotations

import json

from slipfold.flow.guarded_flow import Stop
from slipfold.flow.settlement import Settlement
from slipfold.models.model import Model
from slipfold.results.diagram_reader import read_model, read_provenance
from slipfold.results.labelled_table import LabelledTable
from slipfold.results.simulation import Simulation

__all__ = ["read_simulation"]


def read_simulation(table: LabelledTable, kind: type[Model] | None = None) -> Simulation:
    """Make a simulation from the arrays that `simulation_table` made of one.

    Parameters
    ----------
    table
        The arrays.
    kind
        The class of the model, if it is not a built-in one.

    Raises
    ------
    InputError
        If the model is unknown.
    LookupError, TypeError, ValueError
        If something is missing or does not fit.
    """
    given = json.loads(table.attributes["input"])
    model = read_model(given, kind)
    strobe = table.variables["states"].values
    if strobe.ndim != 2 or strobe.shape[1] != len(model.states) or not len(strobe):
        raise ValueError(f"states have the shape {strobe.shape}")
    strobe.setflags(write=False)
    stopped = json.loads(table.attributes["stopped"])
    return Simulation(
        model=model,
        strobe=strobe,
        settlement=Settlement(**json.loads(table.attributes["settlement"])),
        stopped=None if stopped is None else Stop(**stopped),
        asked=int(given["periods"]),
        tolerance=float(given["tolerance"]),
        provenance=read_provenance(table.attributes),
    )
