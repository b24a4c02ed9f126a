"""A planned measurement as a result: what its readings would tell, and which of them most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.drawing import draw
from slipfold.errors import InputError
from slipfold.measured.information import Planned, best_rows, expected
from slipfold.measured.quantity import Quantity, headed_quantities, parse_measured
from slipfold.models.model import Model
from slipfold.results.column import REAL, TEXT, Column
from slipfold.results.labelled_table import Variable
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.results.saved_table import SavedTable
from slipfold.results.sheet import Sheet
from slipfold.results.table import Table
from slipfold.text.one_line import OneLine, headed, listed
from slipfold.text.printed_table import PrintedTable

__all__ = ["MeasurementPlan"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Row:
    """A planned reading."""

    value: float
    read: Array
    slopes: Array


def _rows_table(vary: str, unit: str) -> Table:
    return Table(
        ("row",),
        (
            Column("value", REAL, f"value of {vary}", unit, label=True),
            Column("read", REAL, "what would be read, in quantity_units", None, ("quantity",)),
            Column("slopes", REAL, "its derivative with respect to each parameter, in "
                   "quantity_units over fitted_units", None, ("quantity", "fitted")),
        ),
    )  # fmt: skip


_QUANTITIES = Table(
    ("quantity",),
    (
        Column("text", TEXT, "what would be measured of which output", name="quantity", label=True,
               get=lambda item: str(item[0])),
        Column("unit", TEXT, "its unit, empty for a number", name="quantity_units", label=True,
               get=lambda item: item[0].unit),
        Column("error", REAL, "standard deviation of its readings, in quantity_units",
               name="quantity_error", get=lambda item: item[1]),
    ),
)  # fmt: skip

_FITTED = Table(
    ("fitted",),
    (
        Column("name", TEXT, "name of the parameter", name="fitted", label=True,
               get=lambda item: item[0].name),
        Column("unit", TEXT, "its unit, empty for a number", name="fitted_units", label=True,
               get=lambda item: item[0].unit),
        Column("error", REAL, "expected standard error, in fitted_units", name="fitted_error",
               get=lambda item: item[1]),
        Column("correlation", REAL, "expected, with each of the other parameters", "", ("other",),
               name="fitted_correlation", get=lambda item: item[2]),
    ),
)  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class MeasurementPlan(OneLine, Result):
    """What planned readings would tell of parameters; frozen.

    Made by `slipfold.plan_measurement` and `slipfold.load`.

    Parameters
    ----------
    model
        The model with the values that are expected.
    vary
        Name of the parameter that would be swept.
    quantities
        What would be measured, q of them.
    fitted
        Names of the parameters to be told, p of them.
    values
        Values of `vary`, shape (m,), in the order of the sweep.
    read
        What would be read, shape (m, q); NaN where no response is stable.
    slopes
        Derivatives of readings with respect to the parameters, shape (m, q, p), in the units of
        the quantities over those of the parameters.
    errors
        Standard deviations of the readings, shape (q,).
    provenance
        Versions and time.

    Notes
    -----
    In the dataset of `to_xarray`, along ``row`` the readings, also along ``quantity`` and
    ``fitted``. In the spreadsheet of `to_csv` a row is a value of `vary`. In `to_json`, schema
    slipfold.measurement-plan/1.

    Examples
    --------
    >>> import slipfold as sf
    >>> forces = [0.005 * step for step in range(1, 9)]
    >>> planned = sf.plan_measurement(
    ...     sf.SlidingOscillator(f=12.5), "Nd", forces, ["max y"], ["mu"], errors=1e-4
    ... )
    >>> planned.best(2)
    [6, 7]
    """

    schema = "slipfold.measurement-plan/1"

    model: Model
    vary: str
    quantities: tuple[Quantity, ...]
    fitted: tuple[str, ...]
    values: Array
    read: Array
    slopes: Array
    errors: Array
    provenance: Provenance

    @property
    def covariance(self) -> Array:
        """Expected covariance of the parameters, shape (p, p); infinite where nothing tells."""
        return expected(self._planned, self.errors, slice(None))

    @property
    def errors_expected(self) -> Array:
        """Expected standard errors of the parameters, in their units, shape (p,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def correlation(self) -> Array:
        """Expected correlations of the parameters, shape (p, p)."""
        errors = self.errors_expected
        with np.errstate(invalid="ignore"):
            found = self.covariance / np.outer(errors, errors)
        np.fill_diagonal(found, 1.0)
        return np.asarray(found)

    def best(self, count: int) -> list[int]:
        """Return the numbers of the rows that tell all parameters best together.

        Parameters
        ----------
        count
            How many.

        Returns
        -------
        list of int
            Their numbers from 0: those with the largest determinant of the information matrix (a
            D-optimal design), found by taking one after the other and then exchanging.

        Raises
        ------
        InputError
            If there are not as many, or too few to tell the parameters.
        """
        there = int(np.isfinite(self.slopes).all(axis=(1, 2)).sum())
        least = -(-len(self.fitted) // len(self.quantities))
        if not least <= count <= there:
            raise InputError(
                f"count = {count} rows cannot be chosen; give {least}, the fewest that tell "
                f"{len(self.fitted)} parameters, to {there}"
            )
        return best_rows(self._planned, self.errors, count)

    def some(self, rows: Sequence[int]) -> MeasurementPlan:
        """Return the plan with some of its rows.

        Parameters
        ----------
        rows
            Their numbers from 0.
        """
        kept = list(rows)
        return replace(
            self, values=self.values[kept], read=self.read[kept], slopes=self.slopes[kept]
        )

    def plot(self, **options: Any) -> Any:
        """Draw how much each reading tells: a change of each parameter by its own size, in errors.

        Parameters
        ----------
        **options
            Options of the drawing, e.g. ``ax=`` the axes to draw in.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.
        """
        return draw(self, **options)

    def summary(self) -> str:
        """Return what errors are to be expected."""
        missing = int((~np.isfinite(self.slopes).all(axis=(1, 2))).sum())
        lost = f"; no response is stable at {missing} of them" if missing else ""
        what = ", ".join(map(str, self.quantities))
        lines = [f"{self.model!r}: {what} at {len(self.values)} values of {self.vary}{lost}"]
        return "\n".join([*lines, *self._rows().text(), *self._remarks()])

    @property
    def _planned(self) -> Planned:
        sizes = np.abs([self.model.values[name] for name in self.fitted])
        return Planned(self.values, self.read, self.slopes, sizes)

    def _line(self) -> str:
        pairs = zip(self.fitted, self.errors_expected, strict=True)
        told = listed(f"{name} to {error:.2g}" for name, error in pairs)
        return f"Plan of {len(self.values)} readings of {self.model.name}: {told}"

    def _rows(self) -> PrintedTable:
        rows = []
        for name, error, line in zip(
            self.fitted, self.errors_expected, self.correlation, strict=True
        ):
            value = self.model.values[name]
            correlations = " ".join(f"{each:+.3f}" for each in line)
            rows.append(
                [headed(self.model.parameter(name)), f"{value:g}", f"{error:.3g}",
                 f"{100 * error / abs(value):.2g} %", correlations]
            )  # fmt: skip
        heads = ["parameter", "value", "expected error", "of it", "correlations"]
        return PrintedTable(heads, rows, ("parameter",))

    def _title(self) -> str:
        return f"what a measurement of {self.model.name} over {self.vary} would tell"

    def _given(self) -> dict[str, Any]:
        return {"vary": self.vary, "quantities": [str(item) for item in self.quantities]}

    def _attributes(self) -> dict[str, Any]:
        return {}

    def _axes(self) -> dict[str, list[str]]:
        heads = headed_quantities(self.quantities)
        return {"quantity": heads, "fitted": list(self.fitted), "other": list(self.fitted)}

    def _variables(self) -> dict[str, Variable]:
        axes = self._axes()
        parameters = [self.model.parameter(name) for name in self.fitted]
        told = zip(parameters, self.errors_expected, self.correlation, strict=True)
        table = _rows_table(self.vary, self.model.parameter(self.vary).unit)
        rows = map(_Row, self.values, self.read, self.slopes)
        quantities = zip(self.quantities, self.errors, strict=True)
        return {
            **_QUANTITIES.variables(quantities, axes),
            **_FITTED.variables(told, axes),
            **table.variables(rows, axes),
        }

    def _record(self) -> dict[str, Any]:
        return {
            "vary": self.vary,
            "quantities": [str(item) for item in self.quantities],
            "errors": self.errors,
            "fitted": list(self.fitted),
            "errors_expected": self.errors_expected,
            "correlation": self.correlation,
            "values": self.values,
            "read": self.read,
            "slopes": self.slopes,
        }

    def _csv(self) -> str:
        unit = self.model.parameter(self.vary).unit
        axes = self._axes()
        flat = [f"{what} over {name}" for what in axes["quantity"] for name in self.fitted]
        columns = (
            Column("value", REAL, "value", unit),
            Column("read", REAL, "read", None, ("quantity",)),
            Column("slopes", REAL, "slope", None, ("slope",), get=lambda row: row.slopes.ravel()),
        )
        table = Table(("row",), columns)
        heads = {"value": f"{self.vary} ({unit or '1'})", "read": "read", "slopes": "slope of"}
        sheet = Sheet(heads, (table,), {**axes, "slope": flat})
        return sheet.text(
            sheet.rows(table, list(map(_Row, self.values, self.read, self.slopes)), {})
        )

    @classmethod
    def _read(cls, saved: SavedTable) -> MeasurementPlan:
        columns = saved.columns
        return cls(
            model=saved.model,
            vary=str(saved.given["vary"]),
            quantities=tuple(
                parse_measured(text, saved.model) for text in saved.given["quantities"]
            ),
            fitted=tuple(str(item) for item in columns["fitted"]),
            values=columns["value"],
            read=columns["read"],
            slopes=columns["slopes"],
            errors=columns["quantity_error"],
            provenance=saved.provenance,
        )
