"""In which order the lines of a grid are computed, and how a line follows from others."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array, Indices

SEEDS = 6
"""Lines an axis begins with: a polynomial of degree five spans the grid."""

WIDEST = 6


@dataclass(frozen=True, eq=False)
class Stencil:
    """How the values on one line are guessed from those on others."""

    lines: Indices  # indices of the known lines, shape (k,)
    weights: Array  # their weights, shape (k,)


def seed_lines(count: int) -> Indices:
    """Return the lines of an axis that are computed first, its ends among them."""
    return np.unique(np.linspace(0, count - 1, min(count, SEEDS)).round().astype(np.int64))


def refinements(counts: tuple[int, int]) -> Iterator[tuple[int, Indices, Indices, Indices]]:
    """Yield what to compute next until both axes are complete, the sparser axis first.

    Each time lines are added between the known lines of one axis, at the known places of the other:
    neighbours that many places away are then known on either side.
    """
    known = [seed_lines(count) for count in counts]
    while any(len(lines) < count for lines, count in zip(known, counts, strict=True)):
        gaps = [_widest_gap(lines) for lines in known]
        axis = int(np.argmax(gaps))
        middle = (known[axis][1:] + known[axis][:-1]) // 2
        new = np.setdiff1d(middle, known[axis])
        yield axis, known[axis], new, known[1 - axis]
        known[axis] = np.union1d(known[axis], new)


def _widest_gap(lines: Indices) -> int:
    return int(np.diff(lines).max(initial=0))


def stencils(places: Array, known: Indices, new: int) -> list[Stencil]:
    """Return ways to guess the values on a line, the most accurate first.

    After the widest come narrower ones and those of one side, which serve where the others touch
    points without a value.

    Shapes: places (n,).
    """
    after = int(np.searchsorted(known, new))
    chosen: list[tuple[int, ...]] = []
    for width in (WIDEST, 4, 2):
        first = min(max(after - width // 2, 0), max(len(known) - width, 0))
        chosen.append(tuple(known[first : first + width]))
    chosen += [tuple(known[max(after - 3, 0) : after]), tuple(known[after : after + 3])]
    unique = [item for item in dict.fromkeys(chosen) if item]
    return [_stencil(places, np.array(item), new) for item in unique]


def _stencil(places: Array, lines: Indices, new: int) -> Stencil:
    """Weights of the polynomial through the lines (Lagrange)."""
    nodes = places[lines]
    weights = np.ones(len(lines))
    for i, node in enumerate(nodes):
        others = np.delete(nodes, i)
        weights[i] = np.prod((places[new] - others) / (node - others))
    return Stencil(lines, weights)
