"""The share of starts that each attractor wins along a parameter: saved, printed, drawn."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.drawing import draw
from slipfold.long_term.attractor import Attractor
from slipfold.long_term.box import Box
from slipfold.long_term.search import ENDED, UNDECIDED, UNFINISHED, kind_of
from slipfold.models.model import Model
from slipfold.results.fields import Field, Items, axis
from slipfold.results.frame import Frame
from slipfold.results.motions.found_attractors import COLUMNS, REACHED, share_of
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.text.one_line import number_text
from slipfold.text.printed_table import PrintedTable


class Shares(NamedTuple):
    """Shares of the starts that came to something, at all values of a parameter.

    Parameters
    ----------
    value
        The shares, from 0 to 1, shape (n_values,); NaN where the search was not finished.
    low, high
        Bounds that hold with 95 % confidence at each value, shapes (n_values,).
    """

    value: Array
    low: Array
    high: Array


@dataclass(frozen=True, eq=False, repr=False)
class BasinFractions(Result):
    """Which share of the starts each attractor wins along a parameter; frozen.

    Made by `slipfold.basin_fractions` and `slipfold.load`.

    Parameters
    ----------
    model
        The model; its value of the parameter plays no part.
    vary
        Name of the parameter.
    values
        Its values, shape (n_values,), increasing.
    box
        Corners ``low`` and ``high`` of the box of starts, each of shape (n_states,).
    seed
        Of the starts.
    asked
        Periods that were asked for; None if none were.
    starts
        Starting states, the same at each value, shape (n_starts, n_states).
    labels
        Number of the attractor that each of them came to, shape (n_values, n_starts); 0 where that
        is undecided, -1 where the motion ended before, -2 where the search was not finished.
    attractors
        What was found at each value, each a `slipfold.Attractor`, length n_values. One that goes on
        from value to value keeps its ``id``.
    ends
        How many motions ended before they came to anything, by the limit of the model they met.
    interrupted
        Whether the computation was interrupted.
    provenance
        Versions and time.

    Notes
    -----
    In the dataset of `to_xarray`, along a dimension named for the parameter and ``start``:
    ``reached``; along ``start``: ``starting_states``; along ``attractor``, of which
    ``value_of_attractor`` is the place of the value: as of `slipfold.Attractors`. In the
    spreadsheet of `to_csv` an attractor at a value is a row. In `to_json`, schema
    slipfold.basin_fractions/1.

    Examples
    --------
    >>> import slipfold as sf
    >>> duffing, box = sf.built_in_models()["duffing"](), {"q": (-3, 3), "v": (-3, 3)}
    >>> found = sf.basin_fractions(duffing, "W", (1, 1.4), box, points=3, starts=64)
    >>> found.numbers, bool(found.share(1).value[0] == 1)
    ((1, 2), True)
    """

    schema = "slipfold.basin_fractions/1"

    title = "shares of basins of {0.model.name} over {0.vary}"

    model: Model
    vary: str
    values: Annotated[Array, axis("{vary}")]
    box: Box
    seed: int
    asked: int | None
    starts: Annotated[
        Array, Field("start state", "starting state at phase zero", name="starting_states")
    ]
    labels: Annotated[NDArray[np.int64], Field("{vary} start", REACHED, name="reached")]
    attractors: Annotated[
        tuple[tuple[Attractor, ...], ...],
        Items("attractor", Attractor, COLUMNS,
              owner=("value", "place of the value, from 0", "values")),
    ]  # fmt: skip
    ends: dict[str, int]
    interrupted: bool
    provenance: Provenance

    @property
    def per(self) -> str:
        """What Lyapunov exponents are per: ``"forcing period"``, or ``"s"``."""
        return "forcing period" if self.model.forced else "s"

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
        found = self._all()
        return {float(self.values[place]): item for place, item in found if item.id == number}

    def share(self, number: int) -> Shares:
        """Return the shares of the starts that came to an attractor, with their bounds.

        The bounds are those of Wilson for independent starts; evenly spread ones err less.

        Parameters
        ----------
        number
            Its number; 0 for undecided motions, -1 for those that ended before.

        Returns
        -------
        Shares
            The shares at all values and their bounds at 95 % confidence.
        """
        hits = (self.labels == number).sum(axis=1)
        counts = (self.labels != UNFINISHED).sum(axis=1)
        rows = [share_of(*pair) for pair in zip(hits.tolist(), counts.tolist(), strict=True)]
        return Shares(*np.array(rows).T)

    def plot(self, **options: Any) -> Any:
        """Draw the shares over the parameter with their bounds, a line for each attractor.

        Parameters
        ----------
        **options
            Options of the drawing, e.g. ``legend=False`` and ``ax=`` the axes to draw in.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.
        """
        return draw(self, **options)

    def summary(self) -> str:
        """Return from where to where each attractor was found and what it wins at most."""
        first, last = (number_text(self.values[place]) for place in (0, -1))
        unit = self.model.parameter(self.vary).unit
        head = (
            f"{self.model!r}: {f'{self.vary} {first} to {last} {unit}'.rstrip()}, "
            f"{len(self.values)} values, {len(self.starts)} starts at each"
        )
        return "\n".join([head, *self._rows().text(), *self._rest(), *self._remarks()])

    def _all(self) -> Iterator[tuple[int, Attractor]]:
        """Go through what was found, with the places of the values."""
        return ((place, item) for place, items in enumerate(self.attractors) for item in items)

    def _line(self) -> str:
        count = len(self.numbers)
        return f"Shares of basins of {self.model.name} over {self.vary}: {count} attractors"

    def _rows(self) -> PrintedTable:
        rows = []
        for number in self.numbers:
            along = self.along(number)
            shares = self.share(number)
            most = int(np.nanargmax(shares.value))
            rows.append(
                [
                    str(number),
                    kind_of(next(iter(along.values()))),
                    number_text(min(along)),
                    number_text(max(along)),
                    f"{shares.value[most]:.3f}",
                    f"{shares.low[most]:.3f} to {shares.high[most]:.3f}",
                    number_text(self.values[most]),
                ]
            )
        heads = ["", "what", f"from {self.vary}", "to", "largest share", "95 %", "at"]
        return PrintedTable(heads, rows, words=("what",))

    def _rest(self) -> list[str]:
        """Return what is said of motions that came to nothing, and of values not finished."""
        rest = [f"{count} motions ended: {kind}" for kind, count in self.ends.items()]
        undecided = int((self.labels == UNDECIDED).sum())
        unfinished = int((self.labels[:, 0] == UNFINISHED).sum())
        if undecided:
            rest.append(f"{undecided} motions undecided; give more periods")
        if unfinished:
            rest.append(f"{unfinished} values not finished, the search was interrupted")
        return rest or ["Every start came to one of them"]

    def _record(self) -> dict[str, Any]:
        table = Items("attractor", Attractor, COLUMNS).table(self)
        shares = {number: self.share(number) for number in (UNDECIDED, ENDED, *self.numbers)}
        return {
            "vary": self.vary,
            "values": self.values,
            "box": {"low": self.box.low, "high": self.box.high},
            "starts": len(self.starts),
            "seed": self.seed,
            "attractors": [
                {
                    "value": self.values[place],
                    **table.record(item),
                    "share": _at(shares[item.id], place),
                }
                for place, item in self._all()
            ],
            "undecided": shares[UNDECIDED].value,
            "ended": shares[ENDED].value,
            "ends": self.ends,
            "interrupted": self.interrupted,
        }

    def _frame(self) -> Frame:
        shares = {number: self.share(number) for number in self.numbers}
        found = [(place, item, _at(shares[item.id], place)) for place, item in self._all()]
        columns: dict[str, Any] = {
            self.vary: self.values[[place for place, _, _ in found]],
            "attractor": [item.id for _, item, _ in found],
            "what": [kind_of(item) for _, item, _ in found],
        }
        columns |= {name: [share[name] for _, _, share in found] for name in Shares._fields}
        return Frame(columns, {self.vary: self.model.parameter(self.vary).unit})


def _at(shares: Shares, place: int) -> dict[str, float]:
    return {name: float(each[place]) for name, each in shares._asdict().items()}
