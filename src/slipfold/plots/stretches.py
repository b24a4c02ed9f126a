"""Branches as lines: smooth stretches of one stability each, that meet at the special points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import Akima1DInterpolator, CubicHermiteSpline

from slipfold.branches.branch import Branch
from slipfold.branches.special_point import BIFURCATIONS, SpecialPoint
from slipfold.errors import InputError
from slipfold.orbits.extrema import Extrema
from slipfold.plots.style import KINDS

__all__ = ["MEASURES", "Stretch", "measure_of", "stretches_of"]

Array = NDArray[np.float64]

MEASURES = ("max", "min", "peak_to_peak", "modulus")
"""What a figure may show of an output over an orbit."""

PIECES = 8
"""Straight pieces drawn between neighbouring points of a branch."""

STABLE, DOUBLED, OTHER = KINDS

BORN = "born"


@dataclass(frozen=True, eq=False)
class Stretch:
    """A piece of a branch on which the stability does not change.

    Parameters
    ----------
    kind
        One of `slipfold.plots.style.KINDS`.
    parameter, value
        The line, each of shape (n,).
    """

    kind: str
    parameter: Array
    value: Array


def measure_of(extrema: Extrema, output: str, measure: str) -> Array:
    """Return what a figure shows of an output, shape (n_orbits,).

    Parameters
    ----------
    extrema
        Over the continuous orbits.
    output
        A state or output of the model.
    measure
        ``"max"``, ``"min"``, ``"peak_to_peak"``, or ``"modulus"`` for the largest absolute value.

    Raises
    ------
    InputError
        For an unknown measure or output.
    """
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


def stretches_of(
    branch: Branch, output: str, measure: str = "max", born: SpecialPoint | None = None
) -> tuple[Stretch, ...]:
    """Cut a branch at its bifurcations and draw smooth lines between them.

    Parameters
    ----------
    branch
        The branch.
    output
        A state or output of the model.
    measure
        What to show of it, see `measure_of`.
    born
        The special point of the parent at which the branch begins, if any; the line starts there.

    Returns
    -------
    tuple of Stretch
        In the order of the branch; the last point of one is the first of the next.
    """
    if len(branch) == 0:
        return ()
    knots = _knots(branch, output, measure, born)
    if len(knots.s) == 1:
        return (Stretch(knots.kinds[0] or STABLE, knots.parameter, knots.value),)
    kinds = _interval_kinds(knots)
    curve = _curve(knots)
    result: list[Stretch] = []
    first = 0
    for i in range(1, len(kinds) + 1):
        if i < len(kinds) and kinds[i] == kinds[first]:
            continue
        s = _dense(knots.s[first : i + 1])
        parameter, value = curve(s).T
        result.append(Stretch(kinds[first], parameter, value))
        first = i
    return tuple(result)


@dataclass(frozen=True, eq=False)
class _Knots:
    """Points a line goes through; the kind is None at a bifurcation."""

    s: Array
    parameter: Array
    value: Array
    kinds: tuple[str | None, ...]
    types: tuple[str, ...]


def _knots(branch: Branch, output: str, measure: str, born: SpecialPoint | None) -> _Knots:
    # Rows: arclength, parameter, value, kind, type. A special point replaces a branch point at
    # the same place: its value is located, and the stability on the boundary is noise.
    rows: list[tuple[float, float, float, str | None, str]] = []
    special = [item for item in branch.special if item.type in (*BIFURCATIONS, "LIMIT")]
    for item in special:
        kind = _kind(item.multipliers) if item.type == "LIMIT" else None
        value = measure_of(item.orbit.extrema, output, measure)[0]
        rows.append((item.arclength, item.value, float(value), kind, item.type))
    taken = np.array([item.arclength for item in special])
    near = 1e-9 * max(float(np.ptp(branch.arclength)), 1e-300)
    values = measure_of(branch.extrema, output, measure)
    for i, s in enumerate(branch.arclength):
        if taken.size and np.min(np.abs(taken - s)) <= near:
            continue
        kind = _kind(branch.multipliers[i])
        rows.append((float(s), float(branch.parameter[i]), float(values[i]), kind, ""))
    rows = [row for row in rows if np.isfinite(row[:3]).all()]
    rows.sort(key=lambda row: row[0])
    if born is not None:
        value = float(measure_of(born.orbit.extrema, output, measure)[0])
        rows = _with_birth(rows, born, value)
    s, parameter, value_column, kinds, types = zip(*rows, strict=True)
    return _Knots(np.array(s), np.array(parameter), np.array(value_column), kinds, types)


def _with_birth(
    rows: list[tuple[float, float, float, str | None, str]], born: SpecialPoint, value: float
) -> list[tuple[float, float, float, str | None, str]]:
    """Begin the line at the bifurcation the branch was born at."""
    birth = (born.value, value)
    head = rows[0]
    if np.allclose(head[1:3], birth, rtol=1e-9, atol=1e-12):
        return [(head[0], *birth, None, BORN), *rows[1:]]
    # The branch's own arclength starts behind the bifurcation: put it the same distance, in the
    # figure, before the first point as the first is before the second.
    following = rows[1] if len(rows) > 1 else head
    ahead = np.hypot(following[1] - head[1], following[2] - head[2]) or 1.0
    behind = np.hypot(head[1] - birth[0], head[2] - birth[1])
    spacing = (following[0] - head[0]) or 1.0
    return [(head[0] - spacing * behind / ahead, *birth, None, BORN), *rows]


def _kind(multipliers: NDArray[np.complex128]) -> str:
    outside = multipliers[np.abs(multipliers) > 1]
    if len(outside) == 0:
        return STABLE
    return DOUBLED if np.any((outside.real < -1) & (outside.imag == 0)) else OTHER


def _interval_kinds(knots: _Knots) -> list[str]:
    """Return the kind of each interval between knots; between bifurcations it follows from them."""
    kinds: list[str] = []
    for left, right, type_ in zip(knots.kinds, knots.kinds[1:], knots.types, strict=False):
        known = right if right is not None else left
        if known is None:
            known = _beyond(kinds[-1] if kinds else STABLE, type_)
        kinds.append(known)
    return kinds


def _beyond(kind: str, type_: str) -> str:
    """Return the kind behind a bifurcation from that before it, where no orbit lies between."""
    if type_ == "PD":
        return STABLE if kind == DOUBLED else DOUBLED
    return STABLE if kind == OTHER else OTHER


def _curve(knots: _Knots) -> CubicHermiteSpline:
    """Interpolate parameter and value in the arclength."""
    points = np.column_stack([knots.parameter, knots.value])
    if len(points) < 3:
        slopes = np.repeat(np.diff(points, axis=0) / np.diff(knots.s)[:, None], 2, axis=0)
    else:
        # Akima's slopes look at neighbours only: a kink, where another hump of the orbit becomes
        # the highest, makes no waves along the line.
        akima = Akima1DInterpolator(knots.s, points, method="makima")
        slopes = akima(knots.s, nu=1)
    # A fold turns back just there; a doubled branch leaves its parent across the parameter.
    turns = [type_ in ("LP", BORN) for type_ in knots.types]
    slopes[turns, 0] = 0.0
    return CubicHermiteSpline(knots.s, points, slopes)


def _dense(s: Array) -> Array:
    fractions = np.arange(PIECES) / PIECES
    inner = s[:-1, None] + np.diff(s)[:, None] * fractions
    return np.append(inner.ravel(), s[-1])
