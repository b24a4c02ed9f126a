"""Motions continued to neighbouring cells of a plane until nothing new appears."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.long_term.open_motions import CHAOS, PERIODIC, STICKS, TORUS, UNDECIDED
from slipfold.long_term.places import OPEN, TOGETHER, Judged, Places
from slipfold.models.turns import without_turns

Rows = NDArray[np.intp]

SAME = 1e-2
"""Distance in scales between the means of two responses of one period above which they differ."""

NONE = "none"
"""The kind where a cell has no further motion."""

APERIODIC = (TORUS, CHAOS, UNDECIDED)

UP, DOWN = 1, 2
"""Runs that have already continued their motions along the second parameter."""

STEPS = ((1, 0), (-1, 0), (0, 1), (0, -1))
"""From a cell to those beside it, along the first and the second parameter."""


def continue_to_neighbours(work: Places, grid: Rows) -> None:
    """Continue each motion of each cell to the cells beside it, and again from what is new there.

    A motion is new if the cell has none of its kind, or, if it repeats, none of its period and
    mean. New motions are stored in further runs. Shapes: grid (n1, n2), the cells.
    """
    new = _distinct(work)
    while len(new):
        proposals = _proposals(work, grid, new)
        work.total += len(proposals) * work.periods_of_a_motion
        found = [
            _continued(work, proposals[first : first + TOGETHER])
            for first in range(0, len(proposals), TOGETHER)
        ]
        new = np.concatenate([np.empty((0, 2), np.intp), *found])


def _distinct(work: Places) -> Rows:
    """Return run and cell of each motion that no earlier run has in that cell."""
    cells = np.arange(work.kinds.shape[1])
    found = []
    for run in range(len(work.kinds)):
        rows = np.full(len(cells), run)
        new = ~_known(work, cells, work.stored(rows, cells), run)
        found.append(np.column_stack([rows[new], cells[new]]))
    return np.concatenate(found)


def _proposals(work: Places, grid: Rows, sources: Rows) -> Rows:
    """Return run and cell of motions, each with a cell beside it to which it is continued."""
    shape = grid.shape
    found = []
    for step in STEPS:
        places = np.array(np.unravel_index(sources[:, 1], shape)) + np.array(step)[:, None]
        inside = ((places >= 0) & (places < np.array(shape)[:, None])).all(axis=0)
        # Where a sweep has this very motion, it has been in the next cell as well.
        done = (DOWN, UP)[step[1] > 0] if step[1] else None
        if done is not None:
            swept = work.stored(np.full(len(sources), done), sources[:, 1])
            inside &= ~_same(work, swept, work.stored(*sources.T))
        targets = grid[tuple(places[:, inside])]
        found.append(np.column_stack([sources[inside], targets]))
    proposals = np.concatenate(found)
    # Motions that stick are expensive, and not told apart.
    sticks = work.kinds[proposals[:, 0], proposals[:, 1]] == STICKS
    stuck_there = (work.kinds[:, proposals[:, 2]] == STICKS).any(axis=0)
    return proposals[~(sticks & stuck_there)]


def _continued(work: Places, proposals: Rows) -> Rows:
    """Follow some proposals; store what is new, and return its runs and cells."""
    runs, cells, targets = proposals.T
    found = work.judged(targets, work.states[runs, cells])
    # What does not repeat soon is taken for what it was, and followed for longer if that is new.
    opened = found.kinds == OPEN
    before = work.kinds[runs, cells]
    found.kinds[opened] = np.where(np.isin(before, APERIODIC), before, UNDECIDED)[opened]
    new = ~_known(work, targets, found)
    longer = np.flatnonzero(new & opened)
    if len(longer):
        judged, interrupted = work.judged_open(targets[longer], found.states[longer])
        if interrupted:
            raise KeyboardInterrupt
        found.put(longer, judged)
        new &= ~_known(work, targets, found)
    return _stored(work, targets, found, np.flatnonzero(new))


def _stored(work: Places, targets: Rows, found: Judged, rows: Rows) -> Rows:
    """Store motions that are new, one after the other; return their runs and cells."""
    kept = []
    for row in rows:
        cell, motion = targets[row : row + 1], found.rows(np.array([row]))
        if _known(work, cell, motion)[0]:
            continue
        free = np.flatnonzero(work.kinds[:, cell[0]] == NONE)
        if not len(free):
            work.add_run(NONE)
            free = np.array([len(work.kinds) - 1])
        work.store(free[:1], cell, motion)
        kept.append((free[0], cell[0]))
    return np.array(kept, np.intp).reshape(-1, 2)


def _known(work: Places, cells: Rows, found: Judged, runs: int | None = None) -> NDArray[np.bool_]:
    """Whether motions add nothing to what the first runs, or all of them, have in their cells."""
    known = ~np.isin(found.kinds, (PERIODIC, STICKS, *APERIODIC))
    for run in range(len(work.kinds) if runs is None else runs):
        known |= _same(work, work.stored(np.full(len(cells), run), cells), found)
    return known


def _same(work: Places, one: Judged, other: Judged) -> NDArray[np.bool_]:
    """Whether pairs of motions cannot be told apart; of an undecided one it is not known."""
    apart = np.abs(without_turns(one.means - other.means, work.model.whole_turns) / work.scales)
    periodic = (one.periods == other.periods) & (apart.max(axis=1) <= SAME)
    same = (one.kinds == other.kinds) & (periodic | (one.kinds != PERIODIC))
    both = np.isin(one.kinds, APERIODIC) & np.isin(other.kinds, APERIODIC)
    return same | both & ((one.kinds == UNDECIDED) | (other.kinds == UNDECIDED))
