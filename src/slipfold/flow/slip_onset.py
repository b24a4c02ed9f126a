"""The onset of slip in the plane, solved on one interval."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array
from slipfold.collocation_points import radau_points
from slipfold.flow.batches import TOLERANCE
from slipfold.flow.intervals import Field, Inverted, Stages
from slipfold.flow.modes import CONTACT
from slipfold.flow.polynomials import StepPolynomials

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
    last = POINTS.transform[-1] @ solved.slopes[0] * length / (2 * (2 * len(phases) - 1))
    return SlipOnset(field, begin, length, solved) if np.abs(last).max() <= TOLERANCE else None


def _equations(field: Field, lengths: Array, stages: Array, phases: Array) -> Inverted | None:
    """Return the derivatives of the stages' equations, None where they are singular."""
    jacobians = field.jacobians(stages, phases)[None]
    if not np.isfinite(jacobians).all():
        return None
    try:
        return Inverted.of(POINTS, lengths, jacobians)
    except np.linalg.LinAlgError:
        return None
