"""A map of thresholds as a result: labelled, printed, saved, exported and drawn."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from slipfold.checks.checked import Checked
from slipfold.drawing import draw
from slipfold.models.model import Model
from slipfold.results.column import COMPLEX, REAL, TEXT, TRUTH, Column
from slipfold.results.labelled_table import Variable
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.results.saved_table import SavedTable
from slipfold.results.sheet import Sheet
from slipfold.results.table import Table, axes_of, names
from slipfold.results.threshold_summary import threshold_html, threshold_summary
from slipfold.text.one_line import headed
from slipfold.thresholds.threshold_map import GridThresholds

__all__ = ["ThresholdMap", "column_name"]

TAKEN = {
    "state", "state_units", "state_long_name", "states", "multiplier", "multipliers_real",
    "multipliers_imag", "residual", "kind", "reason", "followed", "run", "periods", "exponents",
    "means", "coexist",
}  # fmt: skip
"""Names that a parameter of the same name must not take from a column or a dimension."""


def column_name(parameter: str) -> str:
    """Return the name of the column of a parameter.

    >>> column_name("Nd"), column_name("state")
    ('Nd', 'state_value')
    """
    return f"{parameter}_value" if parameter in TAKEN else parameter


def _axis(model: Model, name: str) -> Table:
    """The values of one of the grid's parameters."""
    item, column = model.parameter(name), column_name(name)
    values = Column(
        "values", REAL, item.doc or name, item.unit,
        get=lambda values: values, name=column, label=True,
    )  # fmt: skip
    return Table((column,), (values,), joined=True)


def _grid(model: Model, axes: tuple[str, str], threshold: str) -> Table:
    """What is known at each point of the grid."""
    sought = model.parameter(threshold)
    first, second = axes
    columns = (
        Column("values", REAL, sought.doc or threshold, sought.unit,
               name=column_name(threshold), optional=True),
        Column("kinds", TEXT, "why there is no threshold, in a few words", name="kind"),
        Column("reasons", TEXT, "why there is no threshold", name="reason"),
        Column("followed", TRUTH, "whether the whole response was followed here"),
        Column("residuals", REAL, "how far the orbit fails to close, in scaled states", "",
               name="residual", optional=True),
        Column("states", REAL, "state at phase zero", None, ("state",), optional=True),
        Column("multipliers", COMPLEX, "Floquet multipliers", "", ("multiplier",), optional=True),
    )  # fmt: skip
    return Table((column_name(first), column_name(second)), columns, joined=True)


@dataclass(frozen=True, eq=False, repr=False)
class ThresholdMap(GridThresholds, Result):
    """Where the response of period 1 first loses its stability, over two parameters; frozen.

    Made by `slipfold.threshold_map` and `slipfold.load`. Every array has the grid's two axes first.
    Where there is no threshold, `kinds` and `reasons` say why, and the numbers are NaN.

    Parameters
    ----------
    model
        The model; its values of `threshold` and of the grid's parameters play no part.
    threshold
        Name of the parameter that is raised until stability is lost.
    type
        ``"PD"``: the bifurcation by which it is lost.
    over
        Values of the grid's two parameters by name, shapes (n1,) and (n2,).
    span
        First and last value of the threshold.
    values
        Thresholds, shape (n1, n2), in the unit of the parameter; NaN where there is none.
    states
        States of the orbits there at phase zero, shape (n1, n2, n_states).
    multipliers
        Their Floquet multipliers, complex, shape (n1, n2, n_states), largest modulus first.
    residuals
        How far each orbit fails to close, in scaled states, shape (n1, n2).
    kinds
        Why there is no threshold, in a few words, shape (n1, n2); empty where there is one.
    reasons
        The same as sentences.
    followed
        Whether the whole response was followed at this point, shape (n1, n2). Elsewhere the
        threshold was corrected from a guess, and the response below it checked at four places.
    provenance
        Versions and time.
    checked
        Thresholds that were computed again by other means; None if nothing was.

    Notes
    -----
    The dataset of `to_xarray` lies along the two parameters of the grid, which label it, so that
    ``dataset.Nd.sel(Vd=0.6, alpha=1.0)`` is a threshold; further along ``state`` and
    ``multiplier``. In the spreadsheet of `to_csv`, one row a point of the grid. In `to_json`,
    schema slipfold.threshold_map/1, thresholds and failures, a list for each value of the first
    parameter.

    Examples
    --------
    >>> import slipfold as sf
    >>> over = {"Vd": [0.4, 0.6, 1.0], "alpha": ["60deg"]}
    >>> found = sf.threshold_map(sf.SlidingOscillator(), "Nd", over=over, span=(0, "50mN"))
    >>> found.values[:, 0].round(8).tolist(), found.failures
    ([nan, 0.04357891, 0.03429776], {'no PD in the span': 1})
    """

    schema = "slipfold.threshold_map/1"

    provenance: Provenance
    checked: Checked | None = None

    def summary(self) -> str:
        """Return how many thresholds were found, their range, and why points have none."""
        return threshold_summary(self, self._remarks())

    def plot(self, **options: Any) -> Any:
        """Draw the thresholds as colours over the plane of the grid's parameters.

        Parameters
        ----------
        **options
            Options of the drawing, e.g. ``contours=False`` and ``ax=`` the axes to draw in.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.
        """
        return draw(self, **options)

    def _title(self) -> str:
        over = " and ".join(self.axes)
        return f"first {self.type} of {self.model.name} in {self.threshold} over {over}"

    def _given(self) -> dict[str, Any]:
        over = {name: values.tolist() for name, values in self.over.items()}
        given = {"threshold": self.threshold, "type": self.type, "over": over}
        return given | {"span": list(self.span)}

    def _attributes(self) -> dict[str, Any]:
        span = np.array(self.span, dtype=float)
        attributes = {"threshold": self.threshold, "type": self.type, "over": " ".join(self.axes)}
        return attributes | {"span": span}

    def _variables(self) -> dict[str, Variable]:
        variables = names("state", self.model.states)
        for name, values in self.over.items():
            variables |= _axis(self.model, name).variables([values], {})
        grid = _grid(self.model, self.axes, self.threshold)
        return variables | grid.variables([self], axes_of(self.model))

    def _record(self) -> dict[str, Any]:
        return {
            "threshold": self.threshold,
            "type": self.type,
            "over": self.over,
            "span": self.span,
            "interrupted": self.interrupted,
            "failures": self.failures,
            "values": self.values,
            "kinds": [[kind or None for kind in row] for row in self.kinds.tolist()],
            "reasons": [[reason or None for reason in row] for row in self.reasons.tolist()],
        }

    def _csv(self) -> str:
        model = self.model
        first, second, threshold = (
            headed(model.parameter(name)) for name in (*self.axes, self.threshold)
        )
        heads = {
            "first": first,
            "second": second,
            "values": threshold,
            "states": "",
            "multipliers": "multiplier",
            "residuals": "residual",
            "kinds": "no threshold",
            "reasons": "reason",
            "followed": "followed",
        }
        grid = _grid(model, self.axes, self.threshold)
        sheet = Sheet(heads, (grid,), axes_of(model))
        rows, columns = np.meshgrid(*self.over.values(), indexing="ij")
        known = {"first": rows.ravel().tolist(), "second": columns.ravel().tolist()}
        return sheet.text(sheet.rows(grid, [self], known))

    @classmethod
    def _read(cls, saved: SavedTable) -> ThresholdMap:
        given, model = saved.given, saved.model
        threshold, first, second = (
            model.parameter(name).name for name in (given["threshold"], *given["over"])
        )
        axes: dict[str, Any] = dict(axes_of(model))
        over = {}
        for name in (first, second):
            over[name] = _axis(model, name).read(saved, {}, ...)["values"]
            axes[column_name(name)] = over[name]
        fields = _grid(model, (first, second), threshold).read(saved, axes, ...)
        fields["reasons"] = fields["reasons"].astype(object)
        begin, end = given["span"]
        return cls(
            model=model,
            threshold=threshold,
            type=str(given["type"]),
            over=MappingProxyType(over),
            span=(float(begin), float(end)),
            provenance=saved.provenance,
            checked=saved.checked,
            **fields,
        )

    def __getstate__(self) -> dict[str, Any]:
        """Give what can be copied and sent to other processes: read-only mappings cannot."""
        return {**vars(self), "over": dict(self.over)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Lock it again."""
        vars(self).update(state, over=MappingProxyType(state["over"]))
        self.__post_init__()

    def _repr_html_(self) -> str:
        return threshold_html(self, self._remarks())
