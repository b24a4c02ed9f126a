"""One orbit as a file and a spreadsheet: the schema slipfold.orbit/1 of netCDF files."""

from __future__ import annotations

from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from slipfold.models.model import Model
from slipfold.models.output import Output
from slipfold.models.parameter import State
from slipfold.orbits.periodic_orbit import PeriodicOrbit, StickSlipOrbit
from slipfold.results.fields import COMPLEX, Column, Table, axes_of, names
from slipfold.results.records import SavedTable, provenance
from slipfold.results.result import described
from slipfold.results.tables import LabelledTable, frame_of

SCHEMA = "slipfold.orbit/1"

NODES = Table(
    ("node",),
    (Column("nodes", meaning="states that the orbit is computed from", dimensions=("state",)),),
    joined=True,
)
MULTIPLIERS = Table(
    ("multiplier",), (Column("multipliers", COMPLEX, "Floquet multipliers", ""),), joined=True
)


def _motion(model: Model) -> Table:
    """Table of the quantities that are sampled over a period."""
    quantities = tuple(
        Column(item.name, meaning=item.doc or item.name, unit=item.unit, get=itemgetter(item.name))
        for item in _quantities(model)
    )
    time = Column("time", meaning="time", unit="s", get=itemgetter("time"), label=True)
    return Table(("time",), (*quantities, time), joined=True)


def orbit_csv(orbit: PeriodicOrbit) -> str:
    """Return time, states and outputs over one period, one row an instant."""
    return frame_of(_motion(orbit.model).variables([_sampled(orbit)], {}), ["time"]).to_csv()


def orbit_table(orbit: PeriodicOrbit) -> LabelledTable:
    """Return time, states and outputs over one period, the nodes and the multipliers."""
    model, axes = orbit.model, axes_of(orbit.model)
    variables = names("state", model.states)
    variables |= _motion(model).variables([_sampled(orbit)], axes)
    variables |= NODES.variables([orbit], axes) | MULTIPLIERS.variables([orbit], axes)
    given = {
        "period": orbit.period,
        "residual": orbit.residual,
        "through_stick": isinstance(orbit, StickSlipOrbit),
    }
    attributes = {
        **described(SCHEMA, f"periodic orbit of {model.name}", model, given, provenance(0.0)),
        "period": orbit.period,
        **{f"parameter_{name}": value for name, value in model.values.items()},
    }
    return LabelledTable(variables, attributes)


class SavedOrbit:
    """An orbit in a file."""

    @staticmethod
    def _read(saved: SavedTable) -> PeriodicOrbit:
        """Make an orbit from the arrays that `orbit_table` made of one."""
        axes = axes_of(saved.model)
        fields = NODES.read(saved, axes, ...) | MULTIPLIERS.read(saved, axes, ...)
        if not len(fields["nodes"]):
            raise ValueError("there are no nodes")
        fields["nodes"].setflags(write=False)
        kind = StickSlipOrbit if saved.given.get("through_stick") else PeriodicOrbit
        return kind(
            model=saved.model,
            period=int(saved.given["period"]),
            residual=float(saved.given["residual"]),
            **fields,
        )


def _quantities(model: Model) -> list[State | Output]:
    return [*model.states, *model.outputs()]


def _sampled(orbit: PeriodicOrbit) -> dict[str, NDArray[np.float64]]:
    time, values = orbit._outputs(256 * orbit.period)
    quantities = zip(_quantities(orbit.model), values.T, strict=True)
    return {"time": time, **{item.name: column for item, column in quantities}}
