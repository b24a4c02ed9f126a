"""The onset of slip in the plane that grows slowly from zero.

A polynomial through Radau's points solves it: friction turns slip the more firmly the slower it is,
so that explicit steps from rest would never end. Terms of the series in which slip grows fall until
their number is friction, as a rate, times time over slip; the polynomial goes as far as that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array
from slipfold.collocation_points import radau_points
from slipfold.flow.batches import TOLERANCE
from slipfold.flow.intervals import Field, Solved
from slipfold.flow.polynomials import StepPolynomials
from slipfold.flow.stage_equations import Inverted

POINTS = radau_points(8)
"""Points of the polynomial; with six the end is as good to 1e-14."""

EXACT = 1e-15
"""Steps of Newton's method, in scaled states, continue until they are this short: slip at the first
point is a ten thousandth of that at the end."""

ITERATIONS, RENEWED = 12, 0.1
"""How many of them there may be, and from what fraction of the one before on that takes new
derivatives."""


@dataclass(frozen=True, eq=False)
class SlipOnset:
    """A time in which slip begins."""

    field: Field
    begin: float  # phase
    length: float  # in phases
    solved: Solved  # one interval, in scaled states

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
        """Phase at which it is over."""
        return self.begin + self.length

    def integrals(self, phase: float) -> Array:
        """Return weights that integrate over phases what is known at the points, shape (s,)."""
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
        """By how much more states change a phase than the equations say, which round, (s, n)."""
        scaled = self.solved.stages[0]
        rates = self.field.rates(scaled, self.phases)
        return np.asarray((self.solved.slopes[0] - rates) * self.field.scales)

    def polynomials(self, end: float) -> StepPolynomials:
        """Return scaled states as far as some phase."""
        powers = POINTS.powers @ self.solved.slopes[0] * self.length
        powers[0] += self.solved.nodes[0]
        powers /= self.length ** np.arange(len(powers))[:, None]
        return StepPolynomials([self.begin, end], [powers.T])

    def linearized(self, phase: float, directions: Array) -> tuple[Array, Array]:
        """Return derivatives of the state at a phase, by that at the beginning and coefficients.

        Slip that begins earlier or later is included: to first order it makes no difference whether
        slip waits until it may grow, or is carried through zero. Shapes: directions (n_c, k);
        returns (n, n), (n, k).
        """
        field, n = self.field, len(self.field.scales)
        rows, phases = self.stages, self.phases
        pushes = np.zeros((*rows.shape, directions.shape[1]))
        if pushes.size:
            pulls = field.flow.pulls(rows, phases, field.constants, directions)
            pushes = pulls / field.scales[:, None]
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
    """Solve for slip that begins; None where a polynomial does not do.

    Shapes: state (n,); guess (s, n).
    """
    node, lengths = state / field.scales, np.array([length])
    stages, phases = guess / field.scales, begin + length * POINTS.points
    equations, before = None, 1.0
    for _ in range(ITERATIONS):
        rates = field.rates(stages, phases)
        if equations is None:
            equations = _equations(field, lengths, stages, phases)
        if equations is None:
            return None
        missing = node + length * (POINTS.inner @ rates) - stages
        step = equations.solve(missing[None, ..., None])[0, ..., 0]
        stages = stages + step
        size = float(np.abs(step).max())
        if not size <= RENEWED * before:
            equations = None
        # What is left after a step is as much smaller as that was than the one before.
        elif size <= EXACT or (before < 1.0 and size * size <= EXACT * before):
            break
        before = size
    else:
        return None
    assert equations is not None
    one = np.array([begin])
    solved = Solved(POINTS, node[None], one, lengths, stages[None], rates[None], equations, None)
    # What is left out is smaller by as much as the last term is smaller than the one before.
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
