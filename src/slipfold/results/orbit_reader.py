"""An orbit made again from its labelled arrays."""

from __future__ import annotations

from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.results.saved_table import SavedTable

__all__ = ["read_orbit"]


def read_orbit(saved: SavedTable) -> PeriodicOrbit:
    """Make an orbit from the arrays that `orbit_table` made of one."""
    nodes = saved.columns["nodes"]
    if nodes.ndim != 2 or nodes.shape[1] != len(saved.model.states) or not len(nodes):
        raise ValueError(f"nodes have the shape {nodes.shape}")
    nodes.setflags(write=False)
    return PeriodicOrbit(
        model=saved.model,
        period=int(saved.given["period"]),
        nodes=nodes,
        multipliers=saved.complex("multipliers", slice(None)),
        residual=float(saved.given["residual"]),
    )
