"""What every result offers, whatever was computed: printing, saving, exporting."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from slipfold.checks.checked import Checked
from slipfold.models.model import Model
from slipfold.results.column import plain
from slipfold.results.labelled_table import LabelledTable, Variable
from slipfold.results.model_record import scales_record, structure_record
from slipfold.results.provenance import Provenance
from slipfold.results.writing import write_file

if TYPE_CHECKING:
    import xarray

__all__ = ["Result", "described"]


class Result(ABC):
    """A result; each kind says what it consists of and how it reads, the rest follows."""

    schema: ClassVar[str]
    model: Model
    provenance: Provenance
    checked: Checked | None = None

    @abstractmethod
    def summary(self) -> str:
        """Return the result as lines of text."""

    @abstractmethod
    def _title(self) -> str:
        """Return what it is, in a few words."""

    @abstractmethod
    def _given(self) -> dict[str, Any]:
        """Return the input besides the model, as plain data."""

    @abstractmethod
    def _attributes(self) -> dict[str, Any]:
        """Return the attributes of a dataset that only this kind of result has."""

    @abstractmethod
    def _variables(self) -> Mapping[str, Variable]:
        """Return all numbers with their names, units and meanings."""

    @abstractmethod
    def _record(self) -> dict[str, Any]:
        """Return what records hold besides the model."""

    @abstractmethod
    def _csv(self) -> str:
        """Return the rows of a spreadsheet."""

    def to_json(self) -> dict[str, Any]:
        """Return the result as plain data for `json`; the notes of the class name the schema.

        What is not finite is None.
        """
        parameters = {name: float(value) for name, value in self.model.values.items()}
        head = {"schema": self.schema, "model": self.model.name, "parameters": parameters}
        checked = {} if self.checked is None else {"checked": self.checked.to_json()}
        return {**plain(head | scales_record(self.model) | self._record()), **checked}

    def to_xarray(self) -> xarray.Dataset:
        """Return all numbers as one labelled dataset; the notes of the class say along what.

        Returns
        -------
        xarray.Dataset
            Complex numbers are two variables, ``..._real`` and ``..._imag``; units and meanings are
            in the attributes, as is the full input.
        """
        return self._table().to_xarray()

    def save(self, path: str | Path) -> None:
        """Write everything to a netCDF-4 file; `slipfold.load` reads it back.

        Parameters
        ----------
        path
            The file, by custom ``....nc``. It is written whole or not at all.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        write_file(path, self._table().write_netcdf)

    def to_csv(self, path: str | Path) -> None:
        """Write a spreadsheet; the notes of the class say what is a row.

        Parameters
        ----------
        path
            The file. It is written whole or not at all.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        write_file(path, self._csv().encode())

    def _remarks(self) -> list[str]:
        """Return what the summary says last."""
        return [] if self.checked is None else [str(self.checked)]

    def _table(self) -> LabelledTable:
        """Return everything as labelled arrays."""
        checked = {} if self.checked is None else {"checked": json.dumps(self.checked.to_json())}
        common = described(self.schema, self._title(), self.model, self._given(), self.provenance)
        return LabelledTable(self._variables(), {**self._attributes(), **common, **checked})


def described(
    schema: str, title: str, model: Model, given: Mapping[str, Any], origin: Provenance
) -> dict[str, Any]:
    """Return the attributes that all saved results have: what it is, its input, its origin."""
    whole = {"model": model.name, "parameters": dict(model.values), **scales_record(model)}
    structure = structure_record(model)
    if structure:
        whole["structure"] = structure
    text = json.dumps({**whole, **given})
    head = {"schema": schema, "title": title, "model": model.name, "input": text}
    return {**head, **origin.attributes()}
