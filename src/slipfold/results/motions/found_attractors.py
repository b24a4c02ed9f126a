"""What starts came to: attractors with their shares, as every search for them results in."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipfold.long_term.attractor import Attractor
from slipfold.long_term.search import UNDECIDED, UNFINISHED
from slipfold.models.model import Model
from slipfold.results.column import COMPLEX, TEXT, WHOLE, Column
from slipfold.results.labelled_table import Variable
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.results.saved_table import SavedTable
from slipfold.results.table import Table, axes_of, names
from slipfold.text.one_line import number_text
from slipfold.text.printed_table import PrintedTable

__all__ = ["FoundAttractors", "Share", "attractor_table", "in_words", "share_of"]

SURE = 1.96
"""Standard deviations of a normal distribution within which 95 of a hundred lie."""


class Share(NamedTuple):
    """Share of the starts that came to something.

    Parameters
    ----------
    value
        The share, from 0 to 1.
    low, high
        Bounds that hold with 95 % confidence.
    """

    value: float
    low: float
    high: float


def share_of(hits: int, count: int) -> Share:
    """Return the share of some starts, with Wilson's bounds."""
    if not count:
        return Share(np.nan, 0.0, 1.0)
    share = hits / count
    middle = share + SURE**2 / (2 * count)
    half = SURE * sqrt(share * (1 - share) / count + SURE**2 / (4 * count**2))
    low, high = ((middle + sign * half) / (1 + SURE**2 / count) for sign in (-1, 1))
    return Share(share, max(low, 0.0), min(high, 1.0))


def attractor_table(model: Model) -> Table:
    """What motions settle on."""
    per = "1/forcing period" if model.forced else "1/s"
    output, multiplier = ("output",), ("multiplier",)
    return Table(
        ("attractor",),
        (
            Column("id", WHOLE, "number of the attractor", label=True, name="attractor"),
            Column("kind", TEXT, "what it is", record=True),
            Column("period", WHOLE, "period in forcing periods, 0 for none", "", optional=True,
                   record=True),
            Column("duration", meaning="period of a cycle", unit="s", optional=True, record=True),
            Column("state", meaning="a state on it, at phase zero", dimensions=("state",),
                   name="states", record=True),
            Column("minimum", meaning="least values of outputs", dimensions=output, record=True),
            Column("maximum", meaning="largest values of outputs", dimensions=output, record=True),
            Column("multipliers", COMPLEX, "Floquet multipliers; of an equilibrium eigenvalues",
                   dimensions=multiplier, record=True),
            Column("exponents", meaning="Lyapunov exponents of a torus or chaos", unit=per,
                   dimensions=multiplier, record=True),
        ),
    )  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class FoundAttractors(Result):
    """Attractors, and which of them each of many starts came to."""

    model: Model
    labels: NDArray[np.int64]  # of each start, any shape
    attractors: tuple[Attractor, ...]
    ends: dict[str, int]
    asked: int | None
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

    def share(self, attractor: Attractor | int) -> Share:
        """Return the share of the starts that came to an attractor.

        The bounds are those of Wilson for independent starts; evenly spread ones err less.

        Parameters
        ----------
        attractor
            One of them, or its number; 0 for undecided motions, -1 for those that ended before.

        Returns
        -------
        Share
            The share and its bounds at 95 % confidence.
        """
        number = attractor.id if isinstance(attractor, Attractor) else attractor
        finished = self.labels[self.labels != UNFINISHED]
        return share_of(int((finished == number).sum()), len(finished))

    def _rest(self) -> list[str]:
        """Return what is said of motions that came to nothing."""
        rest = [f"{count} ended: {kind}" for kind, count in self.ends.items()]
        undecided = int((self.labels == UNDECIDED).sum())
        unfinished = int((self.labels == UNFINISHED).sum())
        if undecided:
            rest.append(f"{undecided} undecided; give more periods")
        if unfinished:
            rest.append(f"{unfinished} not finished, the search was interrupted")
        return rest or ["Every start came to one of them"]

    def _rows(self) -> PrintedTable:
        output = self.model.states[0].name
        rows = []
        for item in self.attractors:
            share = self.share(item)
            rows.append(
                [
                    str(item.id),
                    in_words(item),
                    str(int((self.labels == item.id).sum())),
                    f"{share.value:.3f}",
                    f"{share.low:.3f} to {share.high:.3f}",
                    number_text(item.minimum[0]),
                    number_text(item.maximum[0]),
                    _growth(item),
                ]
            )
        ends = (f"min {output}", f"max {output}")
        heads = ["", "what", "starts", "share", "95 %", *ends, "largest"]
        return PrintedTable(heads, rows, words=("what", "largest"))

    def _attributes(self) -> dict[str, Any]:
        return {"ends": json.dumps(dict(self.ends)), "interrupted": int(self.interrupted)}

    def _variables(self) -> dict[str, Variable]:
        model = self.model
        labels = names("state", model.states)
        labels |= names("output", [*model.states, *model.outputs()])
        return labels | attractor_table(model).variables(self.attractors, axes_of(model))

    def _record(self) -> dict[str, Any]:
        table = attractor_table(self.model)
        return {
            "attractors": [
                {
                    "id": item.id,
                    **table.record(item),
                    "starts": int((self.labels == item.id).sum()),
                    "share": self.share(item)._asdict(),
                }
                for item in self.attractors
            ],
            "undecided": int((self.labels == UNDECIDED).sum()),
            "ended": self.ends,
            "interrupted": self.interrupted,
        }

    @staticmethod
    def _fields(saved: SavedTable) -> dict[str, Any]:
        """Return what a file holds of all this."""
        table, axes = attractor_table(saved.model), axes_of(saved.model)
        count, asked = len(saved.columns["attractor"]), saved.given["periods"]
        return {
            "model": saved.model,
            "labels": saved.columns["reached"],
            "attractors": tuple(Attractor(**table.read(saved, axes, row)) for row in range(count)),
            "ends": json.loads(str(saved.attributes["ends"])),
            "asked": None if asked is None else int(asked),
            "interrupted": bool(saved.attributes["interrupted"]),
            "provenance": saved.provenance,
        }


def in_words(item: Attractor) -> str:
    """Return what an attractor is."""
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
