"""A locus as data."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Annotated

import numpy as np

from slipfold.arrays import Array, Complex, Mask
from slipfold.bifurcations.branches.solution_curve import LocatedPoint, OrbitSeries
from slipfold.models.model import evaluation_of
from slipfold.orbits.bifurcation_types import CODIMENSION_TWO, POINT_TYPES
from slipfold.orbits.eigenvalues import eigenvalues_of
from slipfold.orbits.normal_forms.normal_form import criticality_of
from slipfold.text import kind_text, listed, parameter_text

IMAGINARY = 1e-8
"""Real part of a pair on the imaginary axis, over the largest eigenvalue, that is rounding."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class LocusPoint(LocatedPoint):
    """A special point of a locus; frozen."""

    type: Annotated[
        str,
        'One of `CODIMENSION_TWO`, or ``"MIN"`` and ``"MAX"`` where the locus turns in a '
        "parameter, or the quantity of extrema does along it, or "
        '``"GRAZE"``, ``"STICK"``, ``"LIFT"``, ``"MEET"`` where contacts begin or cease to do '
        "something.",
    ]
    name: Annotated[str, 'The type in words, e.g. ``"smallest Nd"``.']
    vary: Annotated[tuple[str, str], "Names of the parameters followed."]
    values: Annotated[tuple[float, float], "Their values."]
    uncertainty: Annotated[
        tuple[float, float],
        "Computed uncertainty of both: how much they move when the orbit and its derivatives are "
        "integrated again with other steps (same units). Infinite where nothing is known, NaN "
        "where the computation was interrupted before.",
    ]
    coefficients: Annotated[
        dict[str, float], "Normal form coefficients by name, where they are defined."
    ]
    leads_to: Annotated[tuple[int, ...], "Ids of the loci that were started here."] = ()
    kind: Annotated[str, '``"periodic"`` or ``"equilibrium"``.'] = "periodic"
    measured: Annotated[float, "Value of the quantity of a locus of extrema; NaN: another."] = (
        math.nan
    )

    def _numbers(self) -> Mapping[str, float | None]:
        pairs = zip(self.vary, self.uncertainty, strict=True)
        return {**self.coefficients} | {f"uncertainty of {name}": value for name, value in pairs}

    @property
    def _values(self) -> tuple[float, float]:
        return self.values

    @property
    def outcome(self) -> str:
        """What it is in words, and which loci were started here."""
        numbers = ", ".join(map(str, self.leads_to))
        started = f"to {'locus' if len(self.leads_to) == 1 else 'loci'} {numbers}"
        return ", ".join([self.name, *([started] if numbers else [])])

    @property
    def duration(self) -> float:
        """Period of the orbit in seconds; at a Hopf point, that of the emanating cycles."""
        return self.orbit.duration if self.eigenvalues is None else hopf_duration(self.eigenvalues)

    @cached_property
    def eigenvalues(self) -> Complex | None:
        """Of an equilibrium in 1/s, largest real part first; None for an orbit."""
        if self.kind != "equilibrium":
            return None
        return eigenvalues_of(evaluation_of(self.model).jacobian(self.model, self.state))


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Locus(OrbitSeries):
    """Orbits at a bifurcation, followed in two parameters; frozen, one row a point."""

    type: Annotated[
        str,
        '``"LP"``, ``"PD"``, ``"NS"`` or ``"BP"``; of equilibria ``"LP"``, ``"BP"`` or '
        '``"HB"``; of orbits at which contacts begin or cease to do something ``"GRAZE"``, '
        '``"STICK"`` or ``"LIFT"``; '
        'of extrema ``"MAX"`` or ``"MIN"``.',
    ]
    quantity: Annotated[
        str, 'What is measured on a locus of extrema, as in ``"max x"``; empty of all others.'
    ] = ""
    measured: Annotated[
        Array | None, "Its values, shape (n_points,), in the unit of the output; None of others."
    ] = None
    parent: Annotated[
        int | None, "Id of the locus at whose point of codimension two it was started, or None."
    ]
    vary: Annotated[tuple[str, str], "Names of the parameters."]
    values: Annotated[Array, "Their values, shape (n_points, 2)."]
    coefficient: Annotated[
        Array,
        "Coefficient of the bifurcation's normal form at each point, shape (n_points,): cubic b of "
        "PD, real part d of NS, cubic c of a pitchfork, first Lyapunov coefficient l1 of HB; NaN "
        "for LP, for transcritical branch points and where it is not defined.",
    ]

    @property
    def _values(self) -> Array:
        return self.values

    def _line(self) -> str:
        parts = [self.heading, f"{len(self)} points"]
        if len(self):
            for name, column in zip(self.vary, self.values.T, strict=True):
                ends = (float(column.min()), float(column.max()))
                parts.append(parameter_text(self.model.parameter(name), *ends))
        parts.append(listed(point.type for point in self.special))
        found = ", ".join(part for part in [*parts, self.stopped.kind] if part)
        return f"Locus {self.id} of {self.model.name}: {found}"

    @property
    def heading(self) -> str:
        """What it is a locus of, e.g. ``"PD of period 2"``."""
        return locus_title(self.type, self.period, self.kind, self.model.forced, self.quantity)

    @cached_property
    def criticality(self) -> list[str | None]:
        """Whether the bifurcation is super- or subcritical at each point."""
        return [self._judged(float(value)) for value in self.coefficient]

    def criticality_at(self, point: LocusPoint) -> str | None:
        """Return whether the bifurcation is super- or subcritical at an extremum of the locus.

        Parameters
        ----------
        point
            A special point of the locus.
        """
        name = POINT_TYPES[self.type].coefficient
        if point.type in CODIMENSION_TWO or name not in point.coefficients:
            return None
        return self._judged(point.coefficients[name])

    def _cycle_durations(self) -> Array | list[float] | None:
        """Periods of the orbits in seconds; of Hopf points, those of the cycles from there."""
        if self.model.forced:
            return None
        if self.durations is not None:
            return self.period * self.durations
        return [] if self.eigenvalues is None else [hopf_duration(v) for v in self.eigenvalues]

    def _judged(self, coefficient: float) -> str | None:
        """Judge a coefficient relative to the others, whatever the units of the states."""
        size = float(np.nan_to_num(np.abs(self.coefficient)).max(initial=0.0))
        return criticality_of(self.type, coefficient / (size or 1.0))

    @property
    def supercritical(self) -> Mask:
        """Whether the bifurcation is supercritical at each point, shape (n_points,)."""
        return self.coefficient * POINT_TYPES[self.type].soft > 0

    @property
    def subcritical(self) -> Mask:
        """Whether the bifurcation is subcritical at each point, shape (n_points,)."""
        return self.coefficient * POINT_TYPES[self.type].soft < 0

    @property
    def closed(self) -> bool:
        """Whether the locus closed on itself."""
        return self.stopped.kind == "closed"


def hopf_duration(eigenvalues: Complex) -> float:
    """Return the period of the cycles that emanate at a Hopf point; NaN where no pair is imaginary.

    Shapes: eigenvalues (n,).

    >>> round(hopf_duration(np.array([2j, -2j, -1])), 12)
    3.14159265359
    """
    upper = eigenvalues[eigenvalues.imag > 0]
    if not len(upper):
        return np.nan
    nearest = upper[np.abs(upper.real).argmin()]
    on_axis = abs(nearest.real) < IMAGINARY * np.abs(eigenvalues).max()
    return 2 * np.pi / float(nearest.imag) if on_axis else np.nan


def locus_title(type_: str, period: int, kind: str, forced: bool, quantity: str = "") -> str:
    """Return e.g. ``"PD of period 2"``, ``"HB of equilibria"`` or ``"largest max x of period 1"``.

    >>> locus_title("PD", 2, "periodic", forced=False)
    'PD of cycles of period 2'
    """
    of = kind_text(kind, period, forced)
    return f"{POINT_TYPES[type_].title} {quantity} of {of}" if quantity else f"{type_} of {of}"


PIECES = 12
"""Straight pieces between neighboring points."""


def lines_between(locus: Locus) -> list[Array]:
    """Return the smooth line from each point of a locus to the next, of shape (k, 2).

    In the arclength of all unknowns the parameters are smooth even at a cusp of the locus.
    """
    from scipy.interpolate import CubicSpline

    if len(locus) < 2:
        return []
    curve = CubicSpline(locus.arclength, locus.values)
    return [curve(np.linspace(*ends, PIECES + 1)) for ends in pairwise(locus.arclength)]
