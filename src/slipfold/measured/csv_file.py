"""Measurements as comma-separated values with units in the head."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from slipfold.errors import InputError
from slipfold.measured.measurement import SWEEPS, Measurement
from slipfold.measured.quantity import Quantity, parse_measured
from slipfold.models.model import Model
from slipfold.models.quantity import units_of

_HEAD = re.compile(r"\s*(?P<name>[^\[\](){}]+?)\s*(?:[\[(]\s*(?P<unit>[^\])]*?)\s*[\])])?\s*")

ERROR = "error of "
SWEEP = "sweep"


def read_measurement(path: str | Path, model: Model) -> Measurement:
    """Read a measured response from a file of comma-separated values.

    The head names a parameter of the model and what was measured, each with its unit: ``Nd [N]``,
    ``max y [mm]``, ``peak_to_peak x [m]``. A column ``error of max y [mm]`` holds standard
    deviations of readings, a column ``sweep`` the words up or down. Lines that begin with # are
    skipped; an empty cell is a reading that is missing.

    Parameters
    ----------
    path
        The file.
    model
        The model whose parameter and outputs it names.

    Returns
    -------
    Measurement
        The readings in SI units.

    Raises
    ------
    InputError
        If the file cannot be read, or says something that the model does not know.
    """
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is no text"
        raise InputError(f"{path} cannot be read: {reason}; give a file of text") from error
    return parse_measurement(text, path, model)


def parse_measurement(text: str, path: str | Path, model: Model) -> Measurement:
    """Read the text of a file; its path is what sentences call it."""
    try:
        rows = list(enumerate(csv.reader(io.StringIO(text, newline=None)), 1))
    except csv.Error as error:
        raise InputError(f"{path} cannot be read: {error}; give lines of short cells") from error
    lines = [
        (number, cells)
        for number, cells in rows
        if any(cell.strip() for cell in cells) and not cells[0].lstrip().startswith("#")
    ]
    if len(lines) < 2:
        raise InputError(
            f"{path} holds no readings; give a head such as 'Nd [N], max y [mm]' and a "
            "line for each reading"
        )
    columns = [_Column(cell, model, first=k == 0) for k, cell in enumerate(lines[0][1])]
    _check_columns(columns, path)
    return _measurement(columns, lines[1:], path)


class _Column:
    """What a column holds, and how large its unit is."""

    def __init__(self, head: str, model: Model, first: bool) -> None:
        match = _HEAD.fullmatch(head)
        if match is None:
            raise InputError(
                f"the head {head!r} is not a name with a unit; write e.g. 'max y [mm]'"
            )
        self.head, name = head.strip(), match["name"]
        self.is_sweep = name == SWEEP
        self.is_error = name.startswith(ERROR)
        self.quantity: Quantity | None = None
        self.name = name
        if self.is_sweep:
            return
        if first:
            unit = model.variable_parameter(name).unit
        else:
            self.quantity = parse_measured(name.removeprefix(ERROR), model)
            unit = self.quantity.unit
        self.unit, self.factor = unit, self._factor(match["unit"], unit)

    def _factor(self, given: str | None, unit: str) -> float:
        known = units_of(unit)
        if given in (None, "", "-", "1") and not unit:
            return 1.0
        if given not in known:
            said = f"has the unit {given!r}" if given else "has no unit"
            raise InputError(
                f"the head {self.head!r} {said}; write {self.name} [{unit or '1'}]"
                + (f", or one of {', '.join(known)}" if len(known) > 1 else "")
            )
        return known[given]

    def value(self, cell: str, place: str) -> float:
        """Return a cell in the SI unit."""
        if not cell.strip():
            return math.nan
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


def _check_columns(columns: Sequence[_Column], path: str | Path) -> None:
    measured = [item.quantity for item in columns if item.quantity and not item.is_error]
    if not measured:
        raise InputError(
            f"{path} holds no readings beside {columns[0].name}; give a column such as 'max y [mm]'"
        )
    for item in columns:
        same = [other for other in columns if other.name == item.name]
        if len(same) > 1:
            raise InputError(f"{path} has {len(same)} columns {item.name!r}; leave one")
        if item.is_error and item.quantity not in measured:
            raise InputError(
                f"{path} has errors of {item.quantity} but no readings of it; give a column "
                f"'{item.quantity} [{item.unit}]'"
            )


def _measurement(
    columns: Sequence[_Column], lines: Sequence[tuple[int, list[str]]], path: str | Path
) -> Measurement:
    quantities = tuple(item.quantity for item in columns if item.quantity and not item.is_error)
    shape = (len(lines), len(quantities))
    values, readings, errors = np.empty(shape[0]), np.full(shape, np.nan), np.full(shape, np.nan)
    sweep = []
    for row, (number, cells) in enumerate(lines):
        place = f"line {number} of {path}"
        if len(cells) != len(columns):
            raise InputError(
                f"{place} has {len(cells)} cells under {len(columns)} heads; give as many"
            )
        sweep.append("")
        for k, (column, cell) in enumerate(zip(columns, cells, strict=True)):
            if column.is_sweep:
                sweep[-1] = _way(cell, place)
            elif k == 0:
                values[row] = column.value(cell, place)
            else:
                assert column.quantity is not None
                into = errors if column.is_error else readings
                into[row, quantities.index(column.quantity)] = column.value(cell, place)
        if math.isnan(values[row]):
            raise InputError(f"{place} has no value of {columns[0].name}; give one")
    if (errors <= 0).any():
        row = int(np.flatnonzero((errors <= 0).any(axis=1))[0])
        raise InputError(
            f"line {lines[row][0]} of {path} has an error that is not above zero; give a standard "
            "deviation, or leave the cell empty"
        )
    return Measurement(
        columns[0].name, columns[0].unit, values, quantities, readings, errors, tuple(sweep)
    )


def _way(cell: str, place: str) -> str:
    word = cell.strip().lower()
    if word not in SWEEPS:
        raise InputError(
            f"{place}: {cell.strip()!r} is no direction of a sweep; give up, down or nothing"
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
        measurement.values, measurement.readings, measurement.errors, measurement.sweep, strict=True
    ):
        numbers = [value, *row, *errors]
        writer.writerow(["" if math.isnan(each) else repr(float(each)) for each in numbers] + [way])
    return file.getvalue()
