"""All attractors from a box of starts as a result: saved, printed, with who came to which."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.long_term.box import Box
from slipfold.results.fields import Field
from slipfold.results.motions.found_attractors import REACHED, FoundAttractors, in_words
from slipfold.text.one_line import listed, number_text


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

    title = "attractors of {0.model.name}"
    rows = "start"

    box: Box
    seed: int
    starts: Annotated[
        Array,
        Field("start state", "starting state at phase zero", name="starting_states", head=""),
    ]
    labels: Annotated[NDArray[np.int64], Field("start", REACHED, name="reached")]

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

    def _record(self) -> dict[str, Any]:
        return {
            "box": {"low": self.box.low, "high": self.box.high},
            "starts": len(self.starts),
            "seed": self.seed,
            **super()._record(),
        }
