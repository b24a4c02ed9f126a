"""A simulation made again from its labelled arrays."""

from __future__ import annotations

import json

from slipfold.flow.guarded_flow import Stop
from slipfold.flow.settlement import Settlement
from slipfold.results.checked_parts import read_checked
from slipfold.results.saved_table import SavedTable
from slipfold.results.simulation import Simulation

__all__ = ["read_simulation"]


def read_simulation(saved: SavedTable) -> Simulation:
    """Make a simulation from the arrays that `simulation_table` made of one."""
    strobe = saved.columns["states"]
    if strobe.ndim != 2 or strobe.shape[1] != len(saved.model.states) or not len(strobe):
        raise ValueError(f"states have the shape {strobe.shape}")
    strobe.setflags(write=False)
    stopped = json.loads(saved.attributes["stopped"])
    return Simulation(
        model=saved.model,
        strobe=strobe,
        settlement=Settlement(**json.loads(saved.attributes["settlement"])),
        stopped=None if stopped is None else Stop(**stopped),
        asked=int(saved.given["periods"]),
        tolerance=float(saved.given["tolerance"]),
        provenance=saved.provenance,
        checked=read_checked(saved.attributes),
    )
