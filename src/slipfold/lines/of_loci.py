"""Loci as lines: smooth stretches of one criticality each, that meet at the special points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.lines.knots import Knot, arranged, runs
from slipfold.loci.locus import Locus, LocusPoint

SUPERCRITICAL, SUBCRITICAL, UNKNOWN = CRITICALITIES = ("supercritical", "subcritical", "")
"""What may happen beyond a bifurcation; empty where it is not defined, as for a fold."""

PIECES = 12
"""Straight pieces drawn between neighbouring points of a locus."""

TURNS = {
    "PD": ("GPD", "LPPD", "R2"),
    "NS": ("CH", "LPNS"),
    "BP": ("DP", "R1", "BT"),
    "HB": ("GH", "ZH"),
}
"""Where the coefficient of a normal form has a zero or a pole, and so changes its sign."""

CUSPS = ("CPC", "CP")
"""Where a locus of folds stands still and turns back."""

BESIDE_SPECIAL = 1e-6
"""Points of a locus this near to a special point, over the length of the locus, are left out."""


@dataclass(frozen=True, eq=False)
class LocusStretch:
    """A piece of a locus on which the criticality does not change."""

    criticality: str
    """One of `CRITICALITIES`."""
    points: Array
    """The line: values of the two parameters, shape (n, 2)."""


def locus_stretches(locus: Locus) -> tuple[LocusStretch, ...]:
    """Cut a locus where its criticality changes and draw smooth lines between its points.

    Between the points lie cubic splines in the arclength, one from cusp to cusp: there the locus
    stands still in both parameters and turns back. Special points are points of the line.
    """
    knots = _knots(locus)
    closed = locus.closed and len(knots) > 2
    if closed:
        knots = _closed(knots)
    if len(knots) < 2:
        return ()
    lines = _lines(knots, closed)
    found = []
    for kind, first, last in runs(_interval_kinds(locus.type, knots)):
        # Each piece begins where the one before ends.
        points = [line[int(k > first) :] for k, line in enumerate(lines[first:last], start=first)]
        found.append(LocusStretch(kind, np.concatenate(points)))
    return tuple(found)


def _knots(locus: Locus) -> list[Knot]:
    located = [Knot(point.arclength, point.values, _shape(locus, point)) for point in locus.special]
    others = [
        Knot(float(s), tuple(locus.values[i].tolist()), "", _criticality(locus, i))
        for i, s in enumerate(locus.arclength)
    ]
    return arranged(located, others, locus.arclength, BESIDE_SPECIAL)


def _shape(locus: Locus, point: LocusPoint) -> str:
    """Type of a special point; folds that are born at a pitchfork turn back there as at a cusp."""
    return CUSPS[0] if (locus.type, point.type) == ("LP", "DP") else point.type


def _criticality(locus: Locus, index: int) -> str | None:
    if locus.supercritical[index]:
        return SUPERCRITICAL
    return SUBCRITICAL if locus.subcritical[index] else None


def _closed(knots: list[Knot]) -> list[Knot]:
    """Return to the first point, at the pace of the first and the last step."""
    s = np.array([knot.s for knot in knots])
    values = np.array([knot.values for knot in knots])
    size = np.ptp(values, axis=0)
    steps = np.linalg.norm(np.diff(values, axis=0) / np.where(size > 0, size, 1.0), axis=1)
    gap = np.linalg.norm((values[0] - values[-1]) / np.where(size > 0, size, 1.0))
    if gap < BESIDE_SPECIAL:
        return [*knots[:-1], knots[0]._replace(s=float(s[-1]))]
    pace = (s[1] - s[0] + s[-1] - s[-2]) / (steps[0] + steps[-1])
    return [*knots, knots[0]._replace(s=float(s[-1] + gap * pace))]


def _interval_kinds(type_: str, knots: list[Knot]) -> list[str]:
    """Return the criticality of each interval between knots."""
    if type_ not in TURNS:
        return [UNKNOWN] * (len(knots) - 1)
    kinds: list[str] = []
    for i, (left, right) in enumerate(pairwise(knots)):
        known = right.kind if right.kind is not None else left.kind
        if known is None:
            turns = i > 0 and left.type in TURNS[type_]
            known = _other(kinds[-1]) if turns else (kinds[-1] if kinds else UNKNOWN)
        kinds.append(known)
    return _with_beginning(type_, knots, kinds)


def _with_beginning(type_: str, knots: list[Knot], kinds: list[str]) -> list[str]:
    """Fill in what precedes the first point at which the criticality is known."""
    for i in reversed(range(len(kinds) - 1)):
        if kinds[i] == UNKNOWN:
            turns = knots[i + 1].type in TURNS[type_]
            kinds[i] = _other(kinds[i + 1]) if turns else kinds[i + 1]
    return kinds


def _other(kind: str) -> str:
    return {SUPERCRITICAL: SUBCRITICAL, SUBCRITICAL: SUPERCRITICAL}.get(kind, kind)


def _lines(knots: list[Knot], closed: bool) -> list[Array]:
    """Return a line from each knot to the next, in smooth pieces from cusp to cusp."""
    last = len(knots) - 1
    cusps = [i for i in range(1, last) if knots[i].type in CUSPS]
    lines: list[Array] = []
    for start, end in pairwise([0, *cusps, last]):
        piece = knots[start : end + 1]
        spline = _spline(piece, closed and len(piece) == len(knots))
        for a, b in pairwise(piece):
            line = spline(np.linspace(a.s, b.s, PIECES + 1))
            line[[0, -1]] = a.values, b.values
            lines.append(line)
    return lines


def _spline(knots: list[Knot], closed: bool) -> Callable[[Array], Array]:
    from scipy.interpolate import CubicSpline  # half a second to import, for those who draw alone

    s, values = np.array([knot.s for knot in knots]), np.array([knot.values for knot in knots])
    if closed and knots[0].type not in CUSPS:
        return CubicSpline(s, values, bc_type="periodic")
    ends = [_end_condition(knots[end].type, len(s)) for end in (0, -1)]
    return CubicSpline(s, values, bc_type=ends)


def _end_condition(type_: str, count: int) -> Any:
    """Return how a spline ends: still at a cusp; straight if it has too few points to bend."""
    if type_ in CUSPS:
        return 1, np.zeros(2)
    return "not-a-knot" if count > 3 else (2, np.zeros(2))
