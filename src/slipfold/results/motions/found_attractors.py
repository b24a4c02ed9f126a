"""What starts came to: attractors with their shares, as every search for them results in."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import sqrt
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipfold.long_term.attractor import Attractor
from slipfold.long_term.search import UNDECIDED, UNFINISHED
from slipfold.models.model import Model
from slipfold.results.fields import COMPLEX, TEXT, WHOLE, Column, Items
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.text.one_line import number_text
from slipfold.text.printed_table import PrintedTable

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


COLUMNS = (
    Column("id", WHOLE, "number of the attractor", label=True, name="attractor", record=True),
    Column("kind", TEXT, "what it is", record=True),
    Column("period", WHOLE, "period in forcing periods, 0 for none", "", optional=True,
           record=True),
    Column("duration", meaning="period of a cycle", unit="s", optional=True, record=True),
    Column("state", meaning="a state on it, at phase zero", dimensions=("state",), name="states",
           record=True),
    Column("minimum", meaning="least values of outputs", dimensions=("output",), record=True),
    Column("maximum", meaning="largest values of outputs", dimensions=("output",), record=True),
    Column("multipliers", COMPLEX, "Floquet multipliers; of an equilibrium eigenvalues in 1/s",
           dimensions=("multiplier",), record=True),
    Column("exponents", meaning="Lyapunov exponents of a torus or chaos", unit="1/{per}",
           dimensions=("multiplier",), record=True),
)  # fmt: skip
"""What is said of an attractor."""

ATTRACTORS = Items("attractor", Attractor, COLUMNS)

REACHED = (
    "number of the attractor that the motion came to; 0 undecided, -1 ended before, -2 not finished"
)


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class FoundAttractors(Result):
    """Attractors, and which of them each of many starts came to."""

    model: Model
    labels: NDArray[np.int64]  # of each start, any shape
    attractors: Annotated[tuple[Attractor, ...], ATTRACTORS]
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

    @property
    def per(self) -> str:
        """What Lyapunov exponents are per: ``"forcing period"``, or ``"s"``."""
        return "forcing period" if self.model.forced else "s"

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

    def _record(self) -> dict[str, Any]:
        records = ATTRACTORS.record(self, "attractors")
        for item, record in zip(self.attractors, records, strict=True):
            record["starts"] = int((self.labels == item.id).sum())
            record["share"] = self.share(item)._asdict()
        return {
            **super()._record(),
            "attractors": records,
            "undecided": int((self.labels == UNDECIDED).sum()),
            "ended": self.ends,
            "interrupted": self.interrupted,
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
