"""A planned measurement as a result: what its readings would tell, and which of them most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Annotated, Any

import numpy as np

from slipfold.arrays import Array
from slipfold.drawing import draw
from slipfold.errors import InputError
from slipfold.measured.information import Planned, best_rows, expected
from slipfold.measured.quantity import Quantity
from slipfold.models.model import Model
from slipfold.results.fields import TEXT, Column, Field, Items
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.text.one_line import headed, listed
from slipfold.text.printed_table import PrintedTable

QUANTITIES = Items("quantity", Quantity, (
    Column("text", TEXT, "what is measured of which output", name="quantity", label=True, get=str,
           derived=True),
    Column("measure", TEXT, "what is measured"),
    Column("output", TEXT, "output of which it is measured"),
    Column("unit", TEXT, "its unit, empty for a number", name="quantity_units", label=True),
), "quantity_")  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class MeasurementPlan(Result):
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

    title = "what a measurement of {0.model.name} over {0.vary} would tell"
    rows = "row"
    recorded = (
        "vary", "quantities", "errors", "fitted", "errors_expected", "correlation", "values",
        "read", "slopes",
    )  # fmt: skip
    arrays = MappingProxyType({
        "errors_expected": Field("fitted", "expected standard error", name="fitted_error"),
        "correlation": Field("fitted other", "expected, with each of the other parameters", "",
                             name="fitted_correlation"),
        "_units": Field("fitted", "unit of the parameter", kind=TEXT, name="fitted_units",
                        label=True),
    })  # fmt: skip

    model: Model
    vary: str
    quantities: Annotated[tuple[Quantity, ...], QUANTITIES]
    fitted: Annotated[
        tuple[str, ...], Field("fitted", "name of the parameter", name="fitted", label=True)
    ]
    values: Annotated[
        Array, Field("row", "{vary}", "{vary}", name="value", label=True, head="{vary}")
    ]
    read: Annotated[Array, Field("row quantity", "what would be read")]
    slopes: Annotated[
        Array,
        Field("row quantity fitted", "derivative of what would be read by each parameter, in units "
              "of quantities over units of parameters", "see quantity_units, fitted_units",
              head="slope of"),
    ]  # fmt: skip
    errors: Annotated[
        Array, Field("quantity", "standard deviation of readings", name="quantity_error")
    ]
    provenance: Provenance

    @property
    def _units(self) -> list[str]:
        return [self.model.parameter(name).unit for name in self.fitted]

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

    def _record(self) -> dict[str, Any]:
        return super()._record() | {"quantities": [str(item) for item in self.quantities]}
