"""What motions do in the regions of a bifurcation set that have no stable response of theirs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from slipfold.loci.region_map import Region, RegionCheck, RegionMap, RegionMotion
from slipfold.loci.window import Window, locus_progress
from slipfold.long_term.open_motions import PERIODIC
from slipfold.long_term.places import NOT_DONE, Places
from slipfold.models.model import Model
from slipfold.progress import Observer, Progress

Labels = NDArray[np.int64]

TRANSIENT = 400
"""Forcing periods after which it is seen whether a motion repeats, as in a map of regimes."""

MARGIN = 2
"""Cells of the regions' map around a place that have to lie in the region: nearer to a border the
label may be that of the other side."""


def resolve_regions(
    model: Model,
    plane: tuple[str, str],
    window: Window,
    regions: RegionMap,
    points: tuple[int, int],
    observer: Observer | None = None,
) -> tuple[RegionMap, bool]:
    """Follow motions on a grid in regions whose stable responses are none or not known.

    Returns the regions with their motions, and whether that was interrupted. A region whose label
    motions contradict has a check more that says so, and is not known any longer.
    """
    places = {
        region.id: _places(regions, region, window, points)
        for region in regions.regions
        if not (region.known and region.stable)
    }
    if not places:
        return regions, False
    numbers = np.repeat([*places], [len(found) for found in places.values()])
    values = np.array([place for found in places.values() for place in found])

    def tell(progress: Progress) -> None:
        if observer is not None:
            text = f"forcing periods of motions at {len(values)} places"
            middle = (float(values[0, 0]), float(values[0, 1]))
            observer(locus_progress("regimes", progress.done, progress.total, middle, text))

    columns = dict(zip(plane, values.T, strict=True))
    work = Places(model, columns, 1, np.asarray(model.start, dtype=float), TRANSIENT, tell)
    interrupted = False
    try:
        work.from_rest(0)
        work.tell_open()
    except KeyboardInterrupt:
        interrupted = True
    found: dict[int, list[RegionMotion]] = {number: [] for number in places}
    told = zip(work.told_kinds[0], work.periods[0], work.exponents[0], strict=True)
    for number, place, (kind, period, exponent) in zip(numbers, values, told, strict=True):
        if kind != NOT_DONE:
            at = (float(place[0]), float(place[1]))
            known = None if np.isnan(exponent) else float(exponent)
            found[int(number)].append(RegionMotion(at, str(kind), int(period), known))
    resolved = tuple(_with(region, tuple(found.get(region.id, ()))) for region in regions.regions)
    return replace(regions, regions=resolved), interrupted


def _with(region: Region, motions: tuple[RegionMotion, ...]) -> Region:
    """Return a region with its motions, and a check for each period of those that its label lacks.

    Longer periods are no contradiction: the label speaks of periods 1 and 2.
    """
    against = []
    for period in sorted({1, 2} - {*region.stable}):
        seen = [one.values for one in motions if (one.kind, one.period) == (PERIODIC, period)]
        if seen:
            note = (
                f"settled on a response of period {period} that none across the region has, seen "
                f"at {len(seen)} of {len(motions)} places"
            )
            against.append(RegionCheck(seen[0], "rest", period, False, note))
    return replace(region, motions=motions, checks=(*region.checks, *against))


def _places(
    regions: RegionMap, region: Region, window: Window, points: tuple[int, int]
) -> list[tuple[float, float]]:
    """Return the centres of the cells of a grid that lie in a region, or the region's own place."""
    first, second = (
        low + (np.arange(count) + 0.5) * (high - low) / count
        for (low, high), count in zip(window, points, strict=True)
    )
    inside = _within(regions.labels == region.id)
    columns, rows = (
        np.abs(cells - values[:, None]).argmin(axis=1)
        for cells, values in ((regions.first, first), (regions.second, second))
    )
    grid = inside[np.ix_(rows, columns)]
    found = [(float(first[i]), float(second[j])) for j, i in np.argwhere(grid)]
    return found or [region.place]


def _within(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the cells of an area that lie off its borders; the edge of the map is none."""
    rows, columns = mask.shape
    padded = np.pad(mask, MARGIN, mode="edge")
    around = [
        padded[i : i + rows, j : j + columns]
        for i in range(2 * MARGIN + 1)
        for j in range(2 * MARGIN + 1)
    ]
    return np.asarray(np.all(around, axis=0))
