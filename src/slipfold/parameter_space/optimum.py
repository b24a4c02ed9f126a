"""Bifurcations and orbits at chosen parameters, and the best choice of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Generic, Self, TypeVar

import numpy as np

from slipfold.arrays import Array
from slipfold.branches.branch import Branch
from slipfold.branches.response import trace_response
from slipfold.branches.settings import Settings
from slipfold.branches.special_point import BIFURCATIONS, SpecialPoint
from slipfold.branches.stability import loss_of_stability
from slipfold.continuation.newton import Correction
from slipfold.errors import BREAKDOWNS, InputError, breakdown
from slipfold.loci.gradients import column_of, corrected, plane_of_scales, solved
from slipfold.models.model import Model
from slipfold.orbits.critical import Critical
from slipfold.orbits.find import periodic_orbit
from slipfold.orbits.kinds import orbits_of
from slipfold.orbits.orbit_curve import OrbitCurve, Orbits
from slipfold.orbits.shooting import SEGMENTS
from slipfold.orbits.test_functions import PAIRED, critical_pair

FAR = 0.1
"""Correction of a guess, in scaled variables, beyond which it may have led to another solution."""

HALVINGS = 6
"""How often the way is halved before a solution is given up."""


class Lost(Exception):
    """There is no such solution at some parameter values; says why."""


class Placed(ABC):
    """An orbit that solves some equations, at some values of the parameters.

    `names` are the parameters that may change. One of them is among the unknowns, held: it comes
    first of what varies.
    """

    def __init__(
        self, names: tuple[str, ...], orbits: Orbits, found: Correction, model: Model
    ) -> None:
        self.names, self.model, self.orbits = names, model, orbits
        self.z: Array = found.z
        self._found = found

    @abstractmethod
    def _curve(self, orbits: Orbits) -> OrbitCurve:
        """Return the equations that are solved."""

    @abstractmethod
    def _placed(self, orbits: Orbits, found: Correction, model: Model) -> Self:
        """Return the same elsewhere; may raise `Lost`."""

    @property
    def _held(self) -> int:
        """Place of the parameter that is held."""
        return -len(self.orbits.varied)

    def beside(self, name: str) -> tuple[Orbits, Array]:
        """Return the same orbit where another parameter is the one that is held."""
        scale = abs(self.model.values[name]) or 1.0
        others = list(self.orbits.varied.items())[1:]
        z = self.z.copy()
        z[self._held] = self.model.values[name] / scale
        return self.orbits.varying({name: scale, **dict(others)}), z

    @cached_property
    def rates(self) -> Array:
        """Derivatives of the unknown by each parameter in its own unit, shape (d, u).

        All from one factorization; what is held is left out.
        """
        rows = []
        for name in self.names:
            orbits, z = self.beside(name)
            column = column_of(self._curve(orbits).linearize(z), self._held)
            right = -column / orbits.varied[name]
            rows.append(self._found.bordered.solve(np.append(right, 0.0)))
        return np.array(rows)

    def moved_to(self, values: Mapping[str, float]) -> Self:
        """Return the same at other values of the parameters, in steps where one leads too far.

        Raises `Lost`.
        """
        here, done, step = self, 0.0, 1.0
        first = {name: self.model.values[name] for name in self.names}
        while done < 1.0:
            share = min(done + step, 1.0)
            there = {
                name: first[name] + share * (values.get(name, first[name]) - first[name])
                for name in self.names
            }
            try:
                here, done = here._nearby(there), share
            except Lost:
                step /= 2
                if step < 0.5**HALVINGS:
                    raise
        return here

    def _nearby(self, values: Mapping[str, float]) -> Self:
        """Return the same nearby, in one step."""
        try:
            model = self.model.replace(**values)
        except InputError as error:
            raise Lost(str(error)) from None
        orbits = self.orbits.at_values_of(model)
        change = np.array([model.values[name] - self.model.values[name] for name in self.names])
        guess = self.z + change @ self.rates
        held = next(iter(orbits.varied))
        guess[self._held] = model.values[held] / orbits.varied[held]
        try:
            found = corrected(self._curve(orbits), guess, self._held, Settings())
        except BREAKDOWNS as error:
            raise Lost(breakdown(error)) from None
        if not found.converged:
            raise Lost(found.failure)
        if found.distance > FAR:
            raise Lost("the equations lead to another solution")
        return self._placed(orbits, found, model)


PHASES = 64
"""Equidistant phases a forcing period over which a trajectory is averaged: of a smooth periodic one
that is exact but for harmonics above the 32nd."""


class PlacedOrbit(Placed):
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
        """Return how much a state vibrates, root mean square about its mean, and derivatives.

        Shapes: returns (), (d,).
        """
        phases = np.arange(PHASES) / PHASES
        slopes, moving = [], np.empty(0)
        for name, rate in zip(self.names, self.rates, strict=True):
            orbits, z = self.beside(name)
            nodes, constants = orbits.nodes(z), orbits.constants(z)
            which, states, matrices, vectors = orbits.by.carried_to(nodes, constants, phases)
            nodes_rate = self.orbits.nodes(rate)[which]
            along = np.einsum("jb,jb->j", matrices[:, state], nodes_rate) + vectors[:, state, 0]
            moving = states[:, state] - states[:, state].mean()
            slopes.append(float(moving @ (along - along.mean())) / PHASES)
        level = float(np.sqrt(np.mean(moving**2)))
        return level, np.array(slopes) / level

    def _curve(self, orbits: Orbits) -> Orbits:
        return orbits

    def _placed(self, orbits: Orbits, found: Correction, model: Model) -> Self:
        return type(self)(self.names, orbits, found, model)


class PlacedPoint(Placed):
    """A special point as a solution of its equations, at some values of the parameters."""

    def __init__(
        self, kind: str, names: tuple[str, ...], orbits: Orbits, found: Correction, model: Model
    ) -> None:
        super().__init__(names, orbits, found, model)
        self.kind = kind

    @classmethod
    def at(cls, point: SpecialPoint, names: tuple[str, ...]) -> Self:
        """Return the point where it was found."""
        if point.type == "BP":
            raise InputError(
                "a branch point goes nowhere where a parameter parts its branches; give a special "
                "point of another type"
            )
        try:
            orbits, found = solved(point, plane_of_scales(point, names[0]), Settings())
        except InputError:
            raise
        except BREAKDOWNS as error:
            raise InputError(
                f"the {point.type} at {point.vary} = {point.value:.6g} is not found again "
                f"({breakdown(error)}); compute it anew"
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
        if self.kind in PAIRED and not _turns(found):
            raise Lost("the pair that was critical no longer turns: it is no bifurcation there")
        placed = model.replace(**{orbits.vary: float(orbits.value(found.z))})
        return type(self)(self.kind, self.names, orbits.at_values_of(placed), found, placed)


def _turns(found: Correction) -> bool:
    """Whether the critical pair is complex."""
    multipliers = np.linalg.eigvals(found.linearization.monodromy).astype(complex)
    pair = critical_pair(multipliers)
    return pair is not None and bool(multipliers[pair[0]].imag != 0)


BEYOND = 0.05
"""Fraction of the threshold by which the response is followed past it."""

SAME = 1e-8
"""Difference of thresholds, over their size, that are the same."""


def is_confirmed(
    point: SpecialPoint, values: Mapping[str, float], threshold: float, load: float
) -> bool:
    """Return whether the response from a load on first loses its stability at a threshold.

    Of a point of a longer period, whether the orbits of that period do to which doublings lead, one
    after the other, each of which begins stable. Where contacts begin or cease to do something
    nothing need be lost: that is to come before the loss. If it is interrupted it raises
    `KeyboardInterrupt`.
    """
    end = threshold + BEYOND * abs(threshold)
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
    if point.type not in BIFURCATIONS:
        first = next((item for item in branch.special if item.type == point.type), None)
    if first is None or (lost is not None and first.arclength > lost.arclength):
        return False
    gap = abs(first.value - threshold)
    return first.type == point.type and gap <= SAME * max(abs(threshold), 1e-300)


def _doubled(branches: Sequence[Branch], period: int) -> Branch | None:
    """Return the branch of a period to which losses by doubling lead from the first one."""
    known = {branch.id: branch for branch in branches}
    branch: Branch | None = branches[0]
    while branch is not None and branch.period < period:
        lost = loss_of_stability(branch)
        if lost is None or lost.type != "PD" or lost.leads_to is None:
            return None
        branch = known.get(lost.leads_to)
    return branch


EXACT = 1e-9
"""Changes of the level, over that at the start, at which it is the least."""

MET = 1e-6
"""A demand is met within this fraction of its bound."""

ROUNDS = 60


@dataclass(frozen=True)
class Demand:
    """A threshold that is to lie on one side of a bound."""

    point: PlacedPoint  # at the start
    side: str  # "above" or "below"
    bound: float


@dataclass(frozen=True, eq=False)
class Choice:
    """What was chosen; if nothing could be, the reason says why, and numbers are NaN."""

    values: Array  # of the parameters, shape (d,)
    thresholds: Array  # one a demand, shape (k,)
    level: float
    reason: str

    @classmethod
    def none(cls, parameters: int, demands: int, reason: str) -> Choice:
        """Return that nothing was chosen."""
        return cls(np.full(parameters, np.nan), np.full(demands, np.nan), np.nan, reason)


P = TypeVar("P", bound=Placed)


class _Known(Generic[P]):
    """Solutions found so far; the next one starts from the nearest."""

    def __init__(self, first: P, widths: Array) -> None:
        self._all, self._widths = [first], widths

    def at(self, values: Array) -> tuple[P, Array]:
        """Return the solution nearest to some values, and how far they still are from it."""
        names = self._all[0].names
        gaps = [values - [item.model.values[name] for name in names] for item in self._all]
        nearest = int(np.argmin([np.linalg.norm(gap / self._widths) for gap in gaps]))
        here, gap = self._all[nearest], gaps[nearest]
        if not gap.any():
            return here, gap
        try:
            here = here.moved_to(dict(zip(names, values.tolist(), strict=True)))
        except Lost:
            return here, gap
        self._all.append(here)
        return here, np.zeros(len(gap))


def choose_least(
    orbit: PlacedOrbit,
    state: int,
    demands: Sequence[Demand],
    bounds: Mapping[str, tuple[float, float]],
    begin: Array,
) -> Choice:
    """Minimize the level of a state's vibration under demands, from a first choice.

    By sequential quadratic programming with exact derivatives (SciPy's SLSQP). Where a threshold
    has vanished it is taken as linear, so that a step back is found. Shapes: begin (d,).
    """
    from scipy.optimize import minimize

    low, high = np.array(list(bounds.values())).T
    widths = high - low
    orbits = _Known(orbit, widths)
    points = [_Known(demand.point, widths) for demand in demands]
    size = orbit.level(state)[0]

    def values_at(x: Array) -> Array:
        return np.clip(low + x * widths, low, high)

    def level(x: Array) -> tuple[float, Array]:
        here, gap = orbits.at(values_at(x))
        found, slopes = here.level(state)
        return float(found + slopes @ gap) / size, slopes * widths / size

    def margin(number: int) -> dict[str, Any]:
        demand, known = demands[number], points[number]
        sign = (1.0 if demand.side == "above" else -1.0) / (abs(demand.bound) or 1.0)

        def value(x: Array) -> float:
            here, gap = known.at(values_at(x))
            return float(sign * (here.value + here.gradient @ gap - demand.bound))

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
        constraints=[margin(number) for number in range(len(demands))],
        options={"ftol": EXACT, "maxiter": ROUNDS},
    )
    values = values_at(found.x)
    return _judged(values, orbits, points, state, demands, str(found.message), found.success)


def _judged(
    values: Array,
    orbits: _Known[PlacedOrbit],
    points: Sequence[_Known[PlacedPoint]],
    state: int,
    demands: Sequence[Demand],
    message: str,
    solved: bool,
) -> Choice:
    """Return what was chosen if its response and thresholds exist and are where they should be."""
    nothing = len(values), len(demands)
    here, gap = orbits.at(values)
    if gap.any():
        return Choice.none(*nothing, "the response is lost on the way")
    thresholds = []
    for demand, known in zip(demands, points, strict=True):
        there, gap = known.at(values)
        if gap.any():
            reason = f"the {demand.point.kind} to be {demand.side} {demand.bound:g} vanishes"
            return Choice.none(*nothing, reason)
        thresholds.append(there.value)
        short = (demand.bound - there.value) * (1 if demand.side == "above" else -1)
        if short > MET * abs(demand.bound):
            reason = (
                f"no choice was found within the bounds that brings the {demand.point.kind} "
                f"{demand.side} {demand.bound:g}; the search came to {there.value:.6g}"
            )
            return Choice.none(*nothing, reason)
    if not solved:
        return Choice.none(*nothing, f"the search for the least level ended early: {message}")
    return Choice(values, np.array(thresholds), here.level(state)[0], "")
