"""Bifurcations and orbits as functions of parameters, and the optimal parameters."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Generic, Self, TypeVar

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.response import trace_response
from slipfold.bifurcations.branches.settings import Settings
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.bifurcations.branches.stability import loss_of_stability
from slipfold.bifurcations.loci.gradients import column_of, corrected, plane_of_scales, solved
from slipfold.continuation.newton import Correction
from slipfold.errors import BREAKDOWNS, NUMERICAL, InputError, breakdown
from slipfold.models.model import Model
from slipfold.orbits.bifurcation_types import BIFURCATION_TYPES, PAIRED
from slipfold.orbits.critical import Critical
from slipfold.orbits.find import periodic_orbit
from slipfold.orbits.kinds import orbits_of
from slipfold.orbits.orbit_curve import OrbitCurve, Orbits
from slipfold.orbits.shooting import SEGMENTS
from slipfold.orbits.test_functions import critical_pair


class OPTIMUM:
    """Limits and tolerances of parameterized solutions and of the search among them."""

    # Maximum correction of a guess, in scaled variables; a longer one may lead to another solution
    far: float = 0.1
    # Maximum number of times that a parameter step is halved
    halvings: int = 6
    # Equidistant phases of a forcing period over which an orbit is averaged. For a smooth orbit
    # that is exact up to the 32nd harmonic
    phases: int = 64
    # Fraction of the threshold by which the response is followed beyond it
    beyond: float = 0.05
    # Relative difference of equal thresholds
    same: float = 1e-8
    # Change of the level, over that at the start, at which the minimization ends
    exact: float = 1e-9
    # Tolerance of a requirement, as a fraction of its bound
    met: float = 1e-6
    iterations: int = 60


class NoSolutionError(Exception):
    """No solution exists at the parameter values; the message says why."""


class ParameterizedSolution(ABC):
    """An orbit that solves equations, as a function of parameters.

    `names` are the parameters that may change. One of them, the first of the varied parameters, is
    an unknown that is held.
    """

    def __init__(
        self, names: tuple[str, ...], orbits: Orbits, found: Correction, model: Model
    ) -> None:
        self.names, self.model, self.orbits = names, model, orbits
        self.z: Array = found.z
        self._found = found

    @abstractmethod
    def _curve(self, orbits: Orbits) -> OrbitCurve:
        """Return the equations."""

    @abstractmethod
    def _placed(self, orbits: Orbits, found: Correction, model: Model) -> Self:
        """Return the solution at other values; may raise `NoSolutionError`."""

    @property
    def _held(self) -> int:
        """Index of the parameter that is held."""
        return -len(self.orbits.varied)

    def holding(self, name: str) -> tuple[Orbits, Array]:
        """Return the same orbit with another parameter held."""
        scale = abs(self.model.values[name]) or 1.0
        others = list(self.orbits.varied.items())[1:]
        z = self.z.copy()
        z[self._held] = self.model.values[name] / scale
        return self.orbits.varying({name: scale, **dict(others)}), z

    @cached_property
    def rates(self) -> Array:
        """Derivatives of the unknown by each parameter in its own unit, shape (d, u).

        One factorization gives all of them.
        """
        rows = []
        for name in self.names:
            orbits, z = self.holding(name)
            column = column_of(self._curve(orbits).linearize(z), self._held)
            right = -column / orbits.varied[name]
            rows.append(self._found.bordered.solve(np.append(right, 0.0)))
        return np.array(rows)

    def moved_to(self, values: Mapping[str, float]) -> Self:
        """Return the solution at other values of the parameters, in several steps if necessary.

        Raises `NoSolutionError`.
        """
        here, done, step = self, 0.0, 1.0
        first = {name: self.model.values[name] for name in self.names}
        while done < 1.0:
            fraction = min(done + step, 1.0)
            there = {
                name: first[name] + fraction * (values.get(name, first[name]) - first[name])
                for name in self.names
            }
            try:
                here, done = here._nearby(there), fraction
            except NoSolutionError:
                step /= 2
                if step < 0.5**OPTIMUM.halvings:
                    raise
        return here

    def _nearby(self, values: Mapping[str, float]) -> Self:
        """Return the solution at nearby values, in one step."""
        try:
            model = self.model.replace(**values)
        except InputError as error:
            raise NoSolutionError(str(error)) from None
        orbits = self.orbits.at_values_of(model)
        change = np.array([model.values[name] - self.model.values[name] for name in self.names])
        guess = self.z + change @ self.rates
        held = next(iter(orbits.varied))
        guess[self._held] = model.values[held] / orbits.varied[held]
        try:
            found = corrected(self._curve(orbits), guess, self._held, Settings())
        except BREAKDOWNS as error:
            raise NoSolutionError(breakdown(error)) from None
        if not found.converged:
            raise NoSolutionError(found.failure)
        if found.distance > OPTIMUM.far:
            raise NoSolutionError("the equations lead to another solution")
        return self._placed(orbits, found, model)


class ParameterizedOrbit(ParameterizedSolution):
    """A forced response at some values of the parameters."""

    @classmethod
    def at(cls, model: Model, names: tuple[str, ...]) -> Self:
        """Return the response of a model, of period 1."""
        orbit = periodic_orbit(model)
        orbits = orbits_of(model, {names[0]: abs(model.values[names[0]]) or 1.0}, 1, SEGMENTS)
        z = orbits.unknown(orbit.nodes[:: len(orbit.nodes) // SEGMENTS], model)
        found = corrected(orbits, z, -1, Settings())
        if not found.converged:
            raise InputError(f"the response of {model!r} is not found again ({found.failure})")
        return cls(names, orbits, found, model)

    def level(self, state: int) -> tuple[float, Array]:
        """Return the root mean square of a state about its mean, and its derivatives.

        Shapes: returns (), (d,).
        """
        phases = np.arange(OPTIMUM.phases) / OPTIMUM.phases
        slopes, moving = [], np.empty(0)
        for name, rate in zip(self.names, self.rates, strict=True):
            orbits, z = self.holding(name)
            nodes, constants = orbits.nodes(z), orbits.constants(z)
            which, states, matrices, vectors = orbits.by.propagate_to(nodes, constants, phases)
            nodes_rate = self.orbits.nodes(rate)[which]
            along = np.einsum("jb,jb->j", matrices[:, state], nodes_rate) + vectors[:, state, 0]
            moving = states[:, state] - states[:, state].mean()
            slopes.append(float(moving @ (along - along.mean())) / OPTIMUM.phases)
        level = float(np.sqrt(np.mean(moving**2)))
        return level, np.array(slopes) / level

    def _curve(self, orbits: Orbits) -> Orbits:
        return orbits

    def _placed(self, orbits: Orbits, found: Correction, model: Model) -> Self:
        return type(self)(self.names, orbits, found, model)


class ParameterizedPoint(ParameterizedSolution):
    """A special point as a solution of its equations, at some values of the parameters."""

    def __init__(
        self, kind: str, names: tuple[str, ...], orbits: Orbits, found: Correction, model: Model
    ) -> None:
        super().__init__(names, orbits, found, model)
        self.kind = kind

    @classmethod
    def at(cls, point: SpecialPoint, names: tuple[str, ...]) -> Self:
        """Return a special point at its own parameter values."""
        if point.type == "BP":
            raise InputError(
                "a branch point vanishes where a parameter separates its branches; give a special "
                "point of another type"
            )
        if point.collides:
            raise InputError(
                f"at the {point.type} at {point.vary} = {point.value:.6g} two pairs meet that "
                "nothing damps; give a model with damping"
            )
        try:
            orbits, found = solved(point, plane_of_scales(point, names[0]), Settings())
        except NUMERICAL as error:
            raise InputError(
                f"the {point.type} at {point.vary} = {point.value:.6g} is not found again "
                f"({breakdown(error)}); compute it again"
            ) from None
        return cls(point.type, names, orbits, found, point.model)

    @property
    def value(self) -> float:
        """Value of the parameter that was followed."""
        return self.orbits.value(self.z)

    @property
    def gradient(self) -> Array:
        """Derivatives of the value by each parameter, shape (d,)."""
        return np.asarray(self.rates[:, -1] * self.orbits.width)

    def _curve(self, orbits: Orbits) -> Critical:
        return Critical(orbits, self.kind)

    def _placed(self, orbits: Orbits, found: Correction, model: Model) -> Self:
        if self.kind in PAIRED and not _is_complex(found):
            raise NoSolutionError("the critical pair is no longer complex: there is no bifurcation")
        placed = model.replace(**{orbits.vary: float(orbits.value(found.z))})
        return type(self)(self.kind, self.names, orbits.at_values_of(placed), found, placed)


def _is_complex(found: Correction) -> bool:
    """Whether the critical pair is complex."""
    multipliers = np.linalg.eigvals(found.linearization.monodromy).astype(complex)
    pair = critical_pair(multipliers)
    return pair is not None and bool(multipliers[pair[0]].imag != 0)


def is_confirmed(
    point: SpecialPoint, values: Mapping[str, float], threshold: float, load: float
) -> bool:
    """Return whether a response followed from a load first loses its stability at a threshold.

    A point of a longer period is confirmed if a sequence of period doublings leads to its orbits
    and they lose their stability there first. Where contacts begin or cease to stick, the response
    may stay stable, but must not lose its stability before. An interruption raises
    `KeyboardInterrupt`.
    """
    end = threshold + OPTIMUM.beyond * abs(threshold)
    if not load < threshold:
        return False
    model = point.model.replace(**{**values, point.vary: load})
    try:
        alone = Settings(largest_period=point.period)
        span = load, end
        branches = trace_response(model, point.vary, span, settings=alone, through_stick=True)
    except InputError:
        return False
    if any(branch.interrupted for branch in branches):
        raise KeyboardInterrupt
    if branches[0].parameter[0] != load:
        return False
    branch = _doubled(branches, point.period)
    if branch is None or not branch.stable[0]:
        return False
    first = lost = loss_of_stability(branch)
    if point.type not in BIFURCATION_TYPES:
        first = next((item for item in branch.special if item.type == point.type), None)
    if first is None or (lost is not None and first.arclength > lost.arclength):
        return False
    gap = abs(first.value - threshold)
    return first.type == point.type and gap <= OPTIMUM.same * max(abs(threshold), 1e-300)


def _doubled(branches: Sequence[Branch], period: int) -> Branch | None:
    """Return the branch of a period that period doublings reach from the first branch."""
    known = {branch.id: branch for branch in branches}
    branch: Branch | None = branches[0]
    while branch is not None and branch.period < period:
        lost = loss_of_stability(branch)
        if lost is None or lost.type != "PD" or lost.leads_to is None:
            return None
        branch = known.get(lost.leads_to)
    return branch


@dataclass(frozen=True)
class Requirement:
    """A threshold must lie on one side of a bound."""

    point: ParameterizedPoint  # at the start
    side: str  # "above" or "below"
    bound: float


@dataclass(frozen=True, eq=False)
class Choice:
    """The optimal parameters; without any, numbers are NaN and `reason` says why."""

    values: Array  # of the parameters, shape (d,)
    thresholds: Array  # one a requirement, shape (k,)
    level: float
    reason: str

    @classmethod
    def none(cls, parameters: int, requirements: int, reason: str) -> Choice:
        """Return a choice without parameters."""
        return cls(np.full(parameters, np.nan), np.full(requirements, np.nan), np.nan, reason)


P = TypeVar("P", bound=ParameterizedSolution)


class _Solutions(Generic[P]):
    """Solutions computed so far; the next one starts from the nearest."""

    def __init__(self, first: P, widths: Array) -> None:
        self._all, self._widths = [first], widths

    def at(self, values: Array) -> tuple[P, Array]:
        """Return the solution nearest to some values, and their distance from its values."""
        names = self._all[0].names
        gaps = [values - [item.model.values[name] for name in names] for item in self._all]
        nearest = int(np.argmin([np.linalg.norm(gap / self._widths) for gap in gaps]))
        here, gap = self._all[nearest], gaps[nearest]
        if not gap.any():
            return here, gap
        try:
            here = here.moved_to(dict(zip(names, values.tolist(), strict=True)))
        except NoSolutionError:
            return here, gap
        self._all.append(here)
        return here, np.zeros(len(gap))


def minimize_level(
    orbit: ParameterizedOrbit,
    state: int,
    requirements: Sequence[Requirement],
    bounds: Mapping[str, tuple[float, float]],
    begin: Array,
) -> Choice:
    """Minimize the level of a state's vibration under requirements, from initial parameters.

    The method is sequential quadratic programming with exact derivatives (SciPy's SLSQP). Where a
    threshold does not exist it is extrapolated linearly, so that the search returns. Shapes: begin
    (d,).
    """
    from scipy.optimize import minimize

    low, high = np.array(list(bounds.values())).T
    widths = high - low
    orbits = _Solutions(orbit, widths)
    points = [_Solutions(requirement.point, widths) for requirement in requirements]
    size = orbit.level(state)[0]

    def values_at(x: Array) -> Array:
        return np.clip(low + x * widths, low, high)

    def level(x: Array) -> tuple[float, Array]:
        here, gap = orbits.at(values_at(x))
        found, slopes = here.level(state)
        return float(found + slopes @ gap) / size, slopes * widths / size

    def margin(number: int) -> dict[str, Any]:
        requirement, known = requirements[number], points[number]
        sign = (1.0 if requirement.side == "above" else -1.0) / (abs(requirement.bound) or 1.0)

        def value(x: Array) -> float:
            here, gap = known.at(values_at(x))
            return float(sign * (here.value + here.gradient @ gap - requirement.bound))

        def slope(x: Array) -> Array:
            here, _ = known.at(values_at(x))
            return np.asarray(sign * here.gradient * widths)

        return {"type": "ineq", "fun": value, "jac": slope}

    found = minimize(
        level,
        (begin - low) / widths,
        jac=True,
        method="SLSQP",
        bounds=[(0.0, 1.0)] * len(low),
        constraints=[margin(number) for number in range(len(requirements))],
        options={"ftol": OPTIMUM.exact, "maxiter": OPTIMUM.iterations},
    )
    values = values_at(found.x)
    return _verified(values, orbits, points, state, requirements, str(found.message), found.success)


def _verified(
    values: Array,
    orbits: _Solutions[ParameterizedOrbit],
    points: Sequence[_Solutions[ParameterizedPoint]],
    state: int,
    requirements: Sequence[Requirement],
    message: str,
    solved: bool,
) -> Choice:
    """Return the choice if its response and thresholds exist and meet the requirements."""
    nothing = len(values), len(requirements)
    here, gap = orbits.at(values)
    if gap.any():
        return Choice.none(*nothing, "there is no such response")
    thresholds = []
    for requirement, known in zip(requirements, points, strict=True):
        there, gap = known.at(values)
        if gap.any():
            kind, side = requirement.point.kind, requirement.side
            reason = f"the {kind} to be {side} {requirement.bound:g} vanishes"
            return Choice.none(*nothing, reason)
        thresholds.append(there.value)
        short = (requirement.bound - there.value) * (1 if requirement.side == "above" else -1)
        if short > OPTIMUM.met * abs(requirement.bound):
            reason = (
                f"no choice was found within the bounds that brings the {requirement.point.kind} "
                f"{requirement.side} {requirement.bound:g}; the search ended at {there.value:.6g}"
            )
            return Choice.none(*nothing, reason)
    if not solved:
        return Choice.none(*nothing, f"the search for the minimum level ended early: {message}")
    return Choice(values, np.array(thresholds), here.level(state)[0], "")
