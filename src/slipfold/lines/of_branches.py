"""Branches as lines: smooth stretches of one stability each, that meet at the special points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.branches.branch import Branch
from slipfold.branches.special_point import SpecialPoint
from slipfold.branches.stability import stability_stretches
from slipfold.errors import InputError
from slipfold.lines.knots import Knot, arranged, runs
from slipfold.orbits.extrema import Extrema

Line = Callable[[Array], Array]

MEASURES = ("max", "min", "peak_to_peak", "modulus")
"""What a figure may show of an output over an orbit."""

STUCK = "stuck_fraction"
"""What it may show of its contacts instead, whatever the output."""

PIECES = 8
"""Straight pieces drawn between neighbouring points of a branch."""

KINDS = STABLE, DOUBLED, OTHER = ("stable", "period doubling", "fold or torus")
"""How an orbit stands: stable, or unstable by what."""

BORN, CLOSED = "born", "closed"
"""Kinds of ends of a branch that lie on its parent."""

BESIDE_BIFURCATION = 1e-5
"""Branch points this near to a special point, over the length of the branch, are left out."""


@dataclass(frozen=True, eq=False)
class Stretch:
    """A piece of a branch on which the stability does not change: a line, each of shape (n,)."""

    kind: str
    """One of `KINDS`."""
    arclength: Array
    parameter: Array
    value: Array


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


def stretches_of(branch: Branch, output: str, measure: str = "max") -> tuple[Stretch, ...]:
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
        lines.append(Stretch(kind, at, parameter(at), value(at)))
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
    return arranged(located, others, branch.arclength, BESIDE_BIFURCATION)


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
