"""One orbit as a file and a spreadsheet: the schema slipfold.orbit/1 of netCDF files."""

from __future__ import annotations

from dataclasses import dataclass, fields
from operator import itemgetter
from typing import Annotated, Any

from slipfold.models.model import Model
from slipfold.orbits.periodic_orbit import PeriodicOrbit, StickSlipOrbit
from slipfold.results.fields import Column, Entry, Items, Nested
from slipfold.results.records import Provenance, SavedTable
from slipfold.results.result import Result
from slipfold.results.tables import Variable

PARTS = {
    "nodes": Entry("node state", "states that the orbit is computed from"),
    "multipliers": Entry("multiplier", "Floquet multipliers", ""),
}


class Orbit(Nested):
    """An orbit as an attribute: its samples over one period, its nodes and its multipliers."""

    def names(self, key: str) -> set[str]:
        """Return the names of the arrays and dimensions."""
        return {"time", *super().names(key)}

    def variables(self, result: Any, key: str) -> dict[str, Variable]:
        """Return time, states and outputs over one period, the nodes and the multipliers."""
        orbit = getattr(result, key)
        items = [*result.model.states, *result.model.outputs()]
        columns = [
            Column(item.name, meaning=item.doc or item.name, unit=item.unit, get=itemgetter(place))
            for place, item in enumerate(items)
        ]
        time = Column("time", meaning="time", unit="s", get=itemgetter(-1), label=True)
        seconds, values = orbit.outputs(256 * orbit.period)
        samples = Items("time", (*columns, time), joined=True)
        return samples.arrays([[*values.T, seconds]], {}) | super().variables(result, key)

    def attributes(self, result: Any, key: str) -> dict[str, Any]:
        """Return the period and the parameters."""
        values = {f"parameter_{name}": value for name, value in result.model.values.items()}
        return {"period": getattr(result, key).period, **values}

    def read(self, saved: SavedTable, result: Any, key: str) -> PeriodicOrbit:
        """Return the orbit."""
        orbit: PeriodicOrbit = super().read(saved, result, key)
        if not len(orbit.nodes):
            raise ValueError("there are no nodes")
        if saved.given.get("through_stick"):
            orbit = StickSlipOrbit(
                **{item.name: getattr(orbit, item.name) for item in fields(orbit)}
            )
        return orbit


ORBIT = Orbit(PeriodicOrbit, PARTS, "The orbit.", {
    "model": lambda saved, _: saved.model,
    "period": lambda saved, _: int(saved.given["period"]),
    "residual": lambda saved, _: float(saved.given["residual"]),
})  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class SavedOrbit(Result):
    """A periodic orbit, sampled over one period."""

    schema = "slipfold.orbit/1"
    title = "periodic orbit of {0.model.name}"
    rows = "time"

    model: Model
    orbit: Annotated[PeriodicOrbit, ORBIT]
    provenance: Provenance

    @property
    def _loaded(self) -> PeriodicOrbit:
        """What `slipfold.load` returns: the orbit itself."""
        return self.orbit

    def _given(self) -> dict[str, Any]:
        sticks = isinstance(self.orbit, StickSlipOrbit)
        given = {"period": self.orbit.period, "residual": self.orbit.residual}
        return {**given, "through_stick": sticks}
