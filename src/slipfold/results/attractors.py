"""Attractors, their basins and basin fractions as results."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import sqrt
from typing import Annotated, Any, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.errors import refusal
from slipfold.flow.flow import flow_of
from slipfold.long_term.attractor import Attractor, preserves_volume
from slipfold.long_term.search import (
    ENDED,
    UNDECIDED,
    UNFINISHED,
    WITHIN_CELL,
    WITHIN_ERROR,
    Box,
    kind_of,
)
from slipfold.models.model import Model
from slipfold.models.quantities import State
from slipfold.orbits.kinds import any_parameter
from slipfold.results.fields import COMPLEX, TEXT, WHOLE, Column, Entry, Items, axis
from slipfold.results.records import Provenance
from slipfold.results.result import PerPeriod, Result
from slipfold.results.tables import Frame
from slipfold.text import PrintedTable, listed, number_text, parameter_text

SURE = 1.96
"""Standard deviations of a normal distribution within which 95 of a hundred lie."""


N = TypeVar("N", float, Array)


class FractionEstimate(NamedTuple, Generic[N]):
    """Fraction of the starts with one outcome; along a parameter arrays, shape (n_values,).

    Parameters
    ----------
    value
        The fraction, from 0 to 1; NaN where the search was not finished.
    low, high
        Bounds that hold with 95 % confidence.
    """

    value: N
    low: N
    high: N


def fraction_of(hits: int, count: int) -> FractionEstimate[float]:
    """Return the fraction of some starts, with Wilson's bounds."""
    if not count:
        return FractionEstimate(np.nan, 0.0, 1.0)
    fraction = hits / count
    middle = fraction + SURE**2 / (2 * count)
    half = SURE * sqrt(fraction * (1 - fraction) / count + SURE**2 / (4 * count**2))
    low, high = ((middle + sign * half) / (1 + SURE**2 / count) for sign in (-1, 1))
    return FractionEstimate(fraction, max(low, 0.0), min(high, 1.0))


COLUMNS = (
    Column("id", WHOLE, "number of the attractor", label=True, name="attractor", record=True),
    Column("kind", TEXT, "what it is", record=True),
    Column("period", WHOLE, "period in forcing periods, 0 for none", "", optional=True,
           record=True),
    Column("duration", meaning="period of a cycle", unit="s", optional=True, record=True),
    Column("state", meaning="a state on it, at phase zero", dimensions=("state",), name="states",
           record=True),
    Column("minimum", meaning="smallest values of outputs", dimensions=("output",), record=True),
    Column("maximum", meaning="largest values of outputs", dimensions=("output",), record=True),
    Column("multipliers", COMPLEX, "Floquet multipliers; of an equilibrium eigenvalues in 1/s",
           dimensions=("multiplier",), record=True),
    Column("exponents", meaning="Lyapunov exponents of a torus or chaos", unit="1/{per}",
           dimensions=("multiplier",), record=True),
)  # fmt: skip
"""Columns of attractors."""

ATTRACTORS = Items("attractor", COLUMNS, kind=Attractor, doc="The attractors, each verified.")

REACHED = (
    "number of the attractor that the trajectory converged to; 0 undecided, -1 ended before, -2 "
    "not finished"
)


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class FoundAttractors(PerPeriod, Result):
    """Attractors, and which of them each of many starts converged to."""

    model: Model
    labels: Annotated[NDArray[np.int64], "Number of the attractor of each start."]
    attractors: Annotated[tuple[Attractor, ...], ATTRACTORS]
    ends: dict[str, int]
    requested: int | None
    interrupted: bool
    provenance: Provenance

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.attractors)

    def __iter__(self) -> Iterator[Attractor]:
        """Go through them in the order in which they were found."""
        return iter(self.attractors)

    def __getitem__(self, place: int) -> Attractor:
        """Return one of them."""
        return self.attractors[place]

    def fraction(self, attractor: Attractor | int) -> FractionEstimate[float]:
        """Return the fraction of the starts that converged to an attractor.

        The bounds are those of Wilson for independent starts; evenly spread ones err less. Starts
        that were not finished might all, or might not, belong to it: those that are finished first
        are no random sample.

        Parameters
        ----------
        attractor
            One of them, or its number; 0 for undecided starts, -1 for those that ended before.

        Returns
        -------
        FractionEstimate
            The fraction and its bounds at 95 % confidence.
        """
        number = attractor.id if isinstance(attractor, Attractor) else attractor
        hits, count = int((self.labels == number).sum()), self.labels.size
        open_ = int((self.labels == UNFINISHED).sum())
        least = fraction_of(hits, count)
        return least._replace(high=fraction_of(hits + open_, count).high) if open_ else least

    def _notes(self) -> list[str]:
        return starts_notes(
            self.model, self.ends, self.labels, (self.labels == UNFINISHED).sum(), "starts"
        )

    def _rows(self) -> PrintedTable:
        output = self.model.shown[0]
        column = flow_of(self.model).output_index(output)
        rows = []
        for item in self.attractors:
            fraction, count = self.fraction(item), (self.labels == item.id).sum()
            fractions = [f"{fraction.value:.3f}", f"{fraction.low:.3f} to {fraction.high:.3f}"]
            ends = [number_text(item.minimum[column]), number_text(item.maximum[column])]
            rows.append(
                [str(item.id), in_words(item), str(count), *fractions, *ends, _growth(item)]
            )
        heads = ["", "what", "starts", "fraction", "95 %"]
        heads += [f"min {output}", f"max {output}", "largest"]
        return PrintedTable(heads, rows, words=("what", "largest"))

    def _record(self) -> dict[str, Any]:
        records = ATTRACTORS.record(self, "attractors")
        for item, record in zip(self.attractors, records, strict=True):
            record["starts"] = int((self.labels == item.id).sum())
            record["fraction"] = self.fraction(item)._asdict()
        return {
            **super()._record(),
            "attractors": records,
            "undecided": int((self.labels == UNDECIDED).sum()),
            "ended": self.ends,
            "interrupted": self.interrupted,
        }


def starts_notes(
    model: Model, ends: Mapping[str, int], labels: NDArray[np.int64], unfinished: int, what: str
) -> list[str]:
    """Return sentences on starts that reached no attractor."""
    notes = [f"{count} ended: {kind}" for kind, count in ends.items()]
    if (labels == UNDECIDED).any():
        why = "the model preserves volumes of states, so nothing attracts them; add damping"
        if not preserves_volume(model):
            why = refusal(any_parameter, model) or "give more periods"
        notes.append(f"{(labels == UNDECIDED).sum()} undecided; {why}")
    if unfinished:
        notes.append(f"{unfinished} {what} not finished, the search was interrupted")
    return notes or ["Every start converged to one of them"]


def renumbered(basins: Basins, key: Callable[[Attractor], Any]) -> Basins:
    """Return basins with their attractors in another order, which fixes numbers and colors."""
    labels, items = basins.labels.copy(), sorted(basins, key=key)
    for number, item in enumerate(items, 1):
        labels[basins.labels == item.id] = number
    ordered = tuple(replace(item, id=number) for number, item in enumerate(items, 1))
    return replace(basins, labels=labels, attractors=ordered)


def in_words(item: Attractor) -> str:
    """Return the kind of an attractor in words."""
    if item.period is not None:
        return f"period {item.period}"
    return item.kind if item.duration is None else f"{item.kind} of {number_text(item.duration)} s"


def _growth(item: Attractor) -> str:
    """Return how perturbations grow, besides that along a cycle."""
    if item.kind in ("torus", "chaos"):
        return f"exponent {item.exponents[0]:.4g}"
    if item.kind == "equilibrium":
        return f"eigenvalue {item.multipliers.real.max():.4g}"
    sizes = np.abs(item.multipliers)
    if item.kind == "cycle":
        sizes = np.delete(sizes, np.abs(item.multipliers - 1).argmin())
    return f"multiplier {sizes.max(initial=0.0):.4g}"


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Attractors(FoundAttractors):
    """All that trajectories from a box of starts settle on; frozen.

    Made by `slipfold.attractors` and `slipfold.load`. It is a sequence of
    `slipfold.Attractor`.
    """

    schema = "slipfold.attractors/1"
    row = "a start"

    title = "attractors of {0.model.name}"
    rows = "start"

    box: Box
    seed: int
    starts: Annotated[
        Array, Entry("start state", "starting state at phase zero", name="starting_states", head="")
    ]
    labels: Annotated[NDArray[np.int64], Entry("start", REACHED, name="reached")]

    def _head(self) -> str:
        moved = [
            f"{state.name} {number_text(low)} to {number_text(high)}"
            for state, low, high in zip(self.model.states, self.box.low, self.box.high, strict=True)
            if low < high
        ]
        return f"{self.model!r} from {len(self.starts)} starts: {listed(moved)}"

    def _line(self) -> str:
        found = listed(in_words(item) for item in self.attractors)
        return f"Attractors of {self.model.name}: {found or 'none'}"

    def _record(self) -> dict[str, Any]:
        return {
            "box": {"low": self.box.low, "high": self.box.high},
            "starts": len(self.starts),
            "seed": self.seed,
            **super()._record(),
        }


PHASE = State("phase", "forcing period", "phase of the forcing at which the start is released")
"""The axis of a plane that is not a state."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Basins(FoundAttractors):
    """Which attractor the trajectory from each state of a plane converges to; frozen.

    Made by `slipfold.basins` and `slipfold.load`. It is a sequence of `slipfold.Attractor`.

    Notes
    -----
    Selecting is ``found.to_xarray().sel(x=0, vy=1, method="nearest")``. `plot` draws a color for
    each attractor.
    """

    schema = "slipfold.basins/1"
    row = "a start"

    title = "basins of attraction of {0.model.name} in {0.plane[0]} and {0.plane[1]}"
    rows = "{axes[0]} {axes[1]}"
    recorded = ("plane", "first", "second", "state", "labels", "uncertain")

    plane: Annotated[
        tuple[str, str],
        "Names of the two states that span the plane; one may be ``phase``, at which starts are "
        "released.",
    ]
    first: Annotated[Array, axis("{axes[0]}")]
    second: Annotated[Array, axis("{axes[1]}")]
    state: Annotated[
        Array,
        Entry("state", "starting state whose other components all starts have",
              name="starting_state"),
    ]  # fmt: skip
    labels: Annotated[NDArray[np.int64], Entry("{axes[1]} {axes[0]}", REACHED, name="reached")]
    uncertain: Annotated[
        NDArray[np.int64],
        Entry("{axes[1]} {axes[0]}", "whether the label changes: 0 no, 1 within the cell, 2 within "
              "the error of the integration", more="of a cell its corners are compared"),
    ]  # fmt: skip

    def uncertain_fraction(self, minimum: int = WITHIN_CELL) -> float:
        """Return the fraction of the cells whose label does not stand for the cell.

        Parameters
        ----------
        minimum
            1 for all cells in which the label changes, 2 for those where it changes within the
            error of the integration.
        """
        return float((self.uncertain >= minimum).mean())

    def _head(self) -> str:
        ends = [
            f"{name} {number_text(values[0])} to {number_text(values[-1])}"
            for name, values in zip(self.plane, (self.first, self.second), strict=True)
        ]
        others = [
            f"{state.name} = {number_text(value)}"
            for state, value in zip(self.model.states, self.state, strict=True)
            if state.name not in self.plane
        ]
        grid = f"{len(self.first)} x {len(self.second)} starts"
        at = f" at {listed(others)}" if others else ""
        return f"{self.model!r} from {grid}: {listed(ends)}{at}"

    def _notes(self) -> list[str]:
        within, error = map(self.uncertain_fraction, (WITHIN_CELL, WITHIN_ERROR))
        result = [f"Uncertain: the label changes within {100 * within:.3g} % of the cells"]
        if error:
            result.append(
                f"Of {100 * error:.3g} % it changes within the error of the integration: there the "
                "boundary is too fine to know it"
            )
        if self.interrupted:
            result = ["Which cells a boundary crosses is known once all starts are finished"]
        elif not within:
            result = ["The label changes within no cell"]
        return [*super()._notes(), *result]

    def _line(self) -> str:
        found = listed(f"{in_words(item)} {self.fraction(item).value:.3f}" for item in self)
        return f"Basins of {self.model.name} in {' and '.join(self.plane)}: {found or 'none'}"

    @property
    def axes(self) -> tuple[State, State]:
        """States that span the plane, with their units."""
        known = {state.name: state for state in (PHASE, *self.model.states)}
        first, second = (known[name] for name in self.plane)
        return first, second


@dataclass(frozen=True, eq=False, repr=False)
class BasinFractions(PerPeriod, Result):
    """Which fraction of the starts each attractor wins along a parameter; frozen.

    Made by `slipfold.basin_fractions` and `slipfold.load`.

    Notes
    -----
    `plot` draws the fractions with their bounds.
    """

    schema = "slipfold.basin_fractions/1"
    row = "an attractor at a value"

    title = "fractions of basins of {0.model.name} over {0.vary}"

    model: Model
    vary: str
    values: Annotated[Array, axis("{vary}")]
    box: Box
    seed: int
    requested: int | None
    starts: Annotated[
        Array, Entry("start state", "starting state at phase zero", name="starting_states")
    ]
    labels: Annotated[NDArray[np.int64], Entry("{vary} start", REACHED, name="reached")]
    attractors: Annotated[
        tuple[tuple[Attractor, ...], ...],
        replace(
            ATTRACTORS,
            doc="Attractors at each value; one that continues keeps its ``id``.",
            owner=("value", "place of the value, from 0"),
            owners="values",
        ),
    ]  # fmt: skip
    ends: dict[str, int]
    interrupted: bool
    provenance: Provenance

    @property
    def numbers(self) -> tuple[int, ...]:
        """Numbers of all attractors, in the order in which they were found."""
        return tuple(sorted({item.id for _, item in self._all()}))

    def along(self, number: int) -> dict[float, Attractor]:
        """Return an attractor at the values of the parameter at which it was found.

        Parameters
        ----------
        number
            Its number.
        """
        result = self._all()
        return {float(self.values[place]): item for place, item in result if item.id == number}

    def fraction(self, number: int) -> FractionEstimate[Array]:
        """Return the fractions of the starts that converged to an attractor, with their bounds.

        The bounds are those of Wilson for independent starts; evenly spread ones err less.

        Parameters
        ----------
        number
            Its number; 0 for undecided trajectories, -1 for those that ended before.

        Returns
        -------
        FractionEstimate
            The fractions at all values and their bounds at 95 % confidence.
        """
        hits = (self.labels == number).sum(axis=1)
        counts = (self.labels != UNFINISHED).sum(axis=1)
        rows = [fraction_of(*pair) for pair in zip(hits.tolist(), counts.tolist(), strict=True)]
        return FractionEstimate(*np.array(rows).T)

    def _head(self) -> str:
        span = parameter_text(self.model.parameter(self.vary), self.values[0], self.values[-1])
        return (
            f"{self.model!r}: {span}, {len(self.values)} values, {len(self.starts)} starts at each"
        )

    def _all(self) -> Iterator[tuple[int, Attractor]]:
        """Yield the attractors with the indices of the values."""
        return ((index, item) for index, items in enumerate(self.attractors) for item in items)

    def _rows(self) -> PrintedTable:
        rows = []
        for number in self.numbers:
            along = self.along(number)
            fractions = self.fraction(number)
            most = int(np.nanargmax(fractions.value))
            won = f"{fractions.low[most]:.3f} to {fractions.high[most]:.3f}"
            first, last, at = map(number_text, (min(along), max(along), self.values[most]))
            kind = kind_of(next(iter(along.values())))
            rows.append([str(number), kind, first, last, f"{fractions.value[most]:.3f}", won, at])
        heads = ["", "what", f"from {self.vary}", "to", "largest fraction", "95 %", "at"]
        return PrintedTable(heads, rows, words=("what",))

    def _notes(self) -> list[str]:
        unfinished = (self.labels[:, 0] == UNFINISHED).sum()
        return starts_notes(self.model, self.ends, self.labels, unfinished, "values")

    def _record(self) -> dict[str, Any]:
        table = ATTRACTORS.bound(self)
        fractions = {number: self.fraction(number) for number in (UNDECIDED, ENDED, *self.numbers)}
        return {
            "vary": self.vary,
            "values": self.values,
            "box": {"low": self.box.low, "high": self.box.high},
            "starts": len(self.starts),
            "seed": self.seed,
            "attractors": [
                {
                    "value": self.values[place],
                    **table.record_of(item),
                    "fraction": _at(fractions[item.id], place),
                }
                for place, item in self._all()
            ],
            "undecided": fractions[UNDECIDED].value,
            "ended": fractions[ENDED].value,
            "ends": self.ends,
            "interrupted": self.interrupted,
        }

    def _frame(self) -> Frame:
        fractions = {number: self.fraction(number) for number in self.numbers}
        result = [(place, item, _at(fractions[item.id], place)) for place, item in self._all()]
        columns: dict[str, Any] = {
            self.vary: self.values[[place for place, _, _ in result]],
            "attractor": [item.id for _, item, _ in result],
            "what": [kind_of(item) for _, item, _ in result],
        }
        columns |= {
            name: [fraction[name] for _, _, fraction in result] for name in FractionEstimate._fields
        }
        return Frame(columns, {self.vary: self.model.parameter(self.vary).unit})


def _at(fractions: FractionEstimate[Array], place: int) -> dict[str, float]:
    return {name: float(each[place]) for name, each in fractions._asdict().items()}
