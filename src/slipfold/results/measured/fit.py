"""Parameters fitted to a measured response, as a result, with what explains which reading."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.drawing import draw
from slipfold.measured.least_squares import Estimate
from slipfold.measured.measurement import Measurement
from slipfold.measured.quantity import headed_quantities, parse_measured
from slipfold.models.model import Model
from slipfold.results.column import REAL, TEXT, TRUTH, WHOLE, Column
from slipfold.results.labelled_table import Variable
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.results.saved_table import SavedTable
from slipfold.results.sheet import Sheet
from slipfold.results.table import Table
from slipfold.text.one_line import capitalised, headed, listed, number_text
from slipfold.text.printed_table import PrintedTable, with_unit

__all__ = ["Fit"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Row:
    """A row of the measurement with what explains it."""

    value: float
    readings: Array
    errors: Array
    sweep: str
    predicted: Array
    period: int
    used: bool


def _rows_table(measurement: Measurement) -> Table:
    quantity = ("quantity",)
    return Table(
        ("row",),
        (
            Column("value", REAL, f"value of {measurement.vary}", measurement.unit, label=True),
            Column("readings", REAL, "what was measured, in quantity_units", None, quantity),
            Column("errors", REAL, "standard deviations of the readings", None, quantity),
            Column("predicted", REAL, "what the fitted model predicts", None, quantity),
            Column("period", WHOLE, "of the stable response, in forcing periods, 0: none", ""),
            Column("used", TRUTH, "whether the row was used", ""),
            Column("sweep", TEXT, "how the parameter came to its value"),
        ),
    )  # fmt: skip


_QUANTITIES = Table(
    ("quantity",),
    (
        Column("text", TEXT, "what was measured of which output", name="quantity", label=True,
               get=str),
        Column("unit", TEXT, "its unit, empty for a number", name="quantity_units", label=True),
    ),
)  # fmt: skip

_ESTIMATES = Table(
    ("fitted",),
    (
        Column("name", TEXT, "name of the parameter", name="fitted", label=True, record=True),
        Column("unit", TEXT, "its unit, empty for a number", name="fitted_units", label=True,
               record=True),
        Column("value", REAL, "fitted value, in fitted_units", name="fitted_value", record=True),
        Column("error", REAL, "standard error, in fitted_units", name="fitted_error", record=True),
        Column("low", REAL, "lower end of the interval of 95 % confidence", name="fitted_low",
               record=True),
        Column("high", REAL, "upper end of that interval", name="fitted_high", record=True),
        Column("least", REAL, "lower bound that was given", name="fitted_least", record=True),
        Column("most", REAL, "upper bound that was given", name="fitted_most", record=True),
        Column("correlation", REAL, "with each of the other parameters", "",
               ("other",), name="fitted_correlation", record=True),
    ),
)  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Result):
    """Parameters with which stable responses come nearest to a measurement; frozen.

    Made by `slipfold.fit` and `slipfold.load`.

    Parameters
    ----------
    model
        The model with the fitted values.
    measurement
        What was measured.
    estimates
        The fitted parameters: ``name``, ``unit``, ``value``, ``error`` (standard error), ``low``
        and ``high`` (ends of the interval of 95 % confidence), ``least`` and ``most`` (bounds that
        were given), ``correlation`` with each of the parameters.
    predicted
        What the fitted model predicts, shape (m, q); NaN for rows that are not used.
    period
        Period of the response that explains each row, in forcing periods, shape (m,); 0 for none.
    used
        Which rows are used, shape (m,).
    scatter
        Root mean square of the weighted residuals over degrees of freedom: 1 is expected where
        errors are given, else it is in shares of each quantity's range.
    converged
        Whether the same responses explain the same readings at the end as in the last fit.
    message
        What there is to know besides; empty if nothing.
    provenance
        Versions and time.

    Notes
    -----
    In the dataset of `to_xarray`, along ``fitted`` the parameters, along ``row`` the measurement,
    also along ``quantity``. In the spreadsheet of `to_csv` a row is one of the measurement. In
    `to_json`, schema slipfold.fit/1.

    Examples
    --------
    >>> import slipfold as sf
    >>> truth = sf.SlidingOscillator(f=12.5, mu=0.46)
    >>> seen = sf.measure(truth, "Nd", [0.01, 0.02, 0.03, 0.04], ["max y"])
    >>> found = sf.fit(truth.replace(mu=0.5), seen, {"mu": (0.3, 0.7)})
    >>> round(found.model.mu, 6)
    0.46
    """

    schema = "slipfold.fit/1"

    model: Model
    measurement: Measurement
    estimates: tuple[Estimate, ...]
    predicted: Array
    period: NDArray[np.int64]
    used: NDArray[np.bool_]
    scatter: float
    converged: bool
    message: str
    provenance: Provenance

    def __getitem__(self, name: str) -> Estimate:
        """Return the estimate of a parameter."""
        for item in self.estimates:
            if item.name == name:
                return item
        raise KeyError(name)

    def plot(self, **options: Any) -> Any:
        """Draw readings and what is predicted for them.

        Parameters
        ----------
        **options
            Options of the drawing, e.g. ``quantity="max y"`` and ``ax=`` the axes to draw in.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.
        """
        return draw(self, **options)

    def summary(self) -> str:
        """Return the parameters with their intervals, and what there is to know besides."""
        measured = self.measurement
        message = self.message
        lines = [
            f"{self.model.name} fitted to {measured._line()}",
            *self._rows().text(),
            f"{int(self.used.sum())} of {len(measured)} rows used; scatter {self.scatter:.3g}"
            + (", 1 expected" if self._errors_given else " of the readings' range"),
            *([capitalised(message, self.model.parameters)] if message else []),
        ]
        return "\n".join([*lines, *self._remarks()])

    @property
    def _errors_given(self) -> bool:
        return bool(np.isfinite(self.measurement.errors).any())

    def _line(self) -> str:
        found = listed(
            f"{item.name} = {with_unit(f'{item.value:.6g} +- {item.error:.1g}', item.unit)}"
            for item in self.estimates
        )
        return f"Fit of {self.model.name}: {found}"

    def _rows(self) -> PrintedTable:
        rows = [
            [
                headed(item),
                number_text(item.value, 10),
                f"{item.error:.2g}",
                f"{item.low:.6g} to {item.high:.6g}" + _open(item),
                " ".join(f"{value:+.3f}" for value in item.correlation),
            ]
            for item in self.estimates
        ]
        heads = ["parameter", "value", "error", "95 % interval", "correlations"]
        return PrintedTable(heads, rows, ("parameter",))

    def _title(self) -> str:
        return f"parameters of {self.model.name} fitted to a measured response"

    def _given(self) -> dict[str, Any]:
        measured = self.measurement
        return {"vary": measured.vary, "quantities": [str(item) for item in measured.quantities]}

    def _attributes(self) -> dict[str, Any]:
        return {
            "scatter": self.scatter,
            "converged": int(self.converged),
            "message": self.message,
        }

    @property
    def _each(self) -> list[_Row]:
        measured = self.measurement
        columns = (measured.values, measured.readings, measured.errors, measured.sweep)
        return [
            _Row(*row) for row in zip(*columns, self.predicted, self.period, self.used, strict=True)
        ]

    def _axes(self) -> dict[str, list[str]]:
        heads = headed_quantities(self.measurement.quantities)
        return {"quantity": heads, "other": [item.name for item in self.estimates]}

    def _variables(self) -> dict[str, Variable]:
        axes = self._axes()
        quantities = _QUANTITIES.variables(self.measurement.quantities, axes)
        estimates = _ESTIMATES.variables(self.estimates, axes)
        return quantities | estimates | _rows_table(self.measurement).variables(self._each, axes)

    def _record(self) -> dict[str, Any]:
        measured = self.measurement
        return {
            "vary": measured.vary,
            "quantities": [str(item) for item in measured.quantities],
            "fitted": [_ESTIMATES.record(item) for item in self.estimates],
            "scatter": self.scatter,
            "converged": self.converged,
            "message": self.message,
            "values": measured.values,
            "readings": measured.readings,
            "predicted": self.predicted,
            "period": self.period,
            "used": self.used,
        }

    def _csv(self) -> str:
        table = _rows_table(self.measurement)
        heads = {
            "value": f"{self.measurement.vary} ({self.measurement.unit or '1'})",
            "readings": "read",
            "errors": "error of",
            "predicted": "predicted",
            "period": "period",
            "used": "used",
            "sweep": "sweep",
        }
        sheet = Sheet(heads, (table,), self._axes())
        return sheet.text(sheet.rows(table, self._each, {}))

    @classmethod
    def _read(cls, saved: SavedTable) -> Fit:
        model, vary = saved.model, str(saved.given["vary"])
        quantities = tuple(parse_measured(text, model) for text in saved.given["quantities"])
        columns = saved.columns
        measurement = Measurement(
            vary,
            model.parameter(vary).unit,
            columns["value"],
            quantities,
            columns["readings"],
            columns["errors"],
            tuple(str(item) for item in columns["sweep"]),
        )
        count = len(columns["fitted"])
        axes = {"other": [str(item) for item in columns["fitted"]]}
        return cls(
            model=model,
            measurement=measurement,
            estimates=tuple(Estimate(**_ESTIMATES.read(saved, axes, row)) for row in range(count)),
            predicted=columns["predicted"],
            period=columns["period"],
            used=columns["used"].astype(bool),
            scatter=float(saved.attributes["scatter"]),
            converged=bool(saved.attributes["converged"]),
            message=str(saved.attributes["message"]),
            provenance=saved.provenance,
        )


def _open(item: Estimate) -> str:
    """Say at which bounds an interval is open."""
    bounds = {"lower": item.low == item.least, "upper": item.high == item.most}
    met = [side for side, meets in bounds.items() if meets]
    return f", at its {' and '.join(met)} bound" if met else ""
