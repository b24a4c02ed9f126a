"""The table at the end of each page of the gallery: ours, published, difference."""

from __future__ import annotations

import html
from collections.abc import Iterator
from dataclasses import dataclass

from slipfold import PeriodicOrbit


@dataclass(frozen=True)
class Row:
    """One number beside the one it should be.

    Parameters
    ----------
    quantity
        What it is.
    ours
        As computed on the page.
    value
        What it should be.
    published
        The same as text: as printed in the source.
    within
        Largest difference that agrees.
    source
        Where it is published.
    """

    quantity: str
    ours: float
    value: float
    published: str
    within: float
    source: str

    @property
    def difference(self) -> float:
        return self.ours - self.value

    @property
    def agrees(self) -> bool:
        return abs(self.difference) <= self.within


class Comparison:
    """Rows of numbers with what is published of them."""

    def __init__(self) -> None:
        self.rows: list[Row] = []

    def add(
        self, quantity: str, ours: float, published: str | float, source: str, within: float = 0
    ) -> None:
        """Add a row.

        Parameters
        ----------
        quantity
            What it is.
        ours
            The computed number.
        published
            Text as printed: the difference may be one in the last digit, or 1e-12, to which we
            locate points. Or the value of a closed form: 1e-9 of it.
        source
            Where it is published, or "exact".
        within
            Largest difference that agrees, where that is another one.
        """
        text = published if isinstance(published, str) else f"{published:.13g}"
        if isinstance(published, str):
            digits, _, exponent = published.lower().partition("e")
            allowed = 10.0 ** (int(exponent or 0) - len(digits.partition(".")[2]))
            allowed = max(allowed, 1e-12 * max(1.0, abs(float(published))))
        else:
            allowed = 1e-9 * max(1.0, abs(published))
        self.rows.append(
            Row(quantity, float(ours), float(published), text, within or allowed, source)
        )

    def check(self, quantity: str, orbit: PeriodicOrbit) -> None:
        """Add how far an orbit and its multipliers are from the same by collocation.

        Parameters
        ----------
        quantity
            Which orbit it is.
        orbit
            The orbit.
        """
        found = orbit.check()
        worst = max(found.states, found.duration, found.multipliers)
        name = f"{quantity}: orbit and multipliers"
        self.rows.append(Row(name, worst, 0.0, "0", 1e-8, "collocation on the same equations"))

    def __iter__(self) -> Iterator[Row]:
        return iter(self.rows)

    def _cells(self) -> list[tuple[str, ...]]:
        head = ("quantity", "ours", "published", "difference", "source")
        return [
            head,
            *(
                (
                    row.quantity,
                    f"{row.ours:.13g}",
                    row.published,
                    f"{row.difference:+.1e}",
                    row.source,
                )
                for row in self.rows
            ),
        ]

    def __str__(self) -> str:
        cells = self._cells()
        widths = [max(len(row[i]) for row in cells) for i in range(len(cells[0]))]
        return "\n".join(
            "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
            for row in cells
        )

    __repr__ = __str__

    def _repr_html_(self) -> str:
        head, *rest = self._cells()

        def line(row: tuple[str, ...], tag: str) -> str:
            return "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in row) + "</tr>"

        body = "".join(line(row, "td") for row in rest)
        top = line(head, "th")
        return f"<table class='comparison'><thead>{top}</thead><tbody>{body}</tbody></table>"
