"""Dense output of trajectories, a polynomial per step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import heyoka as hy
import numpy as np

from slipfold.arrays import Array
from slipfold.collocation_points import radau_points
from slipfold.flow.batches import STEP_LIMIT, TOLERANCE
from slipfold.flow.intervals import Field, Inverted, Stages
from slipfold.flow.modes import CONTACT


@dataclass(frozen=True, eq=False)
class DenseTrajectory:
    """A trajectory of an autonomous model over some steps of the integrator."""

    phases: Array  # where the steps begin and end, from zero on, shape (m,)
    polynomials: Any  # maps phases to states in units of the scales
    scales: Array  # units of the states
    implicit: bool = False  # whether it took implicit steps

    @property
    def end(self) -> float:
        """The last phase."""
        return float(self.phases[-1])

    def at(self, phases: Array) -> Array:
        """Return the states at some phases, as exact as the integration, shape (m, n).

        Shapes: phases (m,).
        """
        return np.array(self.polynomials(phases)) * self.scales


class StepPolynomials:
    """Dense output of integration steps.

    heyoka's own compiles code for each trajectory, which takes longer than most smooth phases.
    """

    def __init__(
        self, times: Sequence[float] | Array, coefficients: Sequence[Array] | Array
    ) -> None:
        self.times = np.array(times)  # ends of the steps, shape (m + 1,)
        self.tcs = np.array(coefficients)  # of powers of the time in a step, shape (m, n, order)

    def __call__(self, times: Array) -> Array:
        """Return states at some times, shape (p, n). Shapes: times (p,)."""
        index = np.searchsorted(self.times, times, side="right") - 1
        index = np.minimum(np.maximum(index, 0), len(self.tcs) - 1)
        powers = np.vander(times - self.times[index], self.tcs.shape[2], increasing=True)
        return np.asarray((self.tcs[index] @ powers[:, :, None])[:, :, 0])

    def nodes(self, fractions: Array, steps: Any = ...) -> tuple[Array, Array, Array]:
        """Return states and times after fractions of steps, and the rate of time with them.

        Shapes: fractions (p,); returns (m, p, n), (m, p), (m, p).
        """
        lengths = np.diff(self.times)[steps, None]
        times = self.times[:-1][steps, None] + lengths * fractions
        powers = np.vander((lengths * fractions).ravel(), self.tcs.shape[2], increasing=True)
        powers = powers.reshape(*times.shape, -1)
        states = np.einsum("ink,ipk->ipn", self.tcs[steps], powers)
        return states, times, lengths + np.zeros_like(times)


SUCCESS = int(hy.taylor_outcome.success)


def step_to(integrator: Any, end: float, steps: int) -> tuple[int, StepPolynomials]:
    """Integrate step by step; return the outcome of the last step, and dense output."""
    times, coefficients = [float(integrator.time)], []
    for _ in range(steps):
        result, _ = integrator.step(end - integrator.time, write_tc=True)
        outcome = int(result)
        coefficients.append(np.array(integrator.tc))
        times.append(float(integrator.time))
        # Outcomes of zero and more are events at which the integrator continues.
        if outcome != SUCCESS and outcome < 0:
            return outcome, StepPolynomials(times, coefficients)
    return STEP_LIMIT, StepPolynomials(times, coefficients)


class SlowPolynomials:
    """Dense output of slow slip, in a time rescaled by its speed."""

    def __init__(
        self,
        inner: StepPolynomials,
        n: int,
        placed: Callable[[Array, Array, Array], Array],
        held: Sequence[int],
    ) -> None:
        self.held = held  # states that follow from speed and angle
        self.inner, self._n, self._placed = inner, n, placed
        # Phases at the ends of steps; they increase with every step.
        self.times = np.array([*inner.tcs[:, n + 2, 0], inner(inner.times[-1:])[0, n + 2]])

    def __call__(self, phases: Array) -> Array:
        """Return states at some phases, shape (p, n). Shapes: phases (p,)."""
        n, inner = self._n, self.inner
        steps = np.searchsorted(self.times, phases, side="right") - 1
        steps = np.clip(steps, 0, len(inner.tcs) - 1)
        low, high = inner.times[steps], inner.times[steps + 1]
        at = (low + high) / 2
        for _ in range(60):  # bisection and Newton's method
            values = inner(at)
            late = values[:, n + 2] >= phases
            low, high = np.where(late, low, at), np.where(late, at, high)
            after = at - (values[:, n + 2] - phases) / np.exp(CONTACT.unit * values[:, n])
            after = np.where((low < after) & (after < high), after, (low + high) / 2)
            if (np.abs(after - at) <= np.spacing(high)).all():
                break
            at = after
        return self._stated(inner(at))

    def nodes(self, fractions: Array, steps: Any = ...) -> tuple[Array, Array, Array]:
        """Return states and phases after fractions of steps, and the rate of the phase.

        Shapes: fractions (p,); returns (m, p, n), (m, p), (m, p).
        """
        n = self._n
        values, _, lengths = self.inner.nodes(fractions, steps)
        states = self._stated(values.reshape(-1, values.shape[-1])).reshape(*values.shape[:2], n)
        return states, values[..., n + 2], lengths * np.exp(CONTACT.unit * values[..., n])

    def _stated(self, values: Array) -> Array:
        """Return states from integrated variables. Shapes: values (p, n + 3 or more)."""
        n = self._n
        return self._placed(
            values[:, :n], values[:, n : n + 2] * [CONTACT.unit, 1.0], values[:, n + 2]
        )


class OnsetPolynomials:
    """Dense output of the onset of slip, which at first is too slow to have a direction."""

    def __init__(
        self, inner: StepPolynomials, n: int, placed: Callable[[Array, float], Array]
    ) -> None:
        self.inner, self._n, self._placed = inner, n, placed

    def __call__(self, phases: Array) -> Array:
        """Return states at some phases, shape (p, n). Shapes: phases (p,)."""
        known = self.inner(phases)[:, : self._n]
        return np.array([self._placed(*item) for item in zip(known, phases, strict=True)])

    def nodes(self, fractions: Array) -> tuple[Array, Array, Array]:
        """Return states and phases after fractions of each step, and the rate of the phase.

        Shapes: fractions (p,); returns (steps, p, n), (steps, p), (steps, p).
        """
        _, phases, lengths = self.inner.nodes(fractions)
        return np.array([self(row) for row in phases]), phases, lengths


Dense = StepPolynomials | SlowPolynomials | OnsetPolynomials


# -- the onset of slip in the plane, solved on one interval ---------------------------------------


POINTS = radau_points(8)
"""Points of the polynomial; six give the same end within 1e-14."""


@dataclass(frozen=True, eq=False)
class SlipOnset:
    """A time in which slip begins, with its solution."""

    field: Field
    begin: float  # phase
    length: float  # in phases
    solved: Stages  # one interval, in scaled states

    @property
    def stages(self) -> Array:
        """States at the points, shape (s, n)."""
        return np.asarray(self.solved.stages[0] * self.field.scales)

    @property
    def phases(self) -> Array:
        """Phases of the points, shape (s,)."""
        return self.solved.phases[0]

    @property
    def end(self) -> float:
        """Last phase."""
        return self.begin + self.length

    def integrals(self, phase: float) -> Array:
        """Return the weights of an integral up to a phase, shape (s,)."""
        if phase >= self.end:
            return self.length * POINTS.weights
        fraction = (phase - self.begin) / self.length
        return np.asarray(self.length * POINTS.integrals(np.array([fraction]))[0])

    def at(self, phase: float) -> Array:
        """Return the state at a phase, shape (n,)."""
        if phase >= self.end:
            return np.asarray(self.stages[-1])
        scaled = self.solved.nodes[0] + self.integrals(phase) @ self.solved.slopes[0]
        return np.asarray(scaled * self.field.scales)

    @property
    def missing(self) -> Array:
        """Slopes of the polynomial less rates, which have rounding errors, shape (s, n)."""
        scaled = self.solved.stages[0]
        rates = self.field.rates(scaled, self.phases)
        return np.asarray((self.solved.slopes[0] - rates) * self.field.scales)

    def polynomials(self, end: float) -> StepPolynomials:
        """Return dense output of scaled states up to a phase."""
        powers = POINTS.powers @ self.solved.slopes[0] * self.length
        powers[0] += self.solved.nodes[0]
        powers /= self.length ** np.arange(len(powers))[:, None]
        return StepPolynomials([self.begin, end], [powers.T])

    def linearized(self, phase: float, directions: Array) -> tuple[Array, Array]:
        """Return derivatives of the state at a phase by the first state and the coefficients.

        They include the change of the time of release, since slip continued through zero differs
        only in second order. Shapes: directions (n_c, k); returns (n, n), (n, k).
        """
        field, n = self.field, len(self.field.scales)
        rows, phases = self.stages, self.phases
        pushes = np.zeros((*rows.shape, directions.shape[1]))
        if pushes.size:
            by_parameters = field.flow.parameter_slopes(rows, phases, field.constants, directions)
            pushes = by_parameters / field.scales[:, None]
        equations = _equations(field, self.solved.lengths, self.solved.stages[0], phases)
        assert equations is not None  # it is solved
        driven = self.length * np.einsum("lk,kaq->laq", POINTS.inner, pushes)
        changes = np.concatenate([equations.moved, equations.solve(driven[None])], axis=3)[0]
        own = np.eye(n, n + directions.shape[1])
        fraction = self.integrals(phase) / self.length @ POINTS.outer
        result = own + np.einsum("k,kab->ab", fraction, changes - own)
        result *= field.scales[:, None]
        return result[:, :n] / field.scales, result[:, n:]


def solve_onset(
    field: Field, state: Array, begin: float, length: float, guess: Array
) -> SlipOnset | None:
    """Solve for the onset of slip; None if a polynomial does not represent it.

    Shapes: state (n,); guess (s, n).
    """
    node, lengths = state / field.scales, np.array([length])
    stages, phases = guess / field.scales, begin + length * POINTS.points
    equations, before = None, 1.0
    for _ in range(CONTACT.iterations):
        rates = field.rates(stages, phases)
        if equations is None:
            equations = _equations(field, lengths, stages, phases)
        if equations is None:
            return None
        missing = node + length * (POINTS.inner @ rates) - stages
        step = equations.solve(missing[None, ..., None])[0, ..., 0]
        stages = stages + step
        size = float(np.abs(step).max())
        if not size <= CONTACT.renewal_ratio * before:
            equations = None
        # Convergence: the next step is smaller by the ratio of the last two.
        elif size <= CONTACT.last_step or (
            before < 1.0 and size * size <= CONTACT.last_step * before
        ):
            break
        before = size
    else:
        return None
    assert equations is not None
    one = np.array([begin])
    solved = Stages(POINTS, node[None], one, lengths, stages[None], rates[None], equations, None)
    # The error is smaller than the last term by the ratio of the last two terms.
    return SlipOnset(field, begin, length, solved) if solved.last_term <= TOLERANCE else None


def _equations(field: Field, lengths: Array, stages: Array, phases: Array) -> Inverted | None:
    """Return the derivatives of the stages' equations, None where they are singular."""
    jacobians = field.jacobians(stages, phases)[None]
    if not np.isfinite(jacobians).all():
        return None
    try:
        return Inverted.of(POINTS, lengths, jacobians)
    except np.linalg.LinAlgError:
        return None
