"""The results of a planned measurement and of a fit."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.parameter_space.least_squares import Estimate
from slipfold.parameter_space.measurement import Measurement, Quantity
from slipfold.parameter_space.stable_orbits import best_rows, covariance_of
from slipfold.results.fields import REAL, TEXT, Column, Entry, Items, Nested
from slipfold.results.records import Provenance
from slipfold.results.result import Result
from slipfold.text import PrintedTable, capitalized, headed, listed, number_text, with_unit

QUANTITIES = Items("quantity", (
    Column("text", TEXT, "measured quantity", name="quantity", label=True, get=str,
           derived=True),
    Column("measure", TEXT, "measure of the output, such as max"),
    Column("output", TEXT, "measured output"),
    Column("unit", TEXT, "its unit, empty for a number", name="quantity_units", label=True),
), "quantity_", Quantity, doc="The measured quantities.")  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class MeasurementPlan(Result):
    """Expected errors of parameters from planned measurements; frozen.

    Made by `slipfold.plan_measurement` and `slipfold.load`.

    Notes
    -----
    `plot` draws the sensitivity of each measurement: its derivative with respect to each parameter,
    times the parameter's value, over the measurement's error.
    """

    schema = "slipfold.measurement-plan/1"
    row = "a value of `vary`"

    title = "planned measurement of {0.model.name} over {0.vary}"
    rows = "row"
    recorded = (
        "vary", "quantities", "errors", "fitted", "errors_expected", "correlation", "values",
        "predicted", "slopes",
    )  # fmt: skip
    arrays = MappingProxyType({
        "errors_expected": Entry("fitted", "expected standard error", name="fitted_error"),
        "correlation": Entry("fitted other", "expected, with each of the other parameters", "",
                             name="fitted_correlation"),
        "_units": Entry("fitted", "unit of the parameter", kind=TEXT, name="fitted_units",
                        label=True),
    })  # fmt: skip

    model: Model
    vary: str
    quantities: Annotated[tuple[Quantity, ...], QUANTITIES]
    fitted: Annotated[
        tuple[str, ...], Entry("fitted", "name of the parameter", name="fitted", label=True)
    ]
    values: Annotated[
        Array,
        Entry(
            "row",
            "{vary}",
            "{vary}",
            name="value",
            label=True,
            head="{vary}",
            doc="Values of the parameter in the order of the sweep",
        ),
    ]
    predicted: Annotated[
        Array, Entry("row quantity", "expected measurement", more="NaN where no response is stable")
    ]
    slopes: Annotated[
        Array,
        Entry("row quantity fitted", "derivative of the expected measurement with respect to each "
              "parameter, in units of quantities over units of parameters",
              "see quantity_units, fitted_units",
              head="slope of"),
    ]  # fmt: skip
    errors: Annotated[
        Array, Entry("quantity", "standard deviation of measurements", name="quantity_error")
    ]
    provenance: Provenance

    @property
    def _units(self) -> list[str]:
        return [self.model.parameter(name).unit for name in self.fitted]

    @property
    def covariance(self) -> Array:
        """Expected covariance of the parameters, shape (p, p); infinite if unknown."""
        scaled = self.slopes / self.errors[:, None]
        return covariance_of(scaled.reshape(-1, len(self.fitted)), self._sizes)

    @property
    def errors_expected(self) -> Array:
        """Expected standard errors of the parameters, in their units, shape (p,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def correlation(self) -> Array:
        """Expected correlations of the parameters, shape (p, p)."""
        errors = self.errors_expected
        with np.errstate(invalid="ignore"):
            result = self.covariance / np.outer(errors, errors)
        np.fill_diagonal(result, 1.0)
        return np.asarray(result)

    def best(self, count: int) -> list[int]:
        """Return the numbers of the rows that together determine the parameters best.

        Parameters
        ----------
        count
            Number of rows.

        Returns
        -------
        list of int
            Their numbers from 0. They maximize the determinant of the information matrix (a
            D-optimal design); rows are added one by one and then exchanged.

        Raises
        ------
        InputError
            If there are fewer rows, or if so few rows do not determine the parameters.
        """
        usable = int(np.isfinite(self.slopes).all(axis=(1, 2)).sum())
        needed = -(-len(self.fitted) // len(self.quantities))
        if not needed <= count <= usable:
            raise InputError(
                f"count = {count} rows cannot be chosen; give {needed}, the fewest that determine "
                f"{len(self.fitted)} parameters, to {usable}"
            )
        return best_rows(self.slopes / self.errors[:, None] * self._sizes, count)

    def select(self, rows: Sequence[int]) -> MeasurementPlan:
        """Return the plan with a subset of its rows.

        Parameters
        ----------
        rows
            Their numbers from 0.
        """
        chosen = list(rows)
        return replace(
            self,
            values=self.values[chosen],
            predicted=self.predicted[chosen],
            slopes=self.slopes[chosen],
        )

    def _head(self) -> str:
        missing = int((~np.isfinite(self.slopes).all(axis=(1, 2))).sum())
        lost = f"; no response is stable at {missing} of them" if missing else ""
        what = ", ".join(map(str, self.quantities))
        return f"{self.model!r}: {what} at {len(self.values)} values of {self.vary}{lost}"

    @property
    def _sizes(self) -> Array:
        return np.abs([self.model.values[name] for name in self.fitted])

    def _line(self) -> str:
        pairs = zip(self.fitted, self.errors_expected, strict=True)
        accuracies = listed(f"{name} to {error:.2g}" for name, error in pairs)
        return f"Plan of {len(self.values)} measurements of {self.model.name}: {accuracies}"

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

    def _record(self) -> dict[str, Any]:
        return super()._record() | {"quantities": [str(item) for item in self.quantities]}


ESTIMATES = Items("fitted", (
        Column("name", TEXT, "name of the parameter", name="fitted", label=True, record=True),
        Column("unit", TEXT, "its unit, empty for a number", name="fitted_units", label=True,
               record=True),
        Column("value", REAL, "fitted value, in fitted_units", name="fitted_value", record=True),
        Column("error", REAL, "standard error, in fitted_units", name="fitted_error", record=True),
        Column("low", REAL, "lower end of the 95 % confidence interval", name="fitted_low",
               record=True),
        Column("high", REAL, "upper end of that interval", name="fitted_high", record=True),
        Column("lower_bound", REAL, "given lower bound", name="fitted_lower_bound", record=True),
        Column("upper_bound", REAL, "given upper bound", name="fitted_upper_bound", record=True),
        Column("correlation", REAL, "with each of the other parameters", "",
               ("other",), name="fitted_correlation", record=True),
), kind=Estimate, doc="The fitted parameters: ``name``, ``unit``, ``value``, ``error`` (standard "
   "error), ``low`` and ``high`` (95 % confidence interval), ``lower_bound`` and "
   "``upper_bound`` (as given), ``correlation`` with each of the parameters.")  # fmt: skip


class MeasuredRows(Nested):
    """A declaration of a measurement that is an attribute of a result."""

    def attributes(self, result: Any, key: str) -> dict[str, Any]:
        """Return the varied parameter and why the measurement ended."""
        measured: Measurement = getattr(result, key)
        return {"vary": measured.vary, "measurement_stopped": json.dumps(measured.stopped)}


MEASUREMENT = MeasuredRows(Measurement, {
    "quantities": QUANTITIES,
    "values": Entry("row", "value of the parameter", "{vary}", name="value", label=True,
                    head="{vary}"),
    "measured": Entry("row quantity", "measured value"),
    "errors": Entry("row quantity", "standard deviation of the measurement", head="error of"),
    "sweep": Entry("row", "direction in which the parameter was swept"),
}, "The measurement.", {
    "vary": lambda saved, _: str(saved.attributes["vary"]),
    "unit": lambda saved, result: result.model.parameter(str(saved.attributes["vary"])).unit,
    "stopped": lambda saved, _: json.loads(saved.attributes["measurement_stopped"]),
})  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Result):
    """Parameters whose stable responses fit a measurement best; frozen.

    Made by `slipfold.fit` and `slipfold.load`.

    Notes
    -----
    `plot` draws the measurements and predictions of one quantity, e.g. ``quantity="max y"``.
    """

    schema = "slipfold.fit/1"
    row = "a measurement"

    title = "parameters of {0.model.name} fitted to a measured response"
    rows = "row"
    recorded = (
        "residual_std", "converged", "interrupted", "message", "predicted", "period", "used",
    )  # fmt: skip

    model: Model
    measurement: Annotated[Measurement, MEASUREMENT]
    estimates: Annotated[tuple[Estimate, ...], ESTIMATES]
    predicted: Annotated[
        Array, Entry("row quantity", "prediction of the fitted model", more="NaN if not used")
    ]
    period: Annotated[
        NDArray[np.int64], Entry("row", "of the stable response, in forcing periods, 0: none")
    ]
    used: Annotated[NDArray[np.bool_], Entry("row", "whether the row was used")]
    residual_std: Annotated[
        float,
        "Root of the sum of squared weighted residuals over the degrees of freedom. It is about 1 "
        "if errors are given; otherwise residuals are fractions of each quantity's range.",
    ]
    converged: Annotated[
        bool, "Whether the assignment of measurements to responses stayed the same in the last fit."
    ]
    message: Annotated[str, "Warnings about the fit; empty if there are none."]
    provenance: Provenance
    interrupted: Annotated[
        bool, "Whether the fit was interrupted: these are the best values so far, without intervals"
    ] = False

    def __getitem__(self, name: str) -> Estimate:
        """Return the estimate of a parameter."""
        for item in self.estimates:
            if item.name == name:
                return item
        raise KeyError(name)

    def _head(self) -> str:
        return f"{self.model.name} fitted to {self.measurement._line()}"

    def _notes(self) -> list[str]:
        errors_given = np.isfinite(self.measurement.errors).any()
        used = f"{int(self.used.sum())} of {len(self.measurement)} rows used"
        expected = ", 1 expected" if errors_given else " of the measurements' range"
        message = capitalized(self.message, self.model.parameters)
        return [
            f"{used}; residual standard deviation {self.residual_std:.3g}{expected}",
            *([message] if message else []),
        ]

    def _line(self) -> str:
        values = listed(
            f"{item.name} = {with_unit(f'{item.value:.6g} +- {item.error:.1g}', item.unit)}"
            for item in self.estimates
        )
        return f"Fit of {self.model.name}: {values}"

    def _rows(self) -> PrintedTable:
        rows = [
            [
                headed(item),
                number_text(item.value, 10),
                f"{item.error:.2g}",
                "" if self.interrupted else f"{item.low:.6g} to {item.high:.6g}" + _open(item),
                " ".join(f"{value:+.3f}" for value in item.correlation),
            ]
            for item in self.estimates
        ]
        heads = ["parameter", "value", "error", "95 % interval", "correlations"]
        return PrintedTable(heads, rows, ("parameter",))

    def _record(self) -> dict[str, Any]:
        measured = self.measurement
        return {
            "vary": measured.vary,
            "quantities": [str(item) for item in measured.quantities],
            "fitted": ESTIMATES.record(self, "estimates"),
            "values": measured.values,
            "measured": measured.measured,
            **super()._record(),
        }


def _open(item: Estimate) -> str:
    """Return at which given bounds an interval ends, in words."""
    bounds = {"lower": item.low == item.lower_bound, "upper": item.high == item.upper_bound}
    met = [side for side, meets in bounds.items() if meets]
    return f", at its {' and '.join(met)} bound" if met else ""
