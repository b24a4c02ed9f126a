"""The parameters at which readings are explained best: least squares and explaining in turns."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.measured.explanation import Explanation

Report = Callable[[Explanation], None]

ROUNDS = 12
"""Times that readings may be given to orbits again."""

BETTER = 1e-6
"""Decrease of the sum of squares, over itself, that is one: far below what intervals depend on."""

CRAWL = 1e-3
"""Decrease of the sum of squares, over itself, below which steps that end where orbits vanish are
not worth their time: trust regions shrink fourfold each time that an orbit is lost."""


class _Enough(Exception):
    """Steps that lose orbits no longer help."""


def best_of_rounds(
    start: Explanation,
    free: tuple[str, ...],
    report: Report = lambda found: None,
    scale: float = np.inf,
    close: float = BETTER,
) -> tuple[Explanation, float, bool]:
    """Return the best explanation near a start, the typical distance, and whether it converged.

    Each round minimises the sum of squares with the orbits held, then explains readings anew with
    those orbits among the candidates. So the sum never grows, and rounds cannot cycle. The typical
    distance is at most the `scale` given, `close` as for `closest`.
    """
    best, scale = start, min(start.scale, scale)
    for _ in range(ROUNDS):
        report(best)
        held = closest(best, free, scale, close)
        found = held.readings.explained(held.model, held)
        narrower = min(scale, found.scale)
        better = found.cost(narrower) < (1 - BETTER) * best.cost(narrower)
        done = not better and narrower >= (1 - BETTER) * scale
        best, scale = found if better else best, narrower
        if done:
            return best, scale, True
    return best, scale, False


def closest(
    start: Explanation, free: tuple[str, ...], scale: float, close: float = BETTER
) -> Explanation:
    """Return the least squares with the orbits held, of the rows that are used.

    `close` is the change, of the parameters over their size or of the sum of squares over itself,
    that is the last.
    """
    from scipy.optimize import least_squares  # half a second to import

    rows = start.used(scale)
    if not free or not rows.any():
        return start
    low, high = np.array([start.readings.bounds[name] for name in free]).T
    here = np.array([start.model.values[name] for name in free])
    known: dict[bytes, Explanation | None] = {here.tobytes(): start}
    best, lost = start, 0

    def at(values: Array) -> Explanation | None:
        key = values.tobytes()
        if key not in known:
            known[key] = best.moved(dict(zip(free, values.tolist(), strict=True)), rows)
        return known[key]

    def away(values: Array) -> Array:
        nonlocal lost
        found = at(values)
        if found is None:  # SciPy takes a shorter step then
            lost += 1
            return np.full(size, np.inf)
        return found.residuals(rows)

    def slopes(values: Array) -> Array:
        nonlocal best, lost
        found = at(values)
        if found is None:  # moved to its bound by rounding, where the orbit is lost
            raise _Enough
        before, now = (float(np.sum(item.residuals(rows) ** 2)) for item in (best, found))
        if found is not start and lost and before - now < CRAWL * now:
            raise _Enough
        best, lost = found, 0
        return np.nan_to_num(found.slopes(free, rows))

    size = len(start.residuals(rows))
    try:
        solved: Any = least_squares(
            away, here, slopes, bounds=(low, high), x_scale=high - low, method="dogbox",
            xtol=close, ftol=close, gtol=1e-14, max_nfev=60,
        )  # fmt: skip
    except _Enough:
        return best
    return at(solved.x) or best
