"""How a computation ended: where it was interrupted, what stopped early, what failed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any


def interrupted_at(result: Any) -> str:
    """Return how far a computation came before it was interrupted, empty if it does not count."""
    kind = type(result).__name__
    if kind == "Diagram":
        return _interrupted_at(result)
    if kind == "LocusDiagram":
        number, points = len(result.loci), sum(map(len, result.loci))
        return f"after {points} points on {'1 locus' if number == 1 else f'{number} loci'}"
    if kind == "Simulation":
        if result.stopped is None or result.stopped.kind != "interrupted":
            return "before all checks were done"
        unit = "forcing period" if result.model.forced else "interval"
        return f"after {result.periods} {unit}s"
    return ""


def _interrupted_at(diagram: Any) -> str:
    points = sum(map(len, diagram.branches))
    if any(end.kind == "interrupted" for branch in diagram.branches for end in branch.ends):
        return f"on branch {len(diagram.branches)} after {points} points in all"
    number = sum(item.point.interrupted for item in diagram.special)
    if number:
        return f"before the normal forms of {number} of {len(diagram.special)} special points"
    if any(tori.interrupted for tori in diagram.tori):
        points = sum(map(len, diagram.tori))
        return f"on tori {diagram.tori[-1].id} after {points} of their points in all"
    if diagram.interrupted:
        return "before all checks were done"
    return f"before the extrema and uncertainties of all {points} points were computed"


def stopped_early(result: Any) -> Iterator[str]:
    """Yield what stopped before it was complete, with the reasons."""
    for branch in getattr(result, "branches", ()):
        yield from (f"branch {branch.id} {_reason(end)}" for end in branch.ends if end.early)
    for tori in getattr(result, "tori", ()):
        if tori.stopped.early:
            yield f"tori {tori.id} {_reason(tori.stopped)}"
    for locus in getattr(result, "loci", ()):
        ends = (locus.started, locus.stopped)
        yield from (f"locus {locus.id} {_reason(end)}" for end in ends if end.early)
    if type(result).__name__ == "Simulation" and result.stopped is not None:
        yield _reason(result.stopped)


def _reason(end: Any) -> str:
    return f"stopped early: {end.reason}"


def failed(result: Any) -> bool:
    """Whether something could not be computed to its end."""
    kind = type(result).__name__
    if kind == "Simulation":
        return result.stopped is not None and result.stopped.kind in ("singular", "stiff")
    if kind == "Design":
        return bool(result.reasons.any())
    return kind in ("Diagram", "LocusDiagram") and bool(result.failed)
