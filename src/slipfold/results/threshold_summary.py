"""A map of thresholds in a few lines: how many, their range, and why points have none."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipfold.results.sentences import without_defaults
from slipfold.text.printed_table import PrintedTable, html_list, with_unit
from slipfold.thresholds.threshold_map import GridThresholds


def threshold_summary(found: GridThresholds, remarks: Sequence[str] = ()) -> str:
    """Return the lowest and the highest threshold, with counts above and failures below."""
    below = [*_failures(found), *remarks]
    parts = [[_title(found), _count(found)], _range_table(found).text(), below]
    if not np.isfinite(found.values).any():
        del parts[1]
    return "\n\n".join("\n".join(lines) for lines in parts if lines)


def threshold_html(found: GridThresholds, remarks: Sequence[str] = ()) -> str:
    """Return the same as HTML, for notebooks."""
    said = [_count(found), *_failures(found), *remarks]
    return _range_table(found).html(_title(found)) + html_list(said)


def _title(found: GridThresholds) -> str:
    first, last = found.span
    sought = _interval(found, found.threshold, first, last)
    plane = " and ".join(
        _interval(found, name, values.min(), values.max()) for name, values in found.over.items()
    )
    changed = without_defaults(found.model, (found.threshold, *found.axes))
    return f"{found.model.name}: first {found.type} in {sought} over {plane}{changed}"


def _interval(found: GridThresholds, name: str, low: float, high: float) -> str:
    return with_unit(f"{name} from {low:g} to {high:g}", found.model.parameter(name).unit)


def _count(found: GridThresholds) -> str:
    rows, columns = found.values.shape
    count, followed = np.isfinite(found.values).sum(), found.followed.sum()
    return f"{rows} x {columns} points, {count} thresholds; whole responses followed: {followed}"


def _range_table(found: GridThresholds) -> PrintedTable:
    """The lowest and the highest threshold and where they lie."""
    lines = []
    if np.isfinite(found.values).any():
        for name, find in (("lowest", np.nanargmin), ("highest", np.nanargmax)):
            at = np.unravel_index(int(find(found.values)), found.values.shape)
            places = zip(found.over.values(), at, strict=True)
            shown = [f"{values[index]:.6g}" for values, index in places]
            lines.append([name, f"{found.values[at]:.10g}", *shown])
    return PrintedTable(["", found.threshold, *found.axes], lines, words=("",))


def _failures(found: GridThresholds) -> list[str]:
    """One sentence a kind: how many points, and what is said of the first of them."""
    sentences = []
    for kind, count in found.failures.items():
        at = tuple(np.argwhere(found.kinds == kind)[0])
        place = ", ".join(
            with_unit(f"{name} = {values[index]:.6g}", found.model.parameter(name).unit)
            for (name, values), index in zip(found.over.items(), at, strict=True)
        )
        points = f"{count} point{'s' * (count > 1)}"
        sentences.append(f"No threshold at {points}: {kind}; first at {place}: {found.reasons[at]}")
    if found.interrupted:
        sentences.append("Interrupted: some of the map is missing.")
    return sentences
