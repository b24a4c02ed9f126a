"""Branches, loci and tori as smooth lines, cut where their stability or criticality changes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from typing import Any, NamedTuple

import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.bifurcations.branches.stability import stability_intervals
from slipfold.bifurcations.loci.locus import Locus
from slipfold.bifurcations.tori.torus_branch import TorusBranch
from slipfold.errors import InputError
from slipfold.flow.trajectory import MEASURES
from slipfold.models.levels import quantity_of, reference_of
from slipfold.models.model import Model
from slipfold.orbits.bifurcation_types import POINT_TYPES, REQUESTED_TYPES
from slipfold.orbits.extrema import AVERAGED, Extrema, find_extrema
from slipfold.orbits.periodic_orbit import measured_of

MAX_AND_MIN = "max_and_min"
"""The first two together, a line each: figures of responses show them."""

LEVEL = "level"
"""What it shows in dB, re that of ISO 1683; or ``level re 1 um``."""

STUCK = "stuck_fraction"
"""What it may show of its contacts instead, whatever the output."""

PIECES = 12
"""Straight pieces drawn between neighboring points of a curve."""

KINDS = STABLE, DOUBLED, OTHER = ("stable", "period doubling", "fold or torus")
"""Stability of an orbit, and by what it is lost."""

SUPERCRITICAL, SUBCRITICAL, UNKNOWN = CRITICALITIES = ("supercritical", "subcritical", "")
"""What may happen beyond a bifurcation; empty where it is not defined, as for a fold."""

BIFURCATION, CLOSED = "bifurcation", "closed"
"""Kinds of ends of a branch that lie on its parent."""

CUSPS = ("CPC", "CP")
"""Where a locus of folds stops in both parameters and turns back."""

NEAR_SPECIAL = 1e-5
"""Points this near to a special point, over the length of the curve, are left out."""


class Knot(NamedTuple):
    """A point of a line."""

    s: float  # arclength
    values: tuple[float, float]
    type: str = ""
    kind: str | None = None  # of the curve there, where it is known


@dataclass(frozen=True, eq=False)
class Segment:
    """A piece of a curve along which its kind does not change."""

    kind: str
    """Of a branch or of tori one of `KINDS`, of a locus one of `CRITICALITIES`."""
    arclength: Array
    """Arclength of its points, shape (n,)."""
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


def parts_of(measure: str) -> tuple[str, ...]:
    """Return the measures that a figure draws together.

    >>> parts_of("max_and_min"), parts_of("rms")
    (('max', 'min'), ('rms',))
    """
    return MEASURES[:2] if measure == MAX_AND_MIN else (measure,)


def measure_of(extrema: Extrema, output: str, measure: str) -> Array:
    """Return what a figure shows of an output, shape (n_orbits,)."""
    if output not in extrema.names:
        raise InputError(f"output {output!r} is unknown; give one of {', '.join(extrema.names)}")
    if measure not in MEASURES:
        names = ", ".join((*MEASURES, MAX_AND_MIN, *AVERAGED, LEVEL, STUCK))
        raise InputError(f"measure {measure!r} is unknown; give one of {names}")
    return extrema.measured(measure, output)


def is_level(measure: str) -> bool:
    """Whether a measure is a level in dB."""
    return measure == LEVEL or measure.startswith(f"{LEVEL} re ")


def _reference(measure: str) -> str | None:
    return measure.removeprefix(LEVEL).removeprefix(" re ") or None


def level_unit(model: Model, output: str, measure: str) -> str:
    """Return the unit of a level: dB and its reference."""
    return f"dB re {reference_of(quantity_of(model, output).unit, _reference(measure)).text}"


def measured_along(branch: Branch, output: str, measure: str) -> Array:
    """Return what a figure shows along a branch, shape (n_points,)."""
    if measure in AVERAGED:
        return measured_of(branch, measure, output)
    if is_level(measure):
        return branch.level(output, _reference(measure))
    if measure != STUCK:
        return measure_of(branch.extrema_of(output), output, measure)
    if branch.stuck_fraction is None:
        return np.zeros(len(branch))
    # Of orbits along which contacts always slip it is NaN.
    return np.nan_to_num(branch.stuck_fraction)


def check_measure(branches: Iterable[Branch], measure: str) -> None:
    """Refuse a fraction of sticking where no contact of any branch sticks."""
    if measure == STUCK and all(branch.stuck_fraction is None for branch in branches):
        raise InputError(f"no orbit sticks, so there is no {STUCK} to show; give another measure")


def measured_at(point: SpecialPoint, output: str, measure: str) -> float:
    """Return what a figure shows at a special point."""
    if measure == STUCK:
        return float(np.nan_to_num(point.stuck_fraction))
    if measure in AVERAGED:
        return float(measured_of(point.orbit, measure, output)[0])
    if is_level(measure):
        return point.orbit.level(output, _reference(measure))
    return float(measure_of(point.orbit.extrema_of(output), output, measure)[0])


def branch_segments(branch: Branch, output: str, measure: str = "max") -> tuple[Segment, ...]:
    """Cut a branch at its bifurcations and draw smooth lines between them.

    Between the points lies a cubic spline in the arclength. With the default steps it is within
    1e-3 of the span and of the range of the output; a test compares it with finer steps.
    """
    special = [item for item in branch.special if item.type not in REQUESTED_TYPES]
    along, at = _measured(branch, special, output, measure)
    located = [Knot(i.arclength, (i.value, y), i.type) for i, y in zip(special, at, strict=True)]
    values = np.column_stack([branch.parameter, along])
    knots = _arranged(located, branch.arclength, values)
    # A doubled branch begins, and may end, on its parent, where a multiplier is one.
    on_parent = {0: branch.started.kind == BIFURCATION, -1: branch.stopped.kind == CLOSED}
    for end, lies_on_parent in on_parent.items():
        if knots and lies_on_parent and not knots[end].type:
            knots[end] = knots[end]._replace(type=BIFURCATION)
    s = np.array([knot.s for knot in knots])
    return _cut(_stabilities(branch, s), _pieces(knots, straight=measure == STUCK))


def _measured(
    branch: Branch, special: Sequence[SpecialPoint], output: str, measure: str
) -> tuple[Array, list[float]]:
    """Return what a figure shows along a branch and at special points: of like orbits at once."""
    alike = all(item.nodes.shape == branch.nodes.shape[1:] for item in special)
    together = branch.stuck_fraction is None and alike and "extrema" not in vars(branch)
    if measure not in MEASURES or not together:
        at = [measured_at(item, output, measure) for item in special]
        return measured_along(branch, output, measure), at
    parameters = np.array([*branch.parameters, *(item.model.vector for item in special)])
    nodes = np.array([*branch.nodes, *(item.nodes for item in special)])
    extrema = find_extrema(branch.model, parameters, nodes, branch.period, (output,))
    values = measure_of(extrema, output, measure)
    return values[: len(branch)], values[len(branch) :].tolist()


def _stabilities(branch: Branch, s: Array) -> list[str]:
    """Return the kind of each interval between knots."""
    if len(s) < 2:
        return []
    parts = stability_intervals(branch)
    kinds = [_stability(part.outside) for part in parts]
    ends = np.array([part.end for part in parts[:-1]])
    return [kinds[i] for i in np.searchsorted(ends, 0.5 * (s[1:] + s[:-1]))]


def _stability(outside: Complex) -> str:
    if len(outside) == 0:
        return STABLE
    return DOUBLED if np.any((outside.real < -1) & (outside.imag == 0)) else OTHER


def locus_segments(locus: Locus) -> tuple[Segment, ...]:
    """Cut a locus where its criticality changes and draw smooth lines between its points.

    Between the points lie cubic splines in the arclength, one from cusp to cusp: there the locus
    stops in both parameters and turns back. Special points are points of the line.
    """
    # Folds that emanate from a pitchfork turn back there as at a cusp.
    located = [
        Knot(item.arclength, item.values, CUSPS[0] if item.type == "DP" else item.type)
        if locus.type == "LP"
        else Knot(item.arclength, item.values, item.type)
        for item in locus.special
    ]
    signs = zip(locus.supercritical, locus.subcritical, strict=True)
    kinds = [SUPERCRITICAL if above else SUBCRITICAL if below else None for above, below in signs]
    knots = _arranged(located, locus.arclength, locus.values, kinds)
    closed = locus.closed and len(knots) > 2
    if closed:
        knots = _closed(knots)
    return _cut(_criticalities(locus.type, knots), _pieces(knots, closed=closed))


def _closed(knots: list[Knot]) -> list[Knot]:
    """Return to the first point, with a step in proportion to the first and the last one."""
    s = np.array([knot.s for knot in knots])
    values = np.array([knot.values for knot in knots])
    size = np.ptp(values, axis=0)
    size = np.where(size > 0, size, 1.0)
    steps = np.linalg.norm(np.diff(values, axis=0) / size, axis=1)
    gap = np.linalg.norm((values[0] - values[-1]) / size)
    if gap < NEAR_SPECIAL:
        return [*knots[:-1], knots[0]._replace(s=float(s[-1]))]
    ratio = (s[1] - s[0] + s[-1] - s[-2]) / (steps[0] + steps[-1])
    return [*knots, knots[0]._replace(s=float(s[-1] + gap * ratio))]


def _criticalities(type_: str, knots: list[Knot]) -> list[str]:
    """Return the criticality of each interval between knots."""
    changing = POINT_TYPES[type_].sign_changes
    if not changing:
        return [UNKNOWN] * (len(knots) - 1)
    kinds: list[str] = []
    for i, (left, right) in enumerate(pairwise(knots)):
        known = right.kind if right.kind is not None else left.kind
        if known is None:
            changes = i > 0 and left.type in changing
            known = _other(kinds[-1]) if changes else (kinds[-1] if kinds else UNKNOWN)
        kinds.append(known)
    # What precedes the first point at which the criticality is known follows from it.
    for i in reversed(range(len(kinds) - 1)):
        if kinds[i] == UNKNOWN:
            changes = knots[i + 1].type in changing
            kinds[i] = _other(kinds[i + 1]) if changes else kinds[i + 1]
    return kinds


def _other(kind: str) -> str:
    return {SUPERCRITICAL: SUBCRITICAL, SUBCRITICAL: SUPERCRITICAL}.get(kind, kind)


def torus_segments(tori: TorusBranch, output: str, measure: str = "max") -> tuple[Segment, ...]:
    """Draw lines between tori; none for what contacts do, since tori always slip.

    From the orbit from which they emanate tori grow as the square root of the distance. Further on
    there may be many in one place and few in another, between which no polynomial swings. Across
    circles that were left out there is no line.
    """
    if len(tori) < 2 or measure in (STUCK, *AVERAGED) or is_level(measure):
        return ()
    parameter, value = tori.parameter, measure_of(tori.extrema, output, measure)
    steps = [np.diff(item) / (np.ptp(item) or 1.0) for item in (parameter, value)]
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*steps))])
    fractions = np.linspace(0.0, 1.0, PIECES + 1)
    at = s[:-1, None] + np.diff(s)[:, None] * fractions
    lines = np.stack([at, _grown(parameter, s, at), _grown(value, s, at)], axis=2)
    if tori.parent:
        lines[0, :, 1] = parameter[0] + (parameter[1] - parameter[0]) * fractions**2
    kinds = np.where(tori.stable[1:], STABLE, OTHER)
    gap = ""
    kinds[tori.omitted[:-1] > 0] = gap
    return tuple(line for line in _cut(kinds.tolist(), list(lines)) if line.kind != gap)


def _grown(values: Array, s: Array, at: Array) -> Array:
    """Return values along a line, straight up to the first torus."""
    if len(s) == 2:
        return np.interp(at, s, values)
    from scipy.interpolate import PchipInterpolator  # takes as long to import

    smooth = PchipInterpolator(s[1:], values[1:])
    return np.where(at < s[1], np.interp(at, s, values), smooth(np.maximum(at, s[1])))


def _arranged(
    located: Sequence[Knot],
    arclength: Array,
    values: Array,
    kinds: Sequence[str | None] | None = None,
) -> list[Knot]:
    """Return special points and the other points of a curve in order, each once.

    A special point replaces others near it.
    """
    taken = np.array([knot.s for knot in located])
    near = NEAR_SPECIAL * float(np.ptp(arclength)) if len(arclength) else 0.0
    others = [
        Knot(s, (x, y), "", None if kinds is None else kinds[i])
        for i, (s, (x, y)) in enumerate(zip(arclength.tolist(), values.tolist(), strict=True))
        if not (taken.size and np.min(np.abs(taken - s)) <= near)
    ]
    finite = (knot for knot in (*located, *others) if np.isfinite([knot.s, *knot.values]).all())
    knots = sorted(finite, key=lambda knot: knot.s)
    return [knot for i, knot in enumerate(knots) if i == 0 or knot.s > knots[i - 1].s]


def _pieces(knots: list[Knot], *, straight: bool = False, closed: bool = False) -> list[Array]:
    """Return a line from each knot to the next, smooth from cusp to cusp: arclength and values.

    The second value is interpolated linearly if `straight`, as it has corners.
    """
    last, lines = len(knots) - 1, list[Array]()
    cusps = [i for i in range(1, last) if knots[i].type in CUSPS]
    for first, end in pairwise([0, *cusps, last] if last > 0 else []):
        part = knots[first : end + 1]
        smooth = _splines(part, closed and len(part) == len(knots))
        corners = np.array([(knot.s, *knot.values) for knot in part])
        s = np.linspace(corners[:-1, 0], corners[1:, 0], PIECES + 1, axis=1)
        drawn = np.stack([s, *(spline(s) for spline in smooth)], axis=2)
        if straight:
            drawn[:, :, 2] = np.interp(s, corners[:, 0], corners[:, 2])
        drawn[:, 0, 1:], drawn[:, -1, 1:] = corners[:-1, 1:], corners[1:, 1:]
        lines += list(drawn)
    return lines


def _splines(knots: list[Knot], closed: bool) -> list[Callable[[Array], Array]]:
    """Interpolate both values in the arclength."""
    from scipy.interpolate import CubicSpline  # takes half a second to import, only for drawing

    s, values = np.array([knot.s for knot in knots]), np.array([knot.values for knot in knots])
    if closed and knots[0].type not in CUSPS:
        return [CubicSpline(s, column, bc_type="periodic") for column in values.T]
    return [
        CubicSpline(s, column, bc_type=[_end(knots[end].type, which, len(s)) for end in (0, -1)])
        for which, column in enumerate(values.T)
    ]


def _end(type_: str, which: int, count: int) -> Any:
    """Return how a spline ends: at rest at a cusp, straight if it has too few points to bend.

    A doubled branch leaves its parent at a right angle to the parameter, the first value.
    """
    if type_ in CUSPS or (type_ == BIFURCATION and which == 0 and count > 2):
        return 1, 0.0
    return "not-a-knot" if count > 2 else (2, 0.0)


def _cut(kinds: Sequence[str], lines: Sequence[Array]) -> tuple[Segment, ...]:
    """Join the lines of successive intervals of one kind."""
    result, first = list[Segment](), 0
    for kind, group in groupby(kinds):
        last = first + len(list(group))
        own = [line[int(k > first) :] for k, line in enumerate(lines[first:last], start=first)]
        whole = np.concatenate(own)
        result.append(Segment(kind, whole[:, 0], whole[:, 1:]))
        first = last
    return tuple(result)
