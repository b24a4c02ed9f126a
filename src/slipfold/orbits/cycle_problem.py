"""Cycles of an autonomous model in one parameter: their duration is unknown."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from slipfold.models.model import Model
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.linearisation import Conditions, Linearisation, defect_of
from slipfold.orbits.phase_alignment import begun_nearest
from slipfold.orbits.shooting import Shooting

__all__ = [
    "CycleLinearisation",
    "CycleProblem",
    "aligned_cycle",
    "all_multipliers",
    "flow_direction",
    "gauge_conditions",
    "on_quotient",
    "quotient_basis",
]

Array = NDArray[np.float64]

ALIGNMENTS = 3
"""Corrections of a phase, each of which leaves the square of what was left before."""


class CycleProblem(PeriodicProblem):
    r"""Cycles in one free parameter.

    An unknown ``z`` holds the scaled states at m phases, the scaled duration of one round and the
    scaled parameter. A cycle may be begun anywhere on it: Newton's steps and tangents are kept
    orthogonal to the flow, which fixes the phase without a condition to be met.

    The monodromy matrix of a cycle has the direction of the flow as an eigenvector, with the
    multiplier one. Test functions are made of the matrix on the quotient space, which has the
    other multipliers.

    Parameters
    ----------
    model
        The model; its values of `vary` and of ``duration`` play no part, but the latter sets the
        scale of the duration.
    vary
        Name of the free parameter.
    period
        Rounds until an orbit closes.
    width
        Scale of the parameter, in its unit.
    segments
        Number of segments m.
    offset
        Phase of the first node, in segments.
    """

    kind = "cycle"

    @staticmethod
    def _free(model: Model, vary: str, width: float) -> tuple[list[str], list[float]]:
        """The duration of one round, then the parameter."""
        return ["duration", vary], [model.values["duration"], width]

    def duration(self, z: Array) -> float:
        """Return the duration of one round in seconds."""
        return float(self.free_values(z)[-2])

    def pack_cycle(self, nodes: Array, duration: float, value: float) -> Array:
        """Scale a cycle and a parameter value into an unknown.

        Shapes: nodes (m, n).
        """
        return self.join(nodes, [duration, value])

    def adopt(self, other: PeriodicProblem, z: Array) -> Array:
        """Return the unknown of a cycle that another problem describes."""
        duration = float(other.vector(z)[self.model.parameter_index("duration")])
        return self.pack_cycle(other.nodes(z), duration, other.value(z))

    def in_phase(self, z: Array, like: Array) -> Array:
        """Return the same cycle begun where it lies nearest to another."""
        return begun_nearest(self, z, like)

    def begun_near(self, z: Array, reference: Array) -> Array:
        """Return the same cycle begun where it lies nearest to another."""
        return begun_nearest(self, z, reference)

    def all_multipliers(self, multipliers: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return the multipliers with that of the flow's own direction, shape (n,).

        Shapes: multipliers (n - 1,).
        """
        return all_multipliers(multipliers)

    def defect(self, z: Array) -> Array:
        """Return what Newton's method brings to zero, shape (m n + 1,): nothing for the phase."""
        residual = self.mismatch(self.nodes(z), self.constants(z))
        return defect_of(residual, np.zeros(1))

    def linearise(self, z: Array) -> CycleLinearisation:
        """Return the mismatch and its derivatives."""
        transitions = self.transitions(self.nodes(z), self.constants(z))
        return CycleLinearisation(*transitions, gauge_conditions(self, z))

    def aligned(self, guess: Array, known: Array) -> Array:
        """Return a guess whose phase is that of a cycle nearby."""
        return aligned_cycle(self, guess, known)


def all_multipliers(others: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return the multipliers of a cycle with that of the flow's own direction, shape (n,).

    Shapes: others (n - 1,).
    """
    return np.insert(others, int(np.count_nonzero(np.abs(others) > 1)), 1.0)


def gauge_conditions(problem: Shooting, z: Array) -> Conditions:
    """Return the condition that steps are orthogonal to the flow, which is always met."""
    return Conditions(np.zeros(1), flow_direction(problem, z)[None])


def flow_direction(problem: Shooting, z: Array) -> Array:
    """Return the unit vector along which a cycle is shifted by beginning it later; zero at rest."""
    steps: Array = np.arange(problem.segments, dtype=float)
    phases: Array = problem.phase + steps * (problem.period / problem.segments)
    rates = problem.flow.rates(problem.nodes(z), phases, problem.constants(z)) / problem.scales
    size = float(np.linalg.norm(rates)) or 1.0
    return np.concatenate([rates.ravel() / size, np.zeros(len(problem.units))])


def aligned_cycle(problem: Shooting, guess: Array, known: Array) -> Array:
    """Return a guess whose phase is that of a cycle nearby.

    Corrections leave the phase as it is in the guess, and extrapolation would magnify small
    differences from one cycle to the next. Between aligned cycles lies no motion along the flow,
    to the third order of their distance.
    """
    for _ in range(ALIGNMENTS):
        direction = flow_direction(problem, 0.5 * (guess + known))
        guess = guess - (direction @ (guess - known)) * direction
    return guess


class CycleLinearisation(Linearisation):
    """Mismatch of a cycle and its derivatives."""

    @cached_property
    def monodromy(self) -> Array:
        """The same on the quotient by the flow's direction, shape (n - 1, n - 1)."""
        assert self.conditions.gradients is not None
        n = self.blocks.shape[1]
        return on_quotient(self.product, self.conditions.gradients[0, :n])


def on_quotient(matrix: Array, direction: Array) -> Array:
    """Return a matrix on the quotient of the space by one of its eigenvectors.

    Shapes: matrix (n, n); direction (n,); returns (n - 1, n - 1).
    """
    basis = quotient_basis(direction)
    return np.asarray(basis.T @ matrix @ basis)


def quotient_basis(direction: Array) -> Array:
    """Return an orthonormal basis of what is orthogonal to a direction, shape (n, n - 1).

    Shapes: direction (n,).
    """
    return np.asarray(np.linalg.qr(direction[:, None], mode="complete")[0][:, 1:])
