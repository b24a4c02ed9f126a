"""Loci as lines: smooth stretches of one criticality each, that meet at the special points."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from slipfold.loci.locus import Locus

__all__ = ["CRITICALITIES", "LocusStretch", "locus_stretches"]

Array = NDArray[np.float64]

SUPERCRITICAL, SUBCRITICAL, UNKNOWN = CRITICALITIES = ("supercritical", "subcritical", "")
"""What may happen beyond a bifurcation; empty where it is not defined, as for a fold."""

PIECES = 12
"""Straight pieces drawn between neighbouring points of a locus."""

TURNS = {"PD": ("GPD", "LPPD", "R2"), "NS": ("CH", "LPNS"), "HB": ("GH", "ZH")}
"""Where the coefficient of a normal form has a zero or a pole, and so changes its sign."""

CUSPS = ("CPC", "CP")
"""Where a locus of folds stands still and turns back."""

CLOSE = 1e-6
"""Points of a locus this near to a special point, over the length of the locus, are left out."""


@dataclass(frozen=True, eq=False)
class LocusStretch:
    """A piece of a locus on which the criticality does not change.

    Parameters
    ----------
    criticality
        One of `CRITICALITIES`.
    points
        The line: values of the two parameters, shape (n, 2).
    """

    criticality: str
    points: Array


def locus_stretches(locus: Locus) -> tuple[LocusStretch, ...]:
    """Cut a locus where its criticality changes and draw smooth lines between its points.

    Notes
    -----
    Between the points lie cubic splines in the arclength, one from cusp to cusp: there the locus
    stands still in both parameters and turns back. Special points are points of the line.
    """
    knots = _knots(locus)
    if len(knots.s) < 2:
        return ()
    kinds = _interval_kinds(locus.type, knots)
    lines = _lines(knots)
    result: list[LocusStretch] = []
    first = 0
    for i in range(1, len(kinds) + 1):
        if i < len(kinds) and kinds[i] == kinds[first]:
            continue
        # Each piece begins where the one before ends.
        points = [line[int(k > first) :] for k, line in enumerate(lines[first:i], start=first)]
        result.append(LocusStretch(kinds[first], np.concatenate(points)))
        first = i
    return tuple(result)


@dataclass(frozen=True, eq=False)
class _Knots:
    """Points a line goes through; the criticality is None where it is not known."""

    s: Array
    values: Array
    kinds: tuple[str | None, ...]
    types: tuple[str, ...]
    closed: bool


def _knots(locus: Locus) -> _Knots:
    # Rows: arclength, values, criticality, type. A special point replaces a point of the locus
    # at the same place: its values are located.
    rows: list[tuple[float, Array, str | None, str]] = [
        (point.arclength, np.array(point.values), None, point.type) for point in locus.special
    ]
    taken = np.array([point.arclength for point in locus.special])
    near = CLOSE * float(np.ptp(locus.arclength)) if len(locus) else 0.0
    for i, s in enumerate(locus.arclength):
        if not taken.size or np.min(np.abs(taken - s)) > near:
            rows.append((float(s), locus.values[i], _criticality(locus, i), ""))
    rows = sorted((row for row in rows if np.isfinite(row[1]).all()), key=lambda row: row[0])
    rows = [row for i, row in enumerate(rows) if i == 0 or row[0] > rows[i - 1][0]]
    closed = locus.closed and len(rows) > 2
    if closed:
        rows = _closed(rows)
    s, values, kinds, types = zip(*rows, strict=True) if rows else ((),) * 4
    return _Knots(np.array(s), np.array(values).reshape(-1, 2), kinds, types, closed)


def _criticality(locus: Locus, index: int) -> str | None:
    if locus.supercritical[index]:
        return SUPERCRITICAL
    return SUBCRITICAL if locus.subcritical[index] else None


def _closed(
    rows: list[tuple[float, Array, str | None, str]],
) -> list[tuple[float, Array, str | None, str]]:
    """Return to the first point, at the pace of the first and the last step."""
    s = np.array([row[0] for row in rows])
    values = np.array([row[1] for row in rows])
    size = np.ptp(values, axis=0)
    steps = np.linalg.norm(np.diff(values, axis=0) / np.where(size > 0, size, 1.0), axis=1)
    gap = np.linalg.norm((values[0] - values[-1]) / np.where(size > 0, size, 1.0))
    _, first, kind, type_ = rows[0]
    if gap < CLOSE:
        return [*rows[:-1], (float(s[-1]), first, kind, type_)]
    pace = (s[1] - s[0] + s[-1] - s[-2]) / (steps[0] + steps[-1])
    return [*rows, (float(s[-1] + gap * pace), first, kind, type_)]


def _interval_kinds(type_: str, knots: _Knots) -> list[str]:
    """Return the criticality of each interval between knots."""
    if type_ not in TURNS:
        return [UNKNOWN] * (len(knots.s) - 1)
    kinds: list[str] = []
    for i, (left, right) in enumerate(pairwise(knots.kinds)):
        known = right if right is not None else left
        if known is None:
            turns = i > 0 and knots.types[i] in TURNS[type_]
            known = _other(kinds[-1]) if turns else (kinds[-1] if kinds else UNKNOWN)
        kinds.append(known)
    return _with_beginning(type_, knots, kinds)


def _with_beginning(type_: str, knots: _Knots, kinds: list[str]) -> list[str]:
    """Fill in what precedes the first point at which the criticality is known."""
    for i in reversed(range(len(kinds) - 1)):
        if kinds[i] == UNKNOWN:
            turns = knots.types[i + 1] in TURNS[type_]
            kinds[i] = _other(kinds[i + 1]) if turns else kinds[i + 1]
    return kinds


def _other(kind: str) -> str:
    return {SUPERCRITICAL: SUBCRITICAL, SUBCRITICAL: SUPERCRITICAL}.get(kind, kind)


def _lines(knots: _Knots) -> list[Array]:
    """Return a line from each knot to the next, in smooth pieces from cusp to cusp."""
    last = len(knots.s) - 1
    cusps = [i for i in range(1, last) if knots.types[i] in CUSPS]
    lines: list[Array] = []
    for start, end in pairwise([0, *cusps, last]):
        spline = _spline(knots, start, end)
        for a, b in pairwise(range(start, end + 1)):
            line = spline(np.linspace(knots.s[a], knots.s[b], PIECES + 1))
            line[[0, -1]] = knots.values[[a, b]]
            lines.append(line)
    return lines


def _spline(knots: _Knots, start: int, end: int) -> CubicSpline:
    s, values = knots.s[start : end + 1], knots.values[start : end + 1]
    if knots.closed and end - start + 1 == len(knots.s) and knots.types[0] not in CUSPS:
        return CubicSpline(s, values, bc_type="periodic")
    ends = [_end_condition(knots.types[i], len(s)) for i in (start, end)]
    return CubicSpline(s, values, bc_type=ends)


def _end_condition(type_: str, count: int) -> Any:
    """Return how a spline ends: still at a cusp; straight if it has too few points to bend."""
    if type_ in CUSPS:
        return 1, np.zeros(2)
    return "not-a-knot" if count > 3 else (2, np.zeros(2))
