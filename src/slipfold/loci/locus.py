"""A locus as data."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.continuation.end import End
from slipfold.models.model import Model, evaluation_of
from slipfold.orbits.eigenvalues import eigenvalues_of
from slipfold.orbits.periodic_orbit import PeriodicOrbit, StickSlipOrbit
from slipfold.read_only import ReadOnly
from slipfold.text.one_line import OneLine, certain, headed, listed, number_text, parameter_text
from slipfold.text.printed_table import PrintedTable

Multipliers = NDArray[np.complex128]

CODIMENSION_TWO = {
    "CPC": "cusp of cycles",
    "GPD": "generalized period doubling",
    "CH": "Chenciner",
    "R1": "1:1 resonance",
    "R2": "1:2 resonance",
    "R3": "1:3 resonance",
    "R4": "1:4 resonance",
    "DP": "degenerate pitchfork",
    "LPPD": "fold-flip",
    "LPNS": "fold and Neimark-Sacker",
    "PDNS": "flip and Neimark-Sacker",
    "NSNS": "double Neimark-Sacker",
    "BPPD": "branch point and flip",
    "BPNS": "branch point and Neimark-Sacker",
    "CP": "cusp",
    "BT": "Bogdanov-Takens",
    "GH": "generalized Hopf (Bautin)",
    "ZH": "zero-Hopf",
    "HH": "double Hopf",
}
"""Types of points of codimension two, with their names; the last five are those of equilibria."""

COEFFICIENT = {"PD": "b", "NS": "d", "BP": "c", "HB": "l1"}
"""Name of the coefficient whose sign is the criticality, by type of locus."""


IMAGINARY = 1e-8
"""Real part of a pair on the imaginary axis, over the largest eigenvalue, that is rounding."""


LocusEnd = End
"""Why a locus begins or ends where it does: its `values` are those of both parameters."""


@dataclass(frozen=True, eq=False, repr=False)
class LocusPoint(OneLine, ReadOnly):
    """A special point of a locus; frozen.

    Parameters
    ----------
    type
        One of `CODIMENSION_TWO`, or ``"MIN"`` and ``"MAX"`` where the locus turns in a parameter,
        or ``"GRAZE"``, ``"STICK"``, ``"LIFT"``, ``"MEET"`` where contacts begin or cease to do
        something.
    name
        The type in words, e.g. ``"smallest Nd"``.
    model
        The model with the parameter values of the point; of a cycle also with its duration.
    vary
        Names of the parameters followed.
    values
        Their values.
    uncertainty
        Computed uncertainty of both: how much they move when the orbit and its derivatives are
        integrated again with other steps (same units). Infinite where nothing is known, NaN where
        the computation was interrupted before.
    period
        Period in forcing periods.
    nodes
        States of the orbit, shape (m, n_states).
    multipliers
        Floquet multipliers, complex, shape (n_states,), largest modulus first; of an equilibrium,
        those of the flow over the model's ``duration``.
    residual
        How far the orbit fails to close, in scaled states.
    arclength
        Position on the locus.
    coefficients
        Normal form coefficients by name, where they are defined.
    leads_to
        Ids of the loci that were started here.
    kind
        ``"periodic"`` or ``"equilibrium"``.
    stuck_fraction
        Share of the period in which a contact sticks; NaN of an orbit along which contacts slip
        in one direction all the time.
    """

    type: str
    name: str
    model: Model
    vary: tuple[str, str]
    values: tuple[float, float]
    uncertainty: tuple[float, float]
    period: int
    nodes: Array
    multipliers: Multipliers
    residual: float
    arclength: float
    coefficients: dict[str, float]
    leads_to: tuple[int, ...] = ()
    kind: str = "periodic"
    stuck_fraction: float = np.nan

    def _line(self) -> str:
        pairs = zip(self.vary, self.certain_values, strict=True)
        at = ", ".join(parameter_text(self.model.parameter(name), value) for name, value in pairs)
        return ", ".join(part for part in (f"{self.type} at {at}", self.outcome) if part)

    def _rows(self) -> PrintedTable:
        named = {**self.coefficients}
        for name, value in zip(self.vary, self.uncertainty, strict=True):
            named[f"uncertainty of {name}"] = value
        found = [[name, number_text(value)] for name, value in named.items()]
        return PrintedTable(["", ""], [*found, *self.orbit._rows().lines])

    @property
    def certain_values(self) -> tuple[float, float]:
        """The values, zero where they are no further from zero than they are uncertain."""
        first, second = map(certain, self.values, self.uncertainty)
        return first, second

    @property
    def outcome(self) -> str:
        """What it is in words, and which loci were started here."""
        numbers = ", ".join(map(str, self.leads_to))
        started = f"to {'locus' if len(self.leads_to) == 1 else 'loci'} {numbers}"
        return ", ".join([self.name, *([started] if numbers else [])])

    @property
    def state(self) -> Array:
        """State at phase zero, shape (n_states,)."""
        return self.nodes[0]

    @property
    def duration(self) -> float:
        """Period of the orbit in seconds; at a Hopf point, that of the cycles born there."""
        return self.orbit.duration if self.eigenvalues is None else hopf_duration(self.eigenvalues)

    @cached_property
    def orbit(self) -> PeriodicOrbit:
        """The periodic orbit at this point."""
        kind = PeriodicOrbit if np.isnan(self.stuck_fraction) else StickSlipOrbit
        return kind(self.model, self.period, self.nodes, self.multipliers, self.residual)

    @cached_property
    def eigenvalues(self) -> Multipliers | None:
        """Of an equilibrium in 1/s, largest real part first; None for an orbit."""
        if self.kind != "equilibrium":
            return None
        return eigenvalues_of(evaluation_of(self.model).jacobian(self.model, self.state))


@dataclass(frozen=True, eq=False, repr=False)
class Locus(OneLine, ReadOnly):
    """Orbits at a bifurcation, followed in two parameters; frozen, one row a point.

    Parameters
    ----------
    id
        Number within the result, from 1.
    type
        ``"LP"``, ``"PD"``, ``"NS"`` or ``"BP"``; of equilibria ``"LP"``, ``"BP"`` or ``"HB"``; of
        orbits at which contacts begin or cease to do something ``"GRAZE"``, ``"STICK"`` or
        ``"LIFT"``.
    period
        Period in forcing periods; of an autonomous model, in rounds.
    parent
        Id of the locus at whose point of codimension two it was started, or None.
    model
        The model; the values of `vary` are replaced by `values`.
    vary
        Names of the parameters.
    values
        Their values, shape (n_points, 2).
    nodes
        Orbits, shape (n_points, m, n_states).
    multipliers
        Floquet multipliers, complex, shape (n_points, n_states), largest modulus first; of
        equilibria, those of the flow over the model's ``duration``.
    coefficient
        Coefficient of the bifurcation's normal form at each point, shape (n_points,): cubic b of
        PD, real part d of NS, cubic c of a pitchfork, first Lyapunov coefficient l1 of HB; NaN for
        LP, for transcritical branch points and where it is not defined.
    residual
        How far each orbit fails to close, in scaled states, shape (n_points,).
    arclength
        Arclength along the locus in scaled variables, shape (n_points,).
    special
        Points of codimension two and extrema, in the order of the locus.
    begun, stopped
        Why it begins and ends where it does.
    kind
        ``"periodic"`` or ``"equilibrium"``.
    durations
        Durations of one round of each cycle of an autonomous model, in seconds, shape (n_points,);
        None where the model's parameters give the period.
    stuck_fraction
        Share of the period in which a contact sticks, shape (n_points,); None where contacts slip
        in one direction all the time.
    """

    id: int
    type: str
    period: int
    parent: int | None
    model: Model
    vary: tuple[str, str]
    values: Array
    nodes: Array
    multipliers: Multipliers
    coefficient: Array
    residual: Array
    arclength: Array
    special: tuple[LocusPoint, ...]
    begun: End
    stopped: End
    kind: str = "periodic"
    durations: Array | None = None
    stuck_fraction: Array | None = None

    def __len__(self) -> int:
        """Number of points."""
        return len(self.values)

    def _line(self) -> str:
        parts = [locus_title(self.type, self.period, self.kind), f"{len(self)} points"]
        if len(self):
            for name, column in zip(self.vary, self.values.T, strict=True):
                ends = (float(column.min()), float(column.max()))
                parts.append(parameter_text(self.model.parameter(name), *ends))
        parts.append(listed(point.type for point in self.special))
        found = ", ".join(part for part in [*parts, self.stopped.kind] if part)
        return f"Locus {self.id} of {self.model.name}: {found}"

    def _rows(self) -> PrintedTable:
        begun, stopped = (
            [end.kind, *map(number_text, end.values), end.reason]
            for end in (self.begun, self.stopped)
        )
        found = [
            [p.type, *(number_text(value, 10) for value in p.values), p.outcome]
            for p in self.special
        ]
        heads = ["", *(headed(self.model.parameter(name)) for name in self.vary), "what"]
        return PrintedTable(heads, [begun, *found, stopped], ("", "what"))

    @property
    def states(self) -> Array:
        """States at phase zero, shape (n_points, n_states)."""
        return self.nodes[:, 0]

    @property
    def supercritical(self) -> NDArray[np.bool_]:
        """Whether the bifurcation is supercritical at each point, shape (n_points,)."""
        return self.coefficient > 0 if self.type == "PD" else self.coefficient < 0

    @property
    def subcritical(self) -> NDArray[np.bool_]:
        """Whether the bifurcation is subcritical at each point, shape (n_points,)."""
        return self.coefficient < 0 if self.type == "PD" else self.coefficient > 0

    @property
    def interrupted(self) -> bool:
        """Whether the computation was interrupted on this locus."""
        return "interrupted" in (self.begun.kind, self.stopped.kind)

    @property
    def closed(self) -> bool:
        """Whether the locus closed on itself."""
        return self.stopped.kind == "closed"

    def model_at(self, index: int) -> Model:
        """Return the model with the parameter values of one point.

        Parameters
        ----------
        index
            Row of the locus.
        """
        changes = dict(zip(self.vary, map(float, self.values[index]), strict=True))
        if self.durations is not None:
            changes["duration"] = float(self.durations[index])
        return self.model.replace(**changes)

    @cached_property
    def eigenvalues(self) -> Multipliers | None:
        """Of equilibria in 1/s, largest real part first, (n_points, n_states); None for orbits."""
        if self.kind != "equilibrium":
            return None
        jacobian = evaluation_of(self.model).jacobian
        models = map(self.model_at, range(len(self)))
        pairs = zip(models, self.states, strict=True)
        return np.array([eigenvalues_of(jacobian(*pair)) for pair in pairs])

    def orbit(self, index: int) -> PeriodicOrbit:
        """Return one point as a periodic orbit.

        Parameters
        ----------
        index
            Row of the locus.
        """
        kind = PeriodicOrbit if self.stuck_fraction is None else StickSlipOrbit
        return kind(
            self.model_at(index),
            self.period,
            self.nodes[index],
            self.multipliers[index],
            float(self.residual[index]),
        )


def hopf_duration(eigenvalues: Multipliers) -> float:
    """Return the period of the cycles born at a Hopf point; NaN where no pair is imaginary.

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


def locus_title(type_: str, period: int, kind: str) -> str:
    """Return e.g. ``"PD of period 2"`` or ``"HB of equilibria"``.

    >>> locus_title("LP", 1, "equilibrium")
    'LP of equilibria'
    """
    of = "equilibria" if kind == "equilibrium" else f"period {period}"
    return f"{type_} of {of}"


PIECES = 12
"""Straight pieces between neighboring points."""


@dataclass(frozen=True, eq=False)
class LocusCurve:
    """Values of both parameters as smooth functions of the arclength."""

    knots: Array  # arclength of the points of the locus, shape (n,)
    values: Callable[[Array], Array]  # callable on arclengths of shape (k,), gives shape (k, 2)

    def between(self, index: int) -> Array:
        """Return the line from one point of the locus to the next, shape (k, 2)."""
        s = np.linspace(self.knots[index], self.knots[index + 1], PIECES + 1)
        return np.asarray(self.values(s))


def locus_curve(locus: Locus) -> LocusCurve:
    """Interpolate a locus.

    In the arclength of all unknowns the parameters are smooth even at a cusp of the locus.
    """
    from scipy.interpolate import CubicSpline, interp1d

    if len(locus) < 3:
        values = interp1d(locus.arclength, locus.values, axis=0)
    else:
        values = CubicSpline(locus.arclength, locus.values)
    return LocusCurve(locus.arclength, values)
