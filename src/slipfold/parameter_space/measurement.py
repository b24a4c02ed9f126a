"""Measured quantities, and the files that they come in."""

from __future__ import annotations

import csv
import io
import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow.trajectory import MEASURES, Measure
from slipfold.models.levels import quantity_of
from slipfold.models.model import Model
from slipfold.models.units import units_of
from slipfold.orbits.extrema import Extrema
from slipfold.read_only import Documented, ReadOnly
from slipfold.text import OneLine, PrintedTable, number_text
from slipfold.writing import to_read, write_file


@dataclass(frozen=True)
class Quantity(Documented):
    """What is measured of an output over a period of the response."""

    measure: Measure
    output: Annotated[str, "A state or output of the model."]
    unit: Annotated[str, "Its unit."]

    def __str__(self) -> str:
        """Return it as columns are headed, without its unit."""
        return f"{self.measure} {self.output}"


def parse_measured(text: str, model: Model) -> Quantity:
    """Read ``MEASURE OUTPUT``.

    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
    >>> parse_measured("max y", SlidingOscillator())
    Quantity(measure='max', output='y', unit='')
    """
    measure, _, output = (part.strip() for part in text.strip().partition(" "))
    if measure not in MEASURES or not output:
        raise InputError(
            f"{text!r} does not say what is measured; write one of {', '.join(MEASURES)} and an "
            f"output, e.g. 'max {model.states[0].name}'"
        )
    return Quantity(measure, output, quantity_of(model, output).unit)


def read_off(extrema: Extrema, quantities: Sequence[Quantity]) -> Array:
    """Return what is measured of each orbit, shape (n_orbits, n_quantities)."""
    return np.column_stack([extrema.measured(item.measure, item.output) for item in quantities])


SWEEPS = ("up", "down", "")
"""How the parameter reached a value; empty if that is not known."""


@dataclass(frozen=True, eq=False, repr=False)
class Measurement(OneLine, ReadOnly):
    """A measured response, a row a measurement; frozen, in SI units.

    Made by `slipfold.read_measurement` and `slipfold.measure`.
    """

    vary: Annotated[str, "Name of the parameter over which it was measured."]
    unit: Annotated[str, "Its unit."]
    values: Annotated[Array, "Its values, shape (m,)."]
    quantities: Annotated[tuple[Quantity, ...], "What was measured, q of them."]
    measured: Annotated[Array, "What was read, shape (m, q); NaN where nothing was."]
    errors: Annotated[
        Array,
        "Standard deviations of the measurements, shape (m, q); NaN where they are not known.",
    ]
    sweep: Annotated[
        tuple[str, ...],
        '``"up"``, ``"down"`` or ``""`` for each row: how the parameter reached its value.',
    ]
    stopped: Annotated[
        str | None,
        "Why `slipfold.measure` took no more measurements: where the trajectory ended at a "
        "limit; None if it did not.",
    ] = None

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.values)

    def of(self, measure: str, output: str) -> tuple[Array, Array]:
        """Return measurements of one quantity and their standard deviations, each of shape (m,).

        Parameters
        ----------
        measure, output
            What was measured, e.g. ``"max"`` of ``"y"``.
        """
        for column, item in enumerate(self.quantities):
            if (item.measure, item.output) == (measure, output):
                return self.measured[:, column], self.errors[:, column]
        known = ", ".join(map(str, self.quantities))
        raise InputError(f"{measure} {output} was not measured, but {known}; draw one of these")

    def select(self, rows: Any) -> Measurement:
        """Return some of the rows.

        Parameters
        ----------
        rows
            Their numbers from 0, a slice, or truth values.
        """
        return replace(
            self,
            values=self.values[rows].copy(),
            measured=self.measured[rows].copy(),
            errors=self.errors[rows].copy(),
            sweep=tuple(np.array(self.sweep, dtype=object)[rows]),
        )

    def to_csv(self, path: str | Path) -> None:
        """Write it as `slipfold.read_measurement` reads it.

        Parameters
        ----------
        path
            The file.
        """
        write_file(path, csv_of(self).encode())

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
            for value, row, sweep in zip(self.values, self.measured, self.sweep, strict=True)
        ]
        return PrintedTable([*heads, "sweep"], rows, ("sweep",))


_HEAD = re.compile(r"\s*(?P<name>[^\[\](){}]+?)\s*(?:[\[(]\s*(?P<unit>[^\])]*?)\s*[\])])?\s*")

ERROR = "error of "
SWEEP = "sweep"


def read_measurement(path: str | Path, model: Model) -> Measurement:
    """Read a measured response from a file of comma-separated values.

    The head names a parameter of the model and what was measured, each with its unit: ``Nd [N]``,
    ``max y [mm]``, ``peak_to_peak x [m]``. A column ``error of max y [mm]`` holds standard
    deviations of measurements, a column ``sweep`` the words up or down. Lines that begin with # are
    skipped; an empty cell is a measurement that is missing. Results are in SI units.

    Parameters
    ----------
    path
        The file.
    model
        The model whose parameter and outputs it names.
    """
    try:
        text = to_read(path).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is no text"
        raise InputError(f"{path} cannot be read: {reason}; give a file of text") from error
    return parse_measurement(text, path, model)


def parse_measurement(text: str, path: str | Path, model: Model) -> Measurement:
    """Read the text of a file; its path is what sentences call it.

    Cells may also be separated by semicolons or tabs; then a comma is a decimal point.
    """
    heads = (line for line in text.splitlines() if line.strip() and line.lstrip()[0] != "#")
    head = next(heads, "")
    separator = next((mark for mark in ";\t" if mark in head), ",")
    try:
        lines_read = csv.reader(io.StringIO(text, newline=None), delimiter=separator)
        rows = list(enumerate(lines_read, 1))
    except csv.Error as error:
        raise InputError(f"{path} cannot be read: {error}; give lines of short cells") from error
    lines = [
        (f"line {number} of {path}", cells)
        for number, cells in rows
        if any(cell.strip() for cell in cells) and not cells[0].lstrip().startswith("#")
    ]
    if len(lines) < 2:
        raise InputError(
            f"{path} holds no measurements; give a head such as 'Nd [N], max y [mm]' and a "
            "line for each measurement"
        )
    columns = [_Column.from_head(cell, model, k == 0) for k, cell in enumerate(lines[0][1])]
    _check_columns(columns, path)
    table, sweep = np.full((len(lines) - 1, len(columns)), np.nan), []
    for row, (place, cells) in enumerate(lines[1:]):
        if len(cells) != len(columns):
            raise InputError(
                f"{place} has {len(cells)} cells under {len(columns)} heads; give as many"
            )
        sweep.append("")
        for k, (column, cell) in enumerate(zip(columns, cells, strict=True)):
            if column.name == SWEEP:
                sweep[-1] = _direction(cell, place)
            elif cell.strip():
                decimal = cell if separator == "," else cell.replace(",", ".")
                table[row, k] = column.value(decimal, place)
        if math.isnan(table[row, 0]):
            raise InputError(f"{place} has no value of {columns[0].name}; give one")
        if any(column.is_error and table[row, k] <= 0 for k, column in enumerate(columns)):
            raise InputError(
                f"{place} has an error that is not above zero; give a standard deviation, or leave "
                "the cell empty"
            )
    by_name = {column.name: table[:, k] for k, column in enumerate(columns)}
    missing, quantities = np.full(len(table), np.nan), _measured(columns)
    errors = [by_name.get(f"{ERROR}{item}", missing) for item in quantities]
    return Measurement(
        columns[0].name,
        columns[0].unit,
        table[:, 0],
        quantities,
        np.column_stack([by_name[str(item)] for item in quantities]),
        np.column_stack(errors),
        tuple(sweep),
    )


@dataclass(frozen=True)
class _Column:
    """What a column of a file holds."""

    head: str
    name: str
    quantity: Quantity | None = None  # None of the parameter and of the direction of the sweep
    unit: str = ""
    factor: float = 1.0  # its unit in the file over the SI unit

    @classmethod
    def from_head(cls, head: str, model: Model, first: bool) -> _Column:
        """Read the head of a column; the first one is that of the parameter."""
        match = _HEAD.fullmatch(head)
        if match is None:
            raise InputError(
                f"the head {head!r} is not a name with a unit; write e.g. 'max y [mm]'"
            )
        head, name, given = head.strip(), " ".join(match["name"].split()), match["unit"]
        if name == SWEEP:
            return cls(head, name)
        quantity = None if first else parse_measured(name.removeprefix(ERROR), model)
        unit = model.variable_parameter(name).unit if quantity is None else quantity.unit
        known = units_of(unit)
        if given in (None, "", "-", "1") and not unit:
            return cls(head, name, quantity, unit)
        if given not in known:
            said = f"has the unit {given!r}" if given else "has no unit"
            raise InputError(
                f"the head {head!r} {said}; write {name} [{unit or '1'}]"
                + (f", or one of {', '.join(known)}" if len(known) > 1 else "")
            )
        return cls(head, name, quantity, unit, known[given])

    @property
    def is_error(self) -> bool:
        """Whether it holds standard deviations."""
        return self.name.startswith(ERROR)

    def value(self, cell: str, place: str) -> float:
        """Return the number in a cell, in the SI unit."""
        try:
            value = float(cell) * self.factor
        except ValueError:
            value = math.inf
        if not math.isfinite(value):
            raise InputError(
                f"{place}: {cell.strip()!r} under {self.head!r} is not a finite number; give one, "
                "or leave the cell empty"
            )
        return value


def _measured(columns: Sequence[_Column]) -> tuple[Quantity, ...]:
    return tuple(item.quantity for item in columns if item.quantity and not item.is_error)


def _check_columns(columns: Sequence[_Column], path: str | Path) -> None:
    measured = _measured(columns)
    if not measured:
        raise InputError(
            f"{path} holds no measurements besides {columns[0].name}; give a column such as "
            "'max y [mm]'"
        )
    for name, count in Counter(item.name for item in columns).items():
        if count > 1:
            raise InputError(f"{path} has {count} columns {name!r}; leave one")
    for item in columns:
        if item.is_error and item.quantity not in measured:
            raise InputError(
                f"{path} has errors of {item.quantity} but no measurements of it; give a column "
                f"'{item.quantity} [{item.unit or '1'}]'"
            )


def _direction(cell: str, place: str) -> str:
    word = cell.strip().lower()
    if word not in SWEEPS:
        raise InputError(
            f"{place}: {cell.strip()!r} is not a direction of a sweep; give up, down or nothing"
        )
    return word


def csv_of(measurement: Measurement, remarks: Sequence[str] = ()) -> str:
    """Return a measurement as `read_measurement` reads it, remarks first.

    >>> import slipfold as sf
    >>> seen = sf.measure(sf.SlidingOscillator(f=12.5), "Nd", [0.02], ["max y"])
    >>> print(csv_of(seen).splitlines()[0])
    Nd [N],max y [1],error of max y [1],sweep
    """
    heads = [f"{measurement.vary} [{measurement.unit or '1'}]"]
    heads += [f"{item} [{item.unit or '1'}]" for item in measurement.quantities]
    heads += [f"{ERROR}{item} [{item.unit or '1'}]" for item in measurement.quantities]
    file = io.StringIO()
    for remark in remarks:
        file.write(f"# {remark}\n")
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow([*heads, SWEEP])
    for value, row, errors, way in zip(
        measurement.values, measurement.measured, measurement.errors, measurement.sweep, strict=True
    ):
        numbers = [value, *row, *errors]
        writer.writerow(["" if math.isnan(each) else repr(float(each)) for each in numbers] + [way])
    return file.getvalue()
