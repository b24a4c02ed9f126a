"""What every result offers, whatever was computed: printing, saving, exporting."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipfold.results.writing import write_file

if TYPE_CHECKING:
    import xarray

    from slipfold.results.labelled_table import LabelledTable

__all__ = ["Result"]


class Result(ABC):
    """A result; what it consists of and how it reads is said by each kind of result."""

    @abstractmethod
    def summary(self) -> str:
        """Return the result as lines of text."""

    @abstractmethod
    def to_json(self) -> dict[str, Any]:
        """Return the result as plain data for `json`."""

    @abstractmethod
    def _table(self) -> LabelledTable:
        """Return everything as labelled arrays."""

    @abstractmethod
    def _csv(self) -> str:
        """Return the rows of a spreadsheet."""

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
        write_file(path, self._table().to_netcdf())

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
