"""Parameters that vibrate least while thresholds lie where they are wanted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from slipfold.arrays import Array
from slipfold.design_space.placed import Lost, Placed
from slipfold.design_space.placed_orbit import PlacedOrbit
from slipfold.design_space.placed_point import PlacedPoint

EXACT = 1e-9
"""Changes of the level, over that at the start, at which it is the least."""

MET = 1e-6
"""A demand is met within this share of its bound."""

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
    """Minimise the level of a state's vibration under demands, from a first choice.

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
