"""Implicit Radau steps of stiff trajectories, whose length depends on accuracy only.

Fast decay makes the steps of Taylor's method short. A collocation interval at Radau points damps
it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.collocation_points import CollocationPoints, radau_points
from slipfold.flow.batches import BUDGET
from slipfold.flow.compiled_code import Evaluated
from slipfold.flow.equations import Constants
from slipfold.flow.intervals import Field, Intervals, LinearPart, Stages, solve_intervals
from slipfold.flow.polynomials import DenseTrajectory, StepPolynomials

Watch = Callable[[Array, Array], Array]

POINTS = radau_points(8)
"""Points of a step: without stiffness errors at its end have order 15, those inside order 9."""


class IMPLICIT:
    """Accuracy and number of the implicit steps."""

    # Last term of a step's polynomial over the states; the next is smaller
    tolerance: float = 1e-11
    max_steps: int = 20_000  # ten seconds: a hundred forcing periods of stiff slip
    safety: float = 0.85
    shortest_ratio: float = 0.1  # of two steps
    longest_ratio: float = 3.0


PLACES = np.linspace(0.0, 1.0, 17)[1:]
"""Places in a step at which limits are checked. An undetected dip between two of them is a
thousandth of the change of the output in the step."""


class StepsEnd(Enum):
    """The end of a trajectory."""

    ARRIVED = auto()
    MET = auto()  # a limit
    MANY = auto()  # steps, or they gain too little
    LOST = auto()  # no step is short enough


@dataclass(frozen=True, eq=False)
class ImplicitTrajectory:
    """A trajectory in scaled states, up to its end."""

    polynomials: StepPolynomials | None  # None without a step
    end: StepsEnd
    phase: float  # where it ended
    state: Array  # and in which state, shape (n,)
    limit: int | None = None  # index of the limit it met


def implicit_trajectory(
    field: Field,
    state: Array,
    start: float,
    end: float,
    *,
    watch: Watch | None = None,
    most: int = IMPLICIT.max_steps,
    points: CollocationPoints = POINTS,
    tolerance: float = IMPLICIT.tolerance,
) -> ImplicitTrajectory:
    """Propagate a scaled state to another phase, or until a watched value is not positive.

    Shapes: state (n,).
    """
    times, coefficients = [start], list[Array]()
    order, whole = len(points.points), end - start
    length, before, tried = _first_length(field, state, start, end), None, 0
    outcome, limit, before_call, gained = StepsEnd.ARRIVED, None, start, np.inf
    while times[-1] < end:
        length, tried = min(length, end - times[-1]), tried + 1
        if length < 1e-14 * whole or not np.isfinite(state).all():  # a singularity
            outcome = StepsEnd.LOST
            break
        if tried % BUDGET.call == 0:
            gained, before_call = times[-1] - before_call, times[-1]
        if tried > most or gained < BUDGET.progress * min(1.0, end - times[-1]):
            outcome = StepsEnd.MANY
            break
        solved = _step(field, points, state, times[-1], length, before)
        error = solved.last_term / max(1.0, float(np.abs(solved.stages).max()))
        if not error <= tolerance:  # also without a solution
            requested = (tolerance / error) ** (1 / order) if np.isfinite(error) else 0.0
            length *= max(IMPLICIT.shortest_ratio, IMPLICIT.safety * min(requested, 1.0))
            continue
        powers = points.powers @ solved.slopes[0] * length
        powers[0] += state
        last, through = times[-1] + length >= end, length
        if watch is not None:
            limit, fraction = _first_met(watch, powers, times[-1], length)
            through = fraction * length
        coefficients.append((powers / length ** np.arange(order + 1)[:, None]).T)
        times.append(end if last and limit is None else times[-1] + through)
        if limit is not None:
            state, outcome = _at(powers, np.array([fraction]))[0], StepsEnd.MET
            break
        state, before = solved.ends[0], solved
        length *= min(
            IMPLICIT.longest_ratio, IMPLICIT.safety * (tolerance / max(error, 1e-30)) ** (1 / order)
        )
    polynomials = StepPolynomials(times, coefficients) if coefficients else None
    return ImplicitTrajectory(polynomials, outcome, times[-1], state, limit)


def _first_length(field: Field, state: Array, start: float, end: float) -> float:
    rate = float(np.abs(field.rates(state[None], np.array([start]))).max())
    size = max(1.0, float(np.abs(state).max()))
    # The first step changes the state by a hundredth.
    return min(end - start, 0.01 * size / rate) if rate > 0 else end - start


def _step(
    field: Field,
    points: CollocationPoints,
    state: Array,
    start: float,
    length: float,
    before: Stages | None,
) -> Stages:
    """Solve an interval from the extrapolated previous one."""
    guess = np.broadcast_to(state, (1, len(points.points), len(state)))
    if before is not None:
        ahead = 1.0 + points.points * (length / before.lengths[0])
        guess = before.at(ahead[None], np.array([0]))
    given = Intervals(points, state[None], np.array([start]), np.array([length]))
    return solve_intervals(field, given, guess, derived=False)


def _at(powers: Array, places: Array) -> Array:
    """Evaluate a polynomial, shape (p, n). Shapes: powers (m + 1, n); places (p,)."""
    return np.asarray(np.vander(places, len(powers), increasing=True) @ powers)


def _first_met(
    watch: Watch, powers: Array, start: float, length: float
) -> tuple[int | None, float]:
    """Return the first limit met in a step, or None, and the place in the step."""

    def values(places: Array) -> Array:
        return watch(start + places * length, _at(powers, places))

    below = ~(values(PLACES) > 0)
    if not below.any():
        return None, 1.0
    row = int(below.any(axis=1).argmax())
    low, high = (PLACES[row - 1] if row else 0.0), float(PLACES[row])
    for _ in range(52):
        middle = (low + high) / 2
        if (values(np.array([middle])) > 0).all():
            low = middle
        else:
            high = middle
    return int((~(values(np.array([high]))[0] > 0)).argmax()), high


class StiffFallback:
    """Continues a trajectory with implicit steps."""

    def __init__(self, flow: Evaluated, constants: Constants) -> None:
        self.field = Field(flow, constants, constants.scales, [], LinearPart())

    def is_due(self, single: Any) -> bool:
        """Whether fast decay limited the integrator's last step."""
        state, phase = np.array(single.state)[None], np.array([single.time])
        jacobian = self.field.jacobians(state, phase)[0]
        if not np.isfinite(jacobian).all():
            return False
        values = np.linalg.eigvals(jacobian)
        fastest = values[np.abs(values).argmax()]
        decays = fastest.real < -abs(fastest.imag)
        # Taylor's method of order 16 is stable up to 6; for accuracy it takes a few tenths.
        return bool(decays and abs(single.last_h * fastest) > 1.0)

    def motion(
        self, single: Any, end: float, *, watch: Watch | None = None, most: int = IMPLICIT.max_steps
    ) -> ImplicitTrajectory:
        """Return the remainder of a trajectory up to an end."""
        state, phase = np.array(single.state), float(single.time)
        return implicit_trajectory(self.field, state, phase, end, watch=watch, most=most)

    def period(self, state: Array) -> DenseTrajectory | None:
        """Return a trajectory over the first period, None if it ends early.

        Shapes: state (n,).
        """
        known = implicit_trajectory(self.field, state / self.field.scales, 0.0, 1.0)
        if known.end is not StepsEnd.ARRIVED or known.polynomials is None:
            return None
        times = known.polynomials.times
        return DenseTrajectory(times, known.polynomials, self.field.scales, implicit=True)

    def through(self, single: Any, times: Array) -> Array:
        """Return the states of the remainder at some times, NaN beyond its end.

        Shapes: times (p,); returns (p, n).
        """
        states = np.full((len(times), len(single.state)), np.nan)
        known = self.motion(single, float(times[-1]))
        if known.polynomials is not None:
            reached = times <= known.phase
            states[reached] = known.polynomials(times[reached])
        return states

    def matrices(self, trajectory: DenseTrajectory, edges: Array) -> Array:
        """Return the derivatives of scaled states at edges by those at the previous edges.

        Shapes: edges (m + 1,); returns (m, n, n).
        """
        lengths = np.diff(edges)
        phases = edges[:-1, None] + lengths[:, None] * POINTS.points
        nodes, stages = (
            trajectory.at(times.ravel()).reshape(*times.shape, -1) / trajectory.scales
            for times in (edges[:-1], phases)
        )
        given = Intervals(POINTS, nodes, edges[:-1], lengths)
        return solve_intervals(self.field, given, stages).matrices
