"""A measured response: readings over a parameter."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.measured.quantity import Quantity
from slipfold.read_only import ReadOnly
from slipfold.text.one_line import OneLine, number_text
from slipfold.text.printed_table import PrintedTable

SWEEPS = ("up", "down", "")
"""How the parameter came to a value; the last: not said."""


@dataclass(frozen=True, eq=False, repr=False)
class Measurement(OneLine, ReadOnly):
    """A measured response, a row a reading; frozen, in SI units.

    Made by `slipfold.read_measurement` and `slipfold.measure`.

    Parameters
    ----------
    vary
        Name of the parameter over which it was measured.
    unit
        Its unit.
    values
        Its values, shape (m,).
    quantities
        What was measured, q of them.
    readings
        What was read, shape (m, q); NaN where nothing was.
    errors
        Standard deviations of the readings, shape (m, q); NaN where they are not known.
    sweep
        ``"up"``, ``"down"`` or ``""`` for each row: how the parameter came to its value.
    stopped
        Why `slipfold.measure` took no more readings: where the motion ended at a limit; None if
        it did not.

    Examples
    --------
    >>> import slipfold as sf
    >>> seen = sf.measure(sf.SlidingOscillator(f=12.5), "Nd", [0.01, 0.02], ["max y"])
    >>> seen.readings.round(5).tolist()
    [[0.10727], [0.15321]]
    """

    vary: str
    unit: str
    values: Array
    quantities: tuple[Quantity, ...]
    readings: Array
    errors: Array
    sweep: tuple[str, ...]
    stopped: str | None = None

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.values)

    def of(self, measure: str, output: str) -> tuple[Array, Array]:
        """Return readings of one quantity and their standard deviations, each of shape (m,).

        Parameters
        ----------
        measure, output
            What was measured, e.g. ``"max"`` of ``"y"``.

        Raises
        ------
        InputError
            If that was not measured.
        """
        for column, item in enumerate(self.quantities):
            if (item.measure, item.output) == (measure, output):
                return self.readings[:, column], self.errors[:, column]
        known = ", ".join(map(str, self.quantities))
        raise InputError(f"{measure} {output} was not measured, but {known}; draw one of these")

    def some(self, rows: Any) -> Measurement:
        """Return some of the rows.

        Parameters
        ----------
        rows
            Their numbers from 0, a slice, or truth values.
        """
        return replace(
            self,
            values=self.values[rows].copy(),
            readings=self.readings[rows].copy(),
            errors=self.errors[rows].copy(),
            sweep=tuple(np.array(self.sweep, dtype=object)[rows]),
        )

    def _line(self) -> str:
        ends = f"{number_text(self.values.min())} to {number_text(self.values.max())} {self.unit}"
        what = ", ".join(map(str, self.quantities))
        line = f"Measurement of {what} at {len(self)} values, {self.vary} from {ends.strip()}"
        return line if self.stopped is None else f"{line}, stopped early"

    def _rows(self) -> PrintedTable:
        heads = [f"{self.vary} ({self.unit or '1'})"]
        heads += [f"{item} ({item.unit or '1'})" for item in self.quantities]
        rows = [
            [number_text(value), *(number_text(each) for each in row), sweep]
            for value, row, sweep in zip(self.values, self.readings, self.sweep, strict=True)
        ]
        return PrintedTable([*heads, "sweep"], rows, ("sweep",))
