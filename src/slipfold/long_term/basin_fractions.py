"""Which attractors starts come to along a parameter, each followed from value to value."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.long_term.attractor import Attractor
from slipfold.long_term.search import UNFINISHED, search
from slipfold.models.model import Model
from slipfold.progress import Observer, Progress

Labels = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Fractions:
    """What starts came to at each value of a parameter."""

    labels: Labels  # shape (n_values, n_starts)
    attractors: tuple[tuple[Attractor, ...], ...]  # of each value, none where it was not finished
    ends: dict[str, int]  # how many motions ended early, by the kind of their end
    interrupted: bool


def find_fractions(
    model: Model,
    vary: str,
    values: Array,
    starts: Array,
    periods: int | None,
    observer: Observer | None,
) -> Fractions:
    """Search at one value after the other; an attractor keeps its number as long as it goes on.

    From each attractor of the value before a motion starts as well, which is not counted: what
    few starts come to is not lost, and where it comes to tells which attractor goes on as which.

    Shapes: values (m,), starts (k, n).
    """
    labels = np.full((len(values), len(starts)), UNFINISHED)
    attractors: list[tuple[Attractor, ...]] = [() for _ in values]
    ends: Counter[str] = Counter()
    before: tuple[Attractor, ...] = ()
    known, interrupted = 0, False
    for place, value in enumerate(values):
        carried = np.array([item.state for item in before]).reshape(-1, starts.shape[1])
        found = search(
            model.replace(**{vary: float(value)}),
            np.concatenate([carried, starts]),
            periods,
            _of_all(observer, place, len(values), len(starts)),
        )
        if found.interrupted:
            interrupted = True
            break
        led, reached = np.split(found.labels, [len(before)])
        numbers = _numbers(found.attractors, before, led, model.state_scales(), known)
        known = max([known, *numbers.values()])
        before = tuple(replace(item, id=numbers[item.id]) for item in found.attractors)
        attractors[place] = before
        labels[place] = [numbers.get(label, label) for label in reached.tolist()]
        ends.update(found.ends)
    return Fractions(labels, tuple(attractors), dict(ends), interrupted)


def _numbers(
    found: Sequence[Attractor],
    before: Sequence[Attractor],
    led: Labels,
    scales: Array,
    known: int,
) -> dict[int, int]:
    """Return the number of each attractor: of the one like it that leads there, else a new one.

    Of several that lead there the one whose extremes are nearest goes on.
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
    """Return who is told of a search at one value as part of those at all values."""
    if observer is None:
        return None

    def told(progress: Progress) -> None:
        done = int((place + progress.done / (progress.total or 1)) * starts)
        observer(replace(progress, done=done, total=values * starts))

    return told
