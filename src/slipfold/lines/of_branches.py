"""Branches as lines: smooth stretches of one stability each, that meet at the special points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from slipfold.branches.branch import Branch
from slipfold.branches.special_point import BIFURCATIONS
from slipfold.branches.stability import stability_stretches
from slipfold.errors import InputError
from slipfold.orbits.extrema import Extrema

__all__ = ["KINDS", "MEASURES", "Stretch", "measure_of", "stretches_of"]

Array = NDArray[np.float64]

MEASURES = ("max", "min", "peak_to_peak", "modulus")
"""What a figure may show of an output over an orbit."""

PIECES = 8
"""Straight pieces drawn between neighbouring points of a branch."""

KINDS = STABLE, DOUBLED, OTHER = ("stable", "period doubling", "fold or torus")
"""How an orbit stands: stable, or unstable by what."""

BORN, CLOSED = "born", "closed"
"""Kinds of ends of a branch that lie on its parent."""

CLOSE = 1e-5
"""Branch points this near to a special point, over the length of the branch, are left out."""


@dataclass(frozen=True, eq=False)
class Stretch:
    """A piece of a branch on which the stability does not change.

    Parameters
    ----------
    kind
        One of `KINDS`.
    arclength, parameter, value
        The line, each of shape (n,).
    """

    kind: str
    arclength: Array
    parameter: Array
    value: Array


def measure_of(extrema: Extrema, output: str, measure: str) -> Array:
    """Return what a figure shows of an output, shape (n_orbits,)."""
    if output not in extrema.names:
        raise InputError(f"output {output!r} is unknown; give one of {', '.join(extrema.names)}")
    if measure not in MEASURES:
        raise InputError(f"measure {measure!r} is unknown; give one of {', '.join(MEASURES)}")
    if measure == "peak_to_peak":
        return extrema.peak_to_peak(output)
    if measure == "modulus":
        return extrema.modulus(output)
    low, high = extrema.of(output)
    return high if measure == "max" else low


def stretches_of(branch: Branch, output: str, measure: str = "max") -> tuple[Stretch, ...]:
    """Cut a branch at its bifurcations and draw smooth lines between them.

    Notes
    -----
    Between the points lies a cubic spline in the arclength. With the default steps it is within
    1e-3 of the span and of the range of the output; a test compares it with finer steps.
    """
    knots = _knots(branch, output, measure)
    if len(knots.s) < 2:
        return ()
    kinds = _interval_kinds(branch, knots.s)
    parameter, value = _splines(knots)
    result: list[Stretch] = []
    first = 0
    for i in range(1, len(kinds) + 1):
        if i < len(kinds) and kinds[i] == kinds[first]:
            continue
        s = _dense(knots.s[first : i + 1])
        result.append(Stretch(kinds[first], s, parameter(s), value(s)))
        first = i
    return tuple(result)


@dataclass(frozen=True, eq=False)
class _Knots:
    """Points a line goes through."""

    s: Array
    parameter: Array
    value: Array
    types: tuple[str, ...]


def _knots(branch: Branch, output: str, measure: str) -> _Knots:
    # Rows: arclength, parameter, value, type. A special point replaces a branch point at
    # the same place: its value is located.
    rows: list[tuple[float, float, float, str]] = []
    special = [item for item in branch.special if item.type in BIFURCATIONS]
    for item in special:
        value = measure_of(item.orbit.extrema_of(output), output, measure)[0]
        rows.append((item.arclength, item.value, float(value), item.type))
    taken = np.array([item.arclength for item in special])
    near = CLOSE * float(np.ptp(branch.arclength)) if len(branch) else 0.0
    values = measure_of(branch.extrema_of(output), output, measure)
    last = len(branch) - 1
    for i, s in enumerate(branch.arclength):
        if taken.size and np.min(np.abs(taken - s)) <= near:
            continue
        # A doubled branch begins, and may end, on its parent, where a multiplier is one.
        on_parent = (i == 0 and branch.begun.kind == BORN) or (
            i == last and branch.stopped.kind == CLOSED
        )
        type_ = BORN if on_parent else ""
        rows.append((float(s), float(branch.parameter[i]), float(values[i]), type_))
    rows = sorted((row for row in rows if np.isfinite(row[:3]).all()), key=lambda row: row[0])
    rows = [row for i, row in enumerate(rows) if i == 0 or row[0] > rows[i - 1][0]]
    s, parameter, value_column, types = zip(*rows, strict=True) if rows else ((),) * 4
    return _Knots(np.array(s), np.array(parameter), np.array(value_column), types)


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


def _splines(knots: _Knots) -> tuple[CubicSpline, CubicSpline]:
    """Interpolate parameter and value in the arclength."""
    # A doubled branch leaves its parent across the parameter, which stands still there.
    ends = [(1, 0.0) if knots.types[end] == BORN else "not-a-knot" for end in (0, -1)]
    if len(knots.s) == 2:
        ends = [(2, 0.0), (2, 0.0)]
    return CubicSpline(knots.s, knots.parameter, bc_type=ends), CubicSpline(knots.s, knots.value)


def _dense(s: Array) -> Array:
    fractions = np.arange(PIECES) / PIECES
    inner = s[:-1, None] + np.diff(s)[:, None] * fractions
    return np.append(inner.ravel(), s[-1])
