"""Tables as comma-separated values."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.results.column import COMPLEX, Axes, Column
from slipfold.results.table import Table

__all__ = ["Sheet", "csv_text"]


@dataclass(frozen=True)
class Sheet:
    """The columns of a spreadsheet, filled from tables whose rows may alternate."""

    heads: Mapping[str, str]
    """Of each slot, in their order; of one with many columns what their heads begin with."""
    tables: tuple[Table, ...]
    axes: Axes

    def rows(self, table: Table, items: Sequence[Any], known: Mapping[str, Any]) -> list[list[Any]]:
        """Return the lines of the items of a table; `known` is what it does not say of them."""
        if not items:
            return []
        columns = _slots(table)
        found = {
            slot: _cells(columns[slot], columns[slot].values(items, self.axes, table.own), table)
            for slot in self.heads
            if slot in columns
        }
        count = len(next(iter(found.values())))
        for slot, value in known.items():
            found[slot] = [[each] for each in ([value] * count if np.isscalar(value) else value)]
        blank = {slot: [[""] * len(heads)] * count for slot, heads in self._heads().items()}
        parts = [found.get(slot, blank[slot]) for slot in self.heads]
        return [[cell for part in line for cell in part] for line in zip(*parts, strict=True)]

    def text(self, rows: Iterable[Sequence[Any]]) -> str:
        """Return heads and lines as text."""
        return csv_text([head for heads in self._heads().values() for head in heads], rows)

    def _heads(self) -> dict[str, list[str]]:
        """Return the heads of each slot."""
        columns = {slot: each for table in self.tables for slot, each in _slots(table).items()}
        return {
            slot: _heads(columns[slot], head, self.axes) if slot in columns else [head]
            for slot, head in self.heads.items()
        }


def _slots(table: Table) -> dict[str, Column]:
    return {each.key if each.slot is None else each.slot: each for each in table.columns}


def _heads(column: Column, head: str, axes: Axes) -> list[str]:
    if not column.dimensions:
        return [head]
    found = [f"{head} {name}".strip() for name in axes[column.dimensions[-1]]]
    parts = (" real", " imaginary") if column.kind is COMPLEX else ("",)
    return [name + part for name in found for part in parts]


def _cells(column: Column, values: NDArray[Any], table: Table) -> list[list[Any]]:
    """Return the cells of each row; complex numbers are two, truth is 0 or 1."""
    if column.kind is COMPLEX:
        values = np.stack([values.real, values.imag], axis=-1)
    rows = math.prod(values.shape[: len(table.dimensions)])
    cells = values.reshape(rows, -1)
    if values.dtype == bool:
        cells = cells.astype(int)
    lines: list[list[Any]] = cells.tolist()
    if column.optional:
        lines = [["" if cell != cell else cell for cell in line] for line in lines]
    return lines


def csv_text(heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    r"""Return a line of column names and one line a row; numbers are exact when read back.

    >>> csv_text(["a", "b"], [[1, 0.5]])
    'a,b\n1,0.5\n'
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(heads)
    writer.writerows(rows)
    return text.getvalue()
