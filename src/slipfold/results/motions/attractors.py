"""All attractors from a box of starts as a result: saved, printed, with who came to which."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipfold.long_term.box import Box
from slipfold.results.column import WHOLE, Column
from slipfold.results.labelled_table import Variable
from slipfold.results.motions.found_attractors import FoundAttractors, in_words
from slipfold.results.saved_table import SavedTable
from slipfold.results.sheet import Sheet
from slipfold.results.table import Table, axes_of
from slipfold.text.one_line import listed, number_text

__all__ = ["Attractors"]

Array = NDArray[np.float64]


class _Start(NamedTuple):
    state: Array
    label: int


STARTS = Table(
    ("start",),
    (
        Column("state", meaning="starting state at phase zero", dimensions=("state",),
               name="starting_states"),
        Column("label", WHOLE, "number of the attractor that its motion came to; 0 undecided, "
               "-1 ended before, -2 not finished", "", name="reached"),
    ),
)  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Attractors(FoundAttractors):
    """All that motions from a box of starts settle on; frozen.

    Made by `slipfold.attractors` and `slipfold.load`. It is a sequence of
    `slipfold.Attractor`.

    Parameters
    ----------
    model
        The model with its parameter values.
    box
        Corners ``low`` and ``high`` of the box, each of shape (n_states,).
    seed
        Of the starts.
    asked
        Periods that were asked for; None if none were.
    starts
        Starting states, shape (n_starts, n_states).
    labels
        Number of the attractor that each of them came to, shape (n_starts,); 0 where that is
        undecided, -1 where the motion ended before, -2 where it was not finished.
    attractors
        What was found, each verified.
    ends
        How many motions ended before they came to anything, by the limit of the model they met.
    interrupted
        Whether the search was interrupted.
    provenance
        Versions and time.

    Notes
    -----
    In the dataset of `to_xarray`, along ``attractor``: ``kind``, ``period``, ``duration``, a state
    among ``states``, ``minimum`` and ``maximum`` of each ``output``, ``multipliers_real`` and
    ``_imag``, ``exponents``; along ``start``: ``starting_states`` and ``reached``. In the
    spreadsheet of `to_csv` a start is a row. In `to_json`, schema slipfold.attractors/1.

    Examples
    --------
    >>> import slipfold as sf
    >>> duffing = sf.built_in_models()["duffing"](W=1.2)
    >>> found = sf.attractors(duffing, {"q": (-3, 3), "v": (-3, 3)}, starts=16)
    >>> sorted(round(float(item.maximum[0]), 4) for item in found)
    [0.4177, 2.5456]
    """

    schema = "slipfold.attractors/1"

    box: Box
    seed: int
    starts: Array

    def summary(self) -> str:
        """Return what was found, with shares, and what came to nothing."""
        moved = [
            f"{state.name} {number_text(low)} to {number_text(high)}"
            for state, low, high in zip(self.model.states, self.box.low, self.box.high, strict=True)
            if low < high
        ]
        head = [f"{self.model!r} from {len(self.starts)} starts: {listed(moved)}"]
        return "\n".join([*head, *self._rows().text(), *self._rest(), *self._remarks()])

    def _line(self) -> str:
        found = listed(in_words(item) for item in self.attractors)
        return f"Attractors of {self.model.name}: {found or 'none'}"

    def _title(self) -> str:
        return f"attractors of {self.model.name}"

    def _given(self) -> dict[str, Any]:
        return {
            "box": [self.box.low.tolist(), self.box.high.tolist()],
            "seed": self.seed,
            "periods": self.asked,
        }

    def _variables(self) -> dict[str, Variable]:
        return super()._variables() | STARTS.variables(self._starts(), axes_of(self.model))

    def _starts(self) -> list[_Start]:
        return [_Start(*pair) for pair in zip(self.starts, self.labels.tolist(), strict=True)]

    def _record(self) -> dict[str, Any]:
        return {
            "box": {"low": self.box.low, "high": self.box.high},
            "starts": len(self.starts),
            "seed": self.seed,
            **super()._record(),
        }

    def _csv(self) -> str:
        sheet = Sheet({"state": "", "label": "reached"}, (STARTS,), axes_of(self.model))
        return sheet.text(sheet.rows(STARTS, self._starts(), {}))

    @classmethod
    def _read(cls, saved: SavedTable) -> Attractors:
        low, high = (np.array(corner) for corner in saved.given["box"])
        return cls(
            box=Box(low, high),
            seed=int(saved.given["seed"]),
            starts=saved.columns["starting_states"],
            **cls._fields(saved),
        )
