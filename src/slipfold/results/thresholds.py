"""Thresholds over a plane, and parameters chosen for one, as results."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.models.model import Model
from slipfold.parameter_space.threshold_map import INTERRUPTED
from slipfold.results.checks.checked import Checked
from slipfold.results.curves import without_defaults
from slipfold.results.fields import TEXT, Entry, Labels
from slipfold.results.records import Provenance
from slipfold.results.result import Result
from slipfold.text import PrintedTable, headed, parameter_text, place_text, with_unit

GRID = "{axes[0]} {axes[1]}"


@dataclass(frozen=True, eq=False, repr=False)
class ThresholdMap(Result):
    """Where the response of period 1 first loses its stability, over two parameters; frozen.

    Made by `slipfold.threshold_map` and `slipfold.load`. Every array has the grid's two axes first.
    Where there is no threshold, `kinds` and `reasons` say why, and the numbers are NaN.

    Notes
    -----
    A threshold is ``dataset.Nd.sel(Vd=0.6, alpha=1.0)``. `plot` draws the thresholds as colors
    with contour lines.
    """

    schema = "slipfold.threshold_map/1"
    row = "a point of the grid"
    title = "first {0.type} of {0.model.name} in {0.threshold} over {0.axes[0]} and {0.axes[1]}"
    rows = GRID
    recorded = (
        "threshold", "type", "over", "span", "interrupted", "failures", "values", "kinds",
        "reasons",
    )  # fmt: skip
    gap = "\n\n"

    model: Model
    threshold: Annotated[str, "Name of the parameter that is raised until stability is lost."]
    type: Annotated[str, '``"PD"``: the bifurcation by which it is lost.']
    over: Annotated[Mapping[str, Array], Labels()]
    span: tuple[float, float]
    values: Annotated[
        Array,
        Entry(GRID, "{threshold}", "{threshold}", name="{threshold}",
              doc="Thresholds in the unit of the parameter", more="NaN where there is none"),
    ]  # fmt: skip
    states: Annotated[Array, Entry(f"{GRID} state", "state at phase zero", head="")]
    multipliers: Annotated[
        NDArray[np.complex128],
        Entry(f"{GRID} multiplier", "Floquet multipliers", head="multiplier"),
    ]
    residuals: Annotated[
        Array, Entry(GRID, "how far the orbit fails to close, in scaled states", name="residual")
    ]
    kinds: Annotated[
        NDArray[np.str_],
        Entry(GRID, "why there is no threshold, in a few words", name="kind",
              head="no threshold"),
    ]  # fmt: skip
    reasons: Annotated[NDArray[np.object_], Entry(GRID, "why there is no threshold", name="reason")]
    followed: Annotated[
        NDArray[np.bool_],
        Entry(GRID, "whether the whole response was followed here",
              more="elsewhere the threshold was corrected from a guess, and the response below it "
              "checked at four places"),
    ]  # fmt: skip
    provenance: Provenance
    checked: Checked | None = None

    @property
    def axes(self) -> tuple[str, str]:
        """Names of the grid's two parameters."""
        first, second = self.over
        return first, second

    @property
    def failures(self) -> dict[str, int]:
        """How many points have no threshold, by the reason in a few words, most frequent first."""
        counts = Counter(kind for kind in self.kinds.ravel().tolist() if kind)
        return dict(counts.most_common())

    @property
    def interrupted(self) -> bool:
        """Whether the computation was interrupted, so that points were not reached."""
        return INTERRUPTED in self.failures

    def model_at(self, first: int, second: int) -> Model:
        """Return the model of one point of the grid, at its threshold if it has one.

        Parameters
        ----------
        first, second
            Indices along the two axes.

        Raises
        ------
        InputError
            If the parameters of this point contradict each other.
        """
        (one, ones), (other, others) = self.over.items()
        value = float(self.values[first, second])
        at = {
            one: float(ones[first]),
            other: float(others[second]),
            self.threshold: self.span[0] if np.isnan(value) else value,
        }
        return self.model.replace(**at)

    def _line(self) -> str:
        rows, columns = self.values.shape
        found = int(np.isfinite(self.values).sum())
        missing = "".join(f", {count} {kind}" for kind, count in self.failures.items())
        return f"{super()._line()}: {rows} x {columns} points, {found} thresholds{missing}"

    def _interval(self, name: str, low: float, high: float) -> str:
        return with_unit(f"{name} from {low:g} to {high:g}", self.model.parameter(name).unit)

    def _head(self) -> str:
        sought = self._interval(self.threshold, *self.span)
        plane = " and ".join(
            self._interval(name, values.min(), values.max()) for name, values in self.over.items()
        )
        changed = without_defaults(self.model, (self.threshold, *self.axes))
        rows, columns = self.values.shape
        count, followed = np.isfinite(self.values).sum(), self.followed.sum()
        return (
            f"{self.model.name}: first {self.type} in {sought} over {plane}{changed}\n"
            f"{rows} x {columns} points, {count} thresholds; whole responses followed: {followed}"
        )

    def _sections(self) -> list[PrintedTable | list[str]]:
        return [*([self._rows()] if np.isfinite(self.values).any() else []), self._notes()]

    def _rows(self) -> PrintedTable:
        """Return the lowest and the highest threshold and where they lie."""
        lines = []
        for name, find in (("lowest", np.nanargmin), ("highest", np.nanargmax)):
            at = np.unravel_index(int(find(self.values)), self.values.shape)
            places = zip(self.over.values(), at, strict=True)
            shown = [f"{values[index]:.6g}" for values, index in places]
            lines.append([name, f"{self.values[at]:.10g}", *shown])
        return PrintedTable(["", self.threshold, *self.axes], lines, words=("",))

    def _notes(self) -> list[str]:
        """Return a sentence for each kind of failure: how many points, and the first of them."""
        sentences = []
        for kind, count in self.failures.items():
            at = tuple(np.argwhere(self.kinds == kind)[0])
            pairs = zip(self.over.values(), at, strict=True)
            place = place_text(self.model, self.over, [values[index] for values, index in pairs])
            points = f"{count} point{'s' * (count > 1)}"
            reason = self.reasons[at]
            sentences.append(f"No threshold at {points}: {kind}; first at {place}: {reason}")
        stopped = ["Interrupted: some of the map is missing."] if self.interrupted else []
        return [*sentences, *stopped, *super()._notes()]


@dataclass(frozen=True, eq=False, repr=False)
class Design(Result):
    """Parameters chosen so that a threshold lies where it is wanted; frozen, a row a design.

    Made by `slipfold.design` and `slipfold.load`.

    Notes
    -----
    `plot` draws the vibration of the designs over their thresholds.
    """

    schema = "slipfold.design/1"
    row = "a design"
    recorded = ("type", "vary", "value", "period", "load", "state", "level", "interrupted")
    rows = "design"
    gap = "\n\n"

    model: Model
    type: Annotated[str, "Type of the special point, e.g. ``PD``."]
    vary: str
    value: Annotated[float, "The threshold before."]
    period: Annotated[int, "Period of its orbit in forcing periods."]
    names: Annotated[
        tuple[str, ...], Entry("chosen", "parameter to choose", name="chosen", label=True)
    ]
    bounds: Annotated[
        Array, Entry("chosen bound", "lowest and highest value", name="chosen_bounds")
    ]
    load: Annotated[float, "Value of `vary` at which the vibration is measured."]
    state: Annotated[str, "The state that vibrates."]
    level: Annotated[float, "Its vibration before, root mean square about its mean."]
    kept: Annotated[tuple[str, ...], "Names of further thresholds."]
    lower_bounds: Annotated[tuple[float, ...], "What each of these is to stay above."]
    sides: Annotated[
        tuple[str, ...],
        Entry("design", "on which side of what is wanted the threshold is to be", name="side"),
    ]
    wanted: Annotated[
        Array,
        Entry(
            "design", "what the threshold is to be above or below", "{vary}", head="{vary} wanted"
        ),
    ]
    values: Annotated[
        Array, Entry("design chosen", "values chosen", head="", more="NaN: none found")
    ]
    thresholds: Annotated[
        Array, Entry("design kept", "the threshold, then those that are kept", "{vary}", head="")
    ]
    levels: Annotated[
        Array,
        Entry("design", "vibration of the state, root mean square about its mean", "{state}",
              name="level", head="rms {state}"),
    ]  # fmt: skip
    confirmed: Annotated[
        NDArray[np.bool_],
        Entry(
            "design",
            "whether a response followed again meets the threshold first",
            more="of a longer period, whether doublings lead to it, each of them soft",
        ),
    ]
    reasons: Annotated[
        NDArray[np.str_], Entry("design", "why there is no design", name="reason", head="no design")
    ]
    interrupted: bool
    provenance: Provenance

    arrays = MappingProxyType({
        "_units": Entry("chosen", "unit of the parameter", kind=TEXT, name="chosen_units"),
        "_named": Entry("kept", "name of the threshold", kind=TEXT, name="kept", label=True),
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

    def _head(self) -> str:
        return self._title()

    def _rows(self) -> PrintedTable:
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
        return PrintedTable(heads, rows, (heads[0], "confirmed"))

    def _notes(self) -> list[str]:
        said = [
            f"Nothing for {side} {wanted:g}: {reason}"
            for side, wanted, reason in zip(self.sides, self.wanted, self.reasons, strict=True)
            if reason
        ]
        return [*said, *super()._notes()]

    def _line(self) -> str:
        found = int((self.reasons == "").sum())
        return f"{self._title()}: {found} of {len(self.sides)} found"

    def _title(self) -> str:
        load = parameter_text(self.model.parameter(self.vary), self.load)
        chosen = ", ".join(self.names)
        return (
            f"{self.model.name}: {chosen} for {self.type} in {self.vary}, minimum vibration of "
            f"{self.state} at {load}"
        )

    def _record(self) -> dict[str, Any]:
        return {
            **super()._record(),
            "bounds": dict(zip(self.names, self.bounds.tolist(), strict=True)),
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
