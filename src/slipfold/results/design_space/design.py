"""Parameters chosen for a threshold as a result."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.drawing import draw
from slipfold.models.model import Model
from slipfold.results.fields import TEXT, Field
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.text.one_line import headed, parameter_text
from slipfold.text.printed_table import PrintedTable


@dataclass(frozen=True, eq=False, repr=False)
class Design(Result):
    """Parameters chosen so that a threshold lies where it is wanted; frozen, a row a design.

    Made by `slipfold.design` and `slipfold.load`.

    Parameters
    ----------
    model
        The model with the values that were there before, at its threshold.
    type
        Type of the special point, e.g. ``"PD"``.
    vary
        Parameter of which it is a value.
    value
        The threshold before.
    period
        Period of its orbit in forcing periods.
    names
        Parameters that were chosen.
    bounds
        Least and largest value of each, shape (d, 2).
    load
        Value of `vary` at which the vibration is measured.
    state
        The state that vibrates.
    level
        Its vibration before, root mean square about its mean.
    kept
        Names of further thresholds.
    least
        What each of these is to stay above.
    sides
        ``"above"`` or ``"below"``: on which side of what is wanted the threshold is to be.
    wanted
        What it is to be above or below, shape (n,).
    values
        Parameters chosen, shape (n, d); NaN where nothing is found.
    thresholds
        The threshold there, then those that are kept, shape (n, 1 + n_kept).
    levels
        Vibration there, shape (n,).
    reasons
        Why nothing is found, shape (n,); empty where something is.
    confirmed
        Whether the response of the design, followed anew from the load, first loses its stability
        at the threshold, or meets GRAZE or LIFT before it does, shape (n,). Of a longer period,
        whether doublings lead to it, from each of which on the response is stable.
    interrupted
        Whether the search was interrupted, so that designs are the best by then, or before all of
        them were confirmed.
    provenance
        Versions and time.

    Notes
    -----
    In the dataset of `to_xarray`, along ``design``: the designs; along ``chosen``: the parameters
    with their bounds. In the spreadsheet of `to_csv` a design is a row. In `to_json`, schema
    slipfold.design/1.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.05), f=12.5)
    >>> found = sf.design(diagram.special[0], {"Vd": (0.4, 0.8)}, above="50mN", load="20mN")
    >>> round(found.model_at(0).Vd, 9), bool(found.confirmed[0])
    (0.4, True)
    """

    schema = "slipfold.design/1"

    rows = "design"

    model: Model
    type: str
    vary: str
    value: float
    period: int
    names: Annotated[
        tuple[str, ...], Field("chosen", "parameter to choose", name="chosen", label=True)
    ]
    bounds: Annotated[Array, Field("chosen bound", "least and largest value", name="chosen_bounds")]
    load: float
    state: str
    level: float
    kept: tuple[str, ...]
    least: tuple[float, ...]
    sides: Annotated[
        tuple[str, ...],
        Field("design", "on which side of what is wanted the threshold is to be", name="side"),
    ]
    wanted: Annotated[
        Array,
        Field(
            "design", "what the threshold is to be above or below", "{vary}", head="{vary} wanted"
        ),
    ]
    values: Annotated[Array, Field("design chosen", "values chosen", head="")]
    thresholds: Annotated[
        Array, Field("design kept", "the threshold, then those that are kept", "{vary}", head="")
    ]
    levels: Annotated[
        Array,
        Field("design", "vibration of the state, root mean square about its mean", "{state}",
              name="level", head="rms {state}"),
    ]  # fmt: skip
    confirmed: Annotated[
        NDArray[np.bool_],
        Field("design", "whether a response followed anew meets the threshold first"),
    ]
    reasons: Annotated[
        NDArray[np.str_],
        Field("design", "why there is no design", name="reason", head="no design"),
    ]
    interrupted: bool
    provenance: Provenance

    arrays = MappingProxyType({
        "_units": Field("chosen", "unit of the parameter", kind=TEXT, name="chosen_units"),
        "_named": Field("kept", "name of the threshold", kind=TEXT, name="kept", label=True),
    })  # fmt: skip

    @property
    def _units(self) -> list[str]:
        return [self.model.parameter(name).unit for name in self.names]

    @property
    def _named(self) -> list[str]:
        return [self.type, *self.kept]

    def model_at(self, row: int) -> Model:
        """Return the model of a design, at its threshold.

        Parameters
        ----------
        row
            Number of the design, from 0.
        """
        values = dict(zip(self.names, self.values[row].tolist(), strict=True))
        return self.model.replace(**values, **{self.vary: float(self.thresholds[row, 0])})

    def summary(self) -> str:
        """Return what was chosen, with thresholds and vibration before and after."""
        model = self.model
        heads = [self.vary + " wanted", *(headed(model.parameter(name)) for name in self.names)]
        heads += [f"{self.type} at", *self.kept, f"rms {self.state}", "confirmed"]
        before = [model.values[name] for name in self.names]
        kept = [""] * len(self.kept)
        rows = [["before", *_shown(before), _text(self.value), *kept, _text(self.level), ""]]
        for row, side in enumerate(self.sides):
            numbers = [*self.values[row], *self.thresholds[row], self.levels[row]]
            said = "yes" if self.confirmed[row] else ""
            rows.append([f"{side} {self.wanted[row]:g}", *_shown(numbers), said])
        lines = [self._title(), "", *PrintedTable(heads, rows, (heads[0], "confirmed")).text(), ""]
        return "\n".join([*lines, *self._said()])

    def plot(self, **options: Any) -> Any:
        """Draw the vibration of the designs over their thresholds.

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

    def _said(self) -> list[str]:
        said = [
            f"Nothing for {side} {wanted:g}: {reason}"
            for side, wanted, reason in zip(self.sides, self.wanted, self.reasons, strict=True)
            if reason
        ]
        return [*said, *self._remarks()]

    def _line(self) -> str:
        found = int((self.reasons == "").sum())
        return f"{self._title()}: {found} of {len(self.sides)} found"

    def _rows(self) -> PrintedTable:
        heads = ["wanted", *self.names, "threshold", "level"]
        rows = [
            [f"{side} {wanted:g}", *_shown([*values, thresholds[0], level])]
            for side, wanted, values, thresholds, level in zip(
                self.sides, self.wanted, self.values, self.thresholds, self.levels, strict=True
            )
        ]
        return PrintedTable(heads, rows, words=("wanted",))

    def _title(self) -> str:
        load = parameter_text(self.model.parameter(self.vary), self.load)
        chosen = ", ".join(self.names)
        return (
            f"{self.model.name}: {chosen} for {self.type} in {self.vary}, least vibration of "
            f"{self.state} at {load}"
        )

    def _record(self) -> dict[str, Any]:
        return {
            "type": self.type,
            "vary": self.vary,
            "value": self.value,
            "period": self.period,
            "load": self.load,
            "state": self.state,
            "level": self.level,
            "bounds": dict(zip(self.names, self.bounds.tolist(), strict=True)),
            "interrupted": self.interrupted,
            "designs": [
                {
                    "side": side,
                    "wanted": self.wanted[row],
                    "parameters": dict(zip(self.names, self.values[row].tolist(), strict=True)),
                    "threshold": self.thresholds[row, 0],
                    "kept": dict(zip(self.kept, self.thresholds[row, 1:].tolist(), strict=True)),
                    "level": self.levels[row],
                    "confirmed": self.confirmed[row],
                    "reason": str(self.reasons[row]) or None,
                }
                for row, side in enumerate(self.sides)
            ],
        }


def _shown(values: Any) -> list[str]:
    return [_text(float(value)) for value in values]


def _text(value: float) -> str:
    return "-" if np.isnan(value) else f"{value:.6g}"
