"""Loci of touches that were followed twice, since a cycle may be begun at any phase."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from slipfold.loci.locus import Locus
from slipfold.loci.window import Window
from slipfold.orbits.grazing import MET

SAME = 1e-6
"""Distance of ends, in widths of the window, that are one."""


def without_copies(loci: Sequence[Locus], window: Window) -> tuple[Locus, ...]:
    """Return loci without those touches that coincide in the plane with one before."""
    kept, numbers = list[Locus](), dict[int, int]()
    for locus in loci:
        twin = next((other for other in kept if _coincide(other, locus, window)), None)
        if twin is None:
            kept.append(locus)
            numbers[locus.id] = len(kept)
        else:
            numbers[locus.id] = numbers[twin.id]
    return tuple(loci) if len(kept) == len(loci) else tuple(_told(item, numbers) for item in kept)


def _coincide(one: Locus, other: Locus, window: Window) -> bool:
    """Whether two loci of touches have both ends in common."""
    if one.type not in MET or (one.type, one.period) != (other.type, other.period):
        return False
    low, high = np.transpose(window)
    ends = np.array([[item.begun.values, item.stopped.values] for item in (one, other)])
    places = (ends - low) / (high - low)
    ways = (places[1], places[1][::-1])
    return any(float(np.abs(places[0] - way).max()) < SAME for way in ways)


def _told(locus: Locus, numbers: dict[int, int]) -> Locus:
    """Return a locus that names itself and others by their new numbers."""
    special = tuple(
        replace(point, leads_to=tuple(numbers[number] for number in point.leads_to))
        for point in locus.special
    )
    parent = None if locus.parent is None else numbers[locus.parent]
    return replace(locus, id=numbers[locus.id], parent=parent, special=special)
