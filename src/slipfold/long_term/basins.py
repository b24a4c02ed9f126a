"""Basins of attraction: their boundaries on a plane, and their fractions of a box."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.long_term.attractor import Attractor
from slipfold.long_term.classification import FLOOR
from slipfold.long_term.search import UNFINISHED, Searched, search, search_released
from slipfold.models.model import Model
from slipfold.progress import Observer, Progress

KNOWN, WITHIN_CELL, WITHIN_ERROR = 0, 1, 2
"""Whether the label of a cell is certain, differs at a corner, or differs for a start perturbed by
an integration error."""


@dataclass(frozen=True, eq=False)
class FoundBasins:
    """Labels of the cells of a plane; shapes of arrays (n_second, n_first)."""

    searched: Searched  # of the centers of cells
    labels: NDArray[np.int64]
    uncertain: NDArray[np.int64]
    attractors: tuple[Attractor, ...]
    interrupted: bool


def find_basins(
    model: Model,
    axes: tuple[Array, Array],
    starts_at: Callable[[Array, Array], tuple[Array, Array]],
    periods: int | None,
    observer: Observer | None,
) -> FoundBasins:
    """Label the cells of a plane by their attractors, and mark uncertain cells.

    Trajectories start at the centers of cells, then at their corners. Cells whose labels differ and
    their neighbors are labeled again from states perturbed by integration errors. `starts_at`
    returns states and phases of coordinates. Shapes: axes (n_first,), (n_second,).
    """

    def searched_on(starts: Array, phases: Array) -> Searched:
        return search_released(last.model, starts, phases, periods, observer, last.known)

    starts, phases = starts_at(*_grid(*axes))
    first = last = search_released(model, starts, phases, periods, observer)
    labels = first.labels.reshape(len(axes[1]), -1)
    uncertain = np.full_like(labels, KNOWN)
    if not last.interrupted:
        last = searched_on(*starts_at(*_grid(*map(_edges, axes))))
        corners = last.labels.reshape(len(labels) + 1, -1)
        for up, across in product((slice(1, None), slice(-1)), repeat=2):
            uncertain[_differ(labels, corners[up, across])] = WITHIN_CELL
    cells = np.flatnonzero(_with_neighbors(uncertain > KNOWN))
    moved = FLOOR * last.model.state_scales()
    for sign in (-1.0, 1.0) if len(cells) else ():
        if not last.interrupted:
            last = searched_on(starts[cells] + sign * moved, phases[cells])
            uncertain.flat[cells[_differ(labels.flat[cells], last.labels)]] = WITHIN_ERROR
    attractors = tuple(item.attractor for item in last.known)
    return FoundBasins(first, labels, uncertain, attractors, last.interrupted)


def _grid(first: Array, second: Array) -> tuple[Array, Array]:
    across, up = np.meshgrid(first, second)
    return across.ravel(), up.ravel()


def _edges(values: Array) -> Array:
    """Return the ends of cells within the plane. Shapes: values (n,), returns (n + 1,)."""
    return np.concatenate([values[:1], 0.5 * (values[1:] + values[:-1]), values[-1:]])


def _differ(one: NDArray[np.int64], other: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether two known labels differ."""
    return np.asarray((one != other) & (one != UNFINISHED) & (other != UNFINISHED))


def _with_neighbors(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    from scipy.ndimage import binary_dilation

    return np.asarray(binary_dilation(mask, np.ones((3, 3), bool)))


Labels = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Fractions:
    """Attractors and labels of starts at each value of a parameter."""

    labels: Labels  # shape (n_values, n_starts)
    attractors: tuple[tuple[Attractor, ...], ...]  # of each value, none where it was not finished
    ends: dict[str, int]  # how many trajectories ended early, by the kind of their end
    interrupted: bool


def find_fractions(
    model: Model,
    vary: str,
    values: Array,
    starts: Array,
    periods: int | None,
    observer: Observer | None,
) -> Fractions:
    """Search at one value after the other; an attractor keeps its number as long as it continues.

    One more trajectory, which is not counted, starts on each attractor of the previous value. It
    keeps small basins in view and shows which attractor continues which.

    Shapes: values (m,), starts (k, n).
    """
    labels = np.full((len(values), len(starts)), UNFINISHED)
    attractors: list[tuple[Attractor, ...]] = [() for _ in values]
    ends: Counter[str] = Counter()
    before: tuple[Attractor, ...] = ()
    known, interrupted = 0, False
    for place, value in enumerate(values):
        carried = np.array([item.state for item in before]).reshape(-1, starts.shape[1])
        result = search(
            model.replace(**{vary: float(value)}),
            np.concatenate([carried, starts]),
            periods,
            _of_all(observer, place, len(values), len(starts)),
        )
        if result.interrupted:
            interrupted = True
            break
        led, reached = np.split(result.labels, [len(before)])
        numbers = _numbers(result.attractors, before, led, model.state_scales(), known)
        known = max([known, *numbers.values()])
        before = tuple(replace(item, id=numbers[item.id]) for item in result.attractors)
        attractors[place] = before
        labels[place] = [numbers.get(label, label) for label in reached.tolist()]
        ends.update(result.ends)
    return Fractions(labels, tuple(attractors), dict(ends), interrupted)


def _numbers(
    found: Sequence[Attractor],
    before: Sequence[Attractor],
    led: Labels,
    scales: Array,
    known: int,
) -> dict[int, int]:
    """Return the number of each attractor: that of its predecessor of the same kind, or a new one.

    Of several predecessors the one with the nearest extremes counts.
    """
    numbers: dict[int, int] = {}
    for item in found:
        alike = [
            other
            for other, label in zip(before, led, strict=True)
            if label == item.id and (other.kind, other.period) == (item.kind, item.period)
        ]
        if alike:
            numbers[item.id] = min(alike, key=lambda other: _apart(other, item, scales)).id
        else:
            known += 1
            numbers[item.id] = known
    return numbers


def _apart(one: Attractor, other: Attractor, scales: Array) -> float:
    """Return how far the extremes of the states of two attractors are apart."""
    ends = [np.stack([item.minimum, item.maximum])[:, : len(scales)] for item in (one, other)]
    return float(np.abs((ends[0] - ends[1]) / scales).max())


def _of_all(observer: Observer | None, place: int, values: int, starts: int) -> Observer | None:
    """Return an observer of the search at one value, as part of those at all values."""
    if observer is None:
        return None

    def report(progress: Progress) -> None:
        done = int((place + progress.done / (progress.total or 1)) * starts)
        observer(replace(progress, done=done, total=values * starts))

    return report
