"""Parameters fitted to a measured response, as a result, with what explains which reading."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.drawing import draw
from slipfold.measured.least_squares import Estimate
from slipfold.measured.measurement import Measurement
from slipfold.measured.quantity import Quantity
from slipfold.models.model import Model
from slipfold.results.fields import REAL, TEXT, Column, Field, Items, Table
from slipfold.results.labelled_table import Variable
from slipfold.results.measured.measurement_plan import QUANTITIES
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.results.saved_table import SavedTable
from slipfold.text.one_line import capitalised, headed, listed, number_text
from slipfold.text.printed_table import PrintedTable, with_unit

ESTIMATES = Items("fitted", Estimate, (
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
))  # fmt: skip

ROWS = (
    Column("values", REAL, "value of the parameter", name="value", label=True),
    Column("readings", REAL, "what was measured", None, ("quantity",), head="read"),
    Column("errors", REAL, "standard deviations of the readings", None, ("quantity",),
           head="error of"),
    Column("sweep", TEXT, "how the parameter came to its value"),
)  # fmt: skip
"""What was measured."""


@dataclass(frozen=True)
class Readings:
    """A measurement as an attribute."""

    def names(self, key: str) -> set[str]:
        """Return the names of its arrays."""
        return {"row", "quantity", "value", "readings", "errors", "sweep"}

    def variables(self, result: Any, key: str) -> dict[str, Variable]:
        """Return what was measured."""
        seen: Measurement = getattr(result, key)
        values = replace(ROWS[0], unit=seen.unit, head=seen.vary)
        table = Table(("row",), (values, *ROWS[1:]), joined=True)
        quantities = QUANTITIES.table(result).variables(seen.quantities, {})
        return quantities | table.variables([seen], {})

    def attributes(self, result: Any, key: str) -> dict[str, Any]:
        """Return over what it was measured, and why it ended."""
        seen: Measurement = getattr(result, key)
        return {"vary": seen.vary, "measurement_stopped": json.dumps(seen.stopped)}

    def read(self, saved: SavedTable, result: Any, key: str) -> Measurement:
        """Return the measurement."""
        table = QUANTITIES.table(result)
        quantities = [Quantity(**table.read(saved, {}, row)) for row in range(table.count(saved))]
        fields = Table(("row",), ROWS, joined=True).read(saved, {}, ...)
        fields["sweep"] = tuple(fields["sweep"].tolist())
        vary = result.model.parameter(str(saved.attributes["vary"]))
        stopped = json.loads(saved.attributes["measurement_stopped"])
        return Measurement(
            vary=vary.name, unit=vary.unit, quantities=tuple(quantities), stopped=stopped, **fields
        )

    def record(self, result: Any, key: str) -> None:
        """Return nothing: records hold its parts."""


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

    title = "parameters of {0.model.name} fitted to a measured response"
    rows = "row"
    recorded = ("scatter", "converged", "message", "predicted", "period", "used")

    model: Model
    measurement: Annotated[Measurement, Readings()]
    estimates: Annotated[tuple[Estimate, ...], ESTIMATES]
    predicted: Annotated[Array, Field("row quantity", "what the fitted model predicts")]
    period: Annotated[
        NDArray[np.int64],
        Field("row", "of the stable response, in forcing periods, 0: none"),
    ]
    used: Annotated[NDArray[np.bool_], Field("row", "whether the row was used")]
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

    def _record(self) -> dict[str, Any]:
        seen = self.measurement
        return {
            "vary": seen.vary,
            "quantities": [str(item) for item in seen.quantities],
            "fitted": ESTIMATES.record(self, "estimates"),
            "values": seen.values,
            "readings": seen.readings,
            **super()._record(),
        }


def _open(item: Estimate) -> str:
    """Say at which bounds an interval is open."""
    bounds = {"lower": item.low == item.least, "upper": item.high == item.most}
    met = [side for side, meets in bounds.items() if meets]
    return f", at its {' and '.join(met)} bound" if met else ""
