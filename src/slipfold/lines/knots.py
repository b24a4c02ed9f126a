"""Points that a line goes through, of branches and of loci."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Knot(NamedTuple):
    """A point of a line: where on it, what is drawn, what it is, how things stand there."""

    s: float
    values: tuple[float, float]
    type: str = ""
    kind: str | None = None


def arranged(
    located: Sequence[Knot], others: Sequence[Knot], arclength: NDArray[np.float64], close: float
) -> list[Knot]:
    """Return all points in order, each once; a located one replaces others near it.

    Near is less than a share `close` of the whole line.
    """
    taken = np.array([knot.s for knot in located])
    near = close * float(np.ptp(arclength)) if len(arclength) else 0.0
    far = [knot for knot in others if not (taken.size and np.min(np.abs(taken - knot.s)) <= near)]
    whole = [knot for knot in (*located, *far) if np.isfinite([knot.s, *knot.values]).all()]
    knots = sorted(whole, key=lambda knot: knot.s)
    return [knot for i, knot in enumerate(knots) if i == 0 or knot.s > knots[i - 1].s]


def runs(kinds: Sequence[str]) -> Iterator[tuple[str, int, int]]:
    """Yield each run of equal kinds with its ends.

    >>> list(runs("aab"))
    [('a', 0, 2), ('b', 2, 3)]
    """
    first = 0
    for kind, group in groupby(kinds):
        last = first + len(list(group))
        yield kind, first, last
        first = last
