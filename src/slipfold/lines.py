"""Branches, loci and tori as smooth lines, cut where what they mean changes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from slipfold.arrays import Array
from slipfold.branches.branch import Branch
from slipfold.branches.special_point import SpecialPoint
from slipfold.branches.stability import stability_stretches
from slipfold.errors import InputError
from slipfold.loci.locus import Locus, LocusPoint
from slipfold.orbits.extrema import Extrema
from slipfold.tori.torus_branch import TorusBranch


class Knot(NamedTuple):
    """A point of a line: where on it, what is drawn, what it is, how things stand there."""

    s: float
    values: tuple[float, float]
    type: str = ""
    kind: str | None = None


def arranged(
    located: Sequence[Knot], others: Sequence[Knot], arclength: NDArray[np.float64], close: float
) -> list[Knot]:
    """Return all points in order, each once; a located one replaces others near it.

    Near is less than a share `close` of the whole line.
    """
    taken = np.array([knot.s for knot in located])
    near = close * float(np.ptp(arclength)) if len(arclength) else 0.0
    far = [knot for knot in others if not (taken.size and np.min(np.abs(taken - knot.s)) <= near)]
    whole = [knot for knot in (*located, *far) if np.isfinite([knot.s, *knot.values]).all()]
    knots = sorted(whole, key=lambda knot: knot.s)
    return [knot for i, knot in enumerate(knots) if i == 0 or knot.s > knots[i - 1].s]


def runs(kinds: Sequence[str]) -> Iterator[tuple[str, int, int]]:
    """Yield each run of equal kinds with its ends.

    >>> list(runs("aab"))
    [('a', 0, 2), ('b', 2, 3)]
    """
    first = 0
    for kind, group in groupby(kinds):
        last = first + len(list(group))
        yield kind, first, last
        first = last


Line = Callable[[Array], Array]

MEASURES = ("max", "min", "peak_to_peak", "modulus")
"""What a figure may show of an output over an orbit."""

STUCK = "stuck_fraction"
"""What it may show of its contacts instead, whatever the output."""

PIECES = 12
"""Straight pieces drawn between neighboring points of a curve."""

KINDS = STABLE, DOUBLED, OTHER = ("stable", "period doubling", "fold or torus")
"""Stability of an orbit, and by what it is lost."""

BORN, CLOSED = "born", "closed"
"""Kinds of ends of a branch that lie on its parent."""

NEAR_BIFURCATION = 1e-5
"""Branch points this near to a special point, over the length of the branch, are left out."""


@dataclass(frozen=True, eq=False)
class Segment:
    """A piece of a curve along which its kind does not change."""

    kind: str
    """Of a branch or of tori one of `KINDS`, of a locus one of `CRITICALITIES`."""
    arclength: Array
    """Where its points lie on the curve, shape (n,)."""
    points: Array
    """Parameter and what is shown of it, or two parameters, shape (n, 2)."""

    @property
    def parameter(self) -> Array:
        """Values of the first parameter, shape (n,)."""
        return self.points[:, 0]

    @property
    def value(self) -> Array:
        """What is shown, or values of the second parameter, shape (n,)."""
        return self.points[:, 1]


def measure_of(extrema: Extrema, output: str, measure: str) -> Array:
    """Return what a figure shows of an output, shape (n_orbits,)."""
    if output not in extrema.names:
        raise InputError(f"output {output!r} is unknown; give one of {', '.join(extrema.names)}")
    if measure not in MEASURES:
        names = ", ".join((*MEASURES, STUCK))
        raise InputError(f"measure {measure!r} is unknown; give one of {names}")
    if measure == "peak_to_peak":
        return extrema.peak_to_peak(output)
    if measure == "modulus":
        return extrema.modulus(output)
    low, high = extrema.of(output)
    return high if measure == "max" else low


def measured_along(branch: Branch, output: str, measure: str) -> Array:
    """Return what a figure shows along a branch, shape (n_points,)."""
    if measure != STUCK:
        return measure_of(branch.extrema_of(output), output, measure)
    if branch.stuck_fraction is None:
        raise InputError(
            f"no orbit of branch {branch.id} sticks, so it has no {STUCK}; give another measure"
        )
    # What is followed in slip alone has no number.
    return np.nan_to_num(branch.stuck_fraction)


def measured_at(point: SpecialPoint, output: str, measure: str) -> float:
    """Return what a figure shows at a special point."""
    if measure == STUCK:
        return float(np.nan_to_num(point.stuck_fraction))
    return float(measure_of(point.orbit.extrema_of(output), output, measure)[0])


def branch_segments(branch: Branch, output: str, measure: str = "max") -> tuple[Segment, ...]:
    """Cut a branch at its bifurcations and draw smooth lines between them.

    Between the points lies a cubic spline in the arclength. With the default steps it is within
    1e-3 of the span and of the range of the output; a test compares it with finer steps.
    """
    knots = _knots(branch, output, measure)
    if len(knots) < 2:
        return ()
    s = np.array([knot.s for knot in knots])
    parameter, value = _splines(knots, s, straight=measure == STUCK)
    lines = []
    for kind, first, last in runs(_interval_kinds(branch, s)):
        at = _dense(s[first : last + 1])
        lines.append(Segment(kind, at, np.column_stack([parameter(at), value(at)])))
    return tuple(lines)


def _knots(branch: Branch, output: str, measure: str) -> list[Knot]:
    special = [item for item in branch.special if item.type != "EVENT"]
    located = []
    for item in special:
        value = measured_at(item, output, measure)
        located.append(Knot(item.arclength, (item.value, value), item.type))
    values = measured_along(branch, output, measure)
    # A doubled branch begins, and may end, on its parent, where a multiplier is one.
    begun, closed = branch.begun.kind == BORN, branch.stopped.kind == CLOSED
    on_parent = {index for index, is_one in ((0, begun), (len(branch) - 1, closed)) if is_one}
    others = [
        Knot(float(s), (float(branch.parameter[i]), float(values[i])), BORN * (i in on_parent))
        for i, s in enumerate(branch.arclength)
    ]
    return arranged(located, others, branch.arclength, NEAR_BIFURCATION)


def _kind(outside: NDArray[np.complex128]) -> str:
    if len(outside) == 0:
        return STABLE
    return DOUBLED if np.any((outside.real < -1) & (outside.imag == 0)) else OTHER


def _interval_kinds(branch: Branch, s: Array) -> list[str]:
    """Return the kind of each interval between knots."""
    stretches = stability_stretches(branch)
    kinds = [_kind(stretch.outside) for stretch in stretches]
    ends = np.array([stretch.end for stretch in stretches[:-1]])
    return [kinds[i] for i in np.searchsorted(ends, 0.5 * (s[1:] + s[:-1]))]


def _splines(knots: Sequence[Knot], s: Array, *, straight: bool) -> tuple[Line, Line]:
    """Interpolate parameter and value in the arclength, a value with corners straight."""
    from scipy.interpolate import CubicSpline  # half a second to import, for those who draw alone

    # A doubled branch leaves its parent across the parameter, which stands still there.
    ends = [(1, 0.0) if knots[end].type == BORN else "not-a-knot" for end in (0, -1)]
    if len(s) == 2:
        ends = [(2, 0.0), (2, 0.0)]
    parameter, value = np.array([knot.values for knot in knots]).T
    smooth = CubicSpline(s, parameter, bc_type=ends)
    if straight:
        return smooth, lambda at: np.asarray(np.interp(at, s, value))
    return smooth, CubicSpline(s, value)


def _dense(s: Array) -> Array:
    fractions = np.arange(PIECES) / PIECES
    inner = s[:-1, None] + np.diff(s)[:, None] * fractions
    return np.append(inner.ravel(), s[-1])


SUPERCRITICAL, SUBCRITICAL, UNKNOWN = CRITICALITIES = ("supercritical", "subcritical", "")
"""What may happen beyond a bifurcation; empty where it is not defined, as for a fold."""

TURNS = {
    "PD": ("GPD", "LPPD", "R2"),
    "NS": ("CH", "LPNS"),
    "BP": ("DP", "R1", "BT"),
    "HB": ("GH", "ZH"),
}
"""Where the coefficient of a normal form has a zero or a pole, and so changes its sign."""

CUSPS = ("CPC", "CP")
"""Where a locus of folds stands still and turns back."""

NEAR_SPECIAL = 1e-6
"""Points of a locus this near to a special point, over the length of the locus, are left out."""


def locus_segments(locus: Locus) -> tuple[Segment, ...]:
    """Cut a locus where its criticality changes and draw smooth lines between its points.

    Between the points lie cubic splines in the arclength, one from cusp to cusp: there the locus
    stands still in both parameters and turns back. Special points are points of the line.
    """
    knots = _locus_knots(locus)
    closed = locus.closed and len(knots) > 2
    if closed:
        knots = _closed(knots)
    if len(knots) < 2:
        return ()
    lines = _lines(knots, closed)
    found = []
    for kind, first, last in runs(_criticalities(locus.type, knots)):
        # Each piece begins where the one before ends.
        own = [line[int(k > first) :] for k, line in enumerate(lines[first:last], start=first)]
        s, *points = np.concatenate(own).T
        found.append(Segment(kind, s, np.column_stack(points)))
    return tuple(found)


def _locus_knots(locus: Locus) -> list[Knot]:
    located = [Knot(point.arclength, point.values, _shape(locus, point)) for point in locus.special]
    others = [
        Knot(float(s), tuple(locus.values[i].tolist()), "", _criticality(locus, i))
        for i, s in enumerate(locus.arclength)
    ]
    return arranged(located, others, locus.arclength, NEAR_SPECIAL)


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
    if gap < NEAR_SPECIAL:
        return [*knots[:-1], knots[0]._replace(s=float(s[-1]))]
    pace = (s[1] - s[0] + s[-1] - s[-2]) / (steps[0] + steps[-1])
    return [*knots, knots[0]._replace(s=float(s[-1] + gap * pace))]


def _criticalities(type_: str, knots: list[Knot]) -> list[str]:
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
    """Return a line from each knot to the next, smooth from cusp to cusp: arclength and values."""
    last = len(knots) - 1
    cusps = [i for i in range(1, last) if knots[i].type in CUSPS]
    lines: list[Array] = []
    for start, end in pairwise([0, *cusps, last]):
        piece = knots[start : end + 1]
        spline = _spline(piece, closed and len(piece) == len(knots))
        for a, b in pairwise(piece):
            s = np.linspace(a.s, b.s, PIECES + 1)
            line = spline(s)
            line[[0, -1]] = a.values, b.values
            lines.append(np.column_stack([s, line]))
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


GAP = ""
"""Kind of a segment that is not drawn."""


def torus_segments(tori: TorusBranch, output: str, measure: str = "max") -> tuple[Segment, ...]:
    """Draw lines between tori; none for what contacts do, since tori always slip.

    From the orbit that they are born from tori grow as the square root of the distance. Further on
    there may be many in one place and few in another, between which no polynomial swings. Across
    circles that were left out there is no line.
    """
    if len(tori) < 2 or measure == STUCK:
        return ()
    parameter, value = tori.parameter, measure_of(tori.extrema, output, measure)
    steps = [np.diff(item) / (np.ptp(item) or 1.0) for item in (parameter, value)]
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*steps))])
    places = np.arange(PIECES * (len(s) - 1) + 1) / PIECES
    at = np.interp(places, np.arange(len(s)), s)
    along, reached = (_grown(item, s, at) for item in (parameter, value))
    if tori.parent:
        along[: PIECES + 1] = (
            parameter[0] + (parameter[1] - parameter[0]) * places[: PIECES + 1] ** 2
        )
    kinds = np.where(tori.stable[1:], STABLE, OTHER)
    kinds[tori.omitted[:-1] > 0] = GAP
    lines = []
    for kind, first, last in runs(kinds.tolist()):
        if kind == GAP:
            continue
        part = slice(PIECES * first, PIECES * last + 1)
        points = np.column_stack([along[part], reached[part]])
        lines.append(Segment(kind, at[part], points))
    return tuple(lines)


def _grown(values: Array, s: Array, at: Array) -> Array:
    """Return values along a line, straight up to the first torus."""
    if len(s) == 2:
        return np.interp(at, s, values)
    smooth = PchipInterpolator(s[1:], values[1:])
    return np.where(at < s[1], np.interp(at, s, values), smooth(np.maximum(at, s[1])))
