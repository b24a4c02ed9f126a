"""One orbit as a file and a spreadsheet: the schema slipfold.orbit/1 of netCDF files."""

from __future__ import annotations

from dataclasses import dataclass
from operator import itemgetter
from typing import Annotated, Any

from slipfold.models.model import Model
from slipfold.orbits.periodic_orbit import PeriodicOrbit, StickSlipOrbit
from slipfold.results.fields import COMPLEX, Column, ItemTable, ResultPart, axes_of
from slipfold.results.records import Provenance, SavedTable
from slipfold.results.result import Result
from slipfold.results.tables import Variable

NODES = ItemTable(
    ("node",),
    (Column("nodes", meaning="states that the orbit is computed from", dimensions=("state",)),),
    joined=True,
)
MULTIPLIERS = ItemTable(
    ("multiplier",), (Column("multipliers", COMPLEX, "Floquet multipliers", ""),), joined=True
)


@dataclass(frozen=True)
class Orbit(ResultPart):
    """An orbit as an attribute: its samples over one period, its nodes and its multipliers."""

    doc = "The orbit."

    def names(self, key: str) -> set[str]:
        """Return the names of the arrays and dimensions."""
        return {"time", "node", "nodes", "multipliers"}

    def variables(self, result: Any, key: str) -> dict[str, Variable]:
        """Return time, states and outputs over one period, the nodes and the multipliers."""
        orbit, axes = getattr(result, key), axes_of(result.model)
        items = [*result.model.states, *result.model.outputs()]
        columns = [
            Column(item.name, meaning=item.doc or item.name, unit=item.unit, get=itemgetter(place))
            for place, item in enumerate(items)
        ]
        time = Column("time", meaning="time", unit="s", get=itemgetter(-1), label=True)
        seconds, values = orbit._outputs(256 * orbit.period)
        samples = ItemTable(("time",), (*columns, time), joined=True)
        return {
            **samples.variables([[*values.T, seconds]], axes),
            **NODES.variables([orbit], axes),
            **MULTIPLIERS.variables([orbit], axes),
        }

    def attributes(self, result: Any, key: str) -> dict[str, Any]:
        """Return the period and the parameters."""
        values = {f"parameter_{name}": value for name, value in result.model.values.items()}
        return {"period": getattr(result, key).period, **values}

    def read(self, saved: SavedTable, result: Any, key: str) -> PeriodicOrbit:
        """Return the orbit."""
        axes, given = axes_of(saved.model), saved.given
        fields = NODES.read(saved, axes, ...) | MULTIPLIERS.read(saved, axes, ...)
        if not len(fields["nodes"]):
            raise ValueError("there are no nodes")
        fields["nodes"].setflags(write=False)
        kind = StickSlipOrbit if given.get("through_stick") else PeriodicOrbit
        period, residual = int(given["period"]), float(given["residual"])
        return kind(model=saved.model, period=period, residual=residual, **fields)


@dataclass(frozen=True, eq=False, repr=False)
class SavedOrbit(Result):
    """A periodic orbit, sampled over one period."""

    schema = "slipfold.orbit/1"
    title = "periodic orbit of {0.model.name}"
    rows = "time"

    model: Model
    orbit: Annotated[PeriodicOrbit, Orbit()]
    provenance: Provenance

    @property
    def _loaded(self) -> PeriodicOrbit:
        """What `slipfold.load` returns: the orbit itself."""
        return self.orbit

    def _given(self) -> dict[str, Any]:
        sticks = isinstance(self.orbit, StickSlipOrbit)
        given = {"period": self.orbit.period, "residual": self.orbit.residual}
        return {**given, "through_stick": sticks}
