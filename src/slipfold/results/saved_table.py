"""A saved result on its way back: its arrays, with the model and the input behind them."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.checks.checked import Checked
from slipfold.models.model import Model
from slipfold.results.labelled_table import LabelledTable
from slipfold.results.model_record import measured_as, model_from_record
from slipfold.results.provenance import Provenance


@dataclass(frozen=True, eq=False)
class SavedTable:
    """What was read from a file, before it is made into a result."""

    table: LabelledTable
    given: Mapping[str, Any]
    """The input of the computation."""
    model: Model

    @cached_property
    def columns(self) -> dict[str, NDArray[Any]]:
        """The arrays by name."""
        return {name: item.values for name, item in self.table.real()}

    @property
    def attributes(self) -> Mapping[str, Any]:
        """Attributes of the file."""
        return self.table.attributes

    @property
    def provenance(self) -> Provenance:
        """Where the result comes from."""
        return Provenance.from_attributes(self.attributes)

    @property
    def checked(self) -> Checked | None:
        """What was computed again; files of earlier versions lack it."""
        text = self.attributes.get("checked")
        return None if text is None else Checked.from_json(json.loads(str(text)))

    def rows(self, dimension: str, owner: str) -> Mapping[int, NDArray[np.int64]]:
        """Return which rows along a dimension belong to what; some have none."""
        owners = self.columns[owner]
        for name, item in self.table.variables.items():
            if item.dimensions[0] == dimension and len(item.values) != len(owners):
                raise ValueError(f"{name} has {len(item.values)} rows, not {len(owners)}")
        found = {int(key): np.flatnonzero(owners == key) for key in np.unique(owners)}
        return defaultdict(lambda: np.empty(0, np.int64), found)

    def complex(self, name: str) -> NDArray[np.complex128]:
        """Return a column of complex numbers."""
        real, imag = self.columns[f"{name}_real"], self.columns[f"{name}_imag"]
        values = np.empty(real.shape, complex)
        values.real, values.imag = real, imag  # exact, also where a part is not finite
        return values


def open_table(table: LabelledTable, kind: type[Model] | None = None) -> SavedTable:
    """Find out what a table was computed with."""
    given = json.loads(table.attributes["input"])
    parameters = given["parameters"]
    model = model_from_record(str(given["model"]), given.get("structure", {}), parameters, kind)
    return SavedTable(table, given, measured_as(model, given))
