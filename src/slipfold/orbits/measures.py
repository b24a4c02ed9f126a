"""Derivatives of what is measured of an output over an orbit: its maximum, minimum and range."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.newton import SquareMatrix
from slipfold.orbits.critical import slope_along
from slipfold.orbits.linearization import Conditions, Linearization
from slipfold.orbits.orbit_curve import Orbits
from slipfold.orbits.switched_shooting import DIFFERENCED


@dataclass(frozen=True)
class MeasureSettings:
    """Where the phase of an extremum over an orbit is searched, and how exactly."""

    samples: int = 64  # a forcing period or round, besides the nodes: they find the right hump
    exact: float = 1e-13  # phases to which it is located: the derivatives have as many digits
    # Phases beside it at which derivatives are taken: the error goes with the square
    aside: float = 1e-7


SEARCH = MeasureSettings()

WEIGHTS = {"max": {1: 1.0}, "min": {-1: 1.0}, "peak_to_peak": {-1: -1.0, 1: 1.0}}
"""Weights of minimum (-1) and maximum (1) in each measure."""


def measure_gradient(orbits: Orbits, z: Array, measure: str, output: str) -> Array:
    """Return the derivatives of a measure of an output over an orbit by its unknown, shape (u,).

    The phase of an extremum moves as well, but where the output is smooth this has no effect of
    first order. At a corner, where contacts change, it has one: derivatives are taken on both sides
    and weighed so that the rates of the output cancel.
    """
    along = _Along(orbits, z, output)
    return np.sum([w * along.gradient(sign) for sign, w in WEIGHTS[measure].items()], axis=0)


@dataclass(frozen=True)
class Extremal:
    r"""That a measure has an extremum along the branch on which one of two parameters is held.

    With its gradient a and the unit tangent of that branch

    .. math:: g = a^T \tau / |a| = 0, \qquad F_z \tau = 0, \quad \tau_{held} = 0 .
    """

    measure: str
    output: str
    held: int  # place of the parameter that the branch holds in the unknown, counted from its end

    def value(self, orbits: Orbits, plain: Linearization, z: Array) -> float:
        """Return how far it is from being met: a cosine."""
        gradient = measure_gradient(orbits, z, self.measure, self.output)
        return float(gradient @ self._branch(plain, len(z))[0] / np.linalg.norm(gradient))

    def conditions(self, orbits: Orbits, plain: Linearization, z: Array) -> Conditions:
        """Return the same with its derivatives where it is met.

        The tangent turns by what second derivatives along it make of it. They are differences of
        first ones: of all in one step, since second derivatives are symmetric.
        """
        gradient = measure_gradient(orbits, z, self.measure, self.output)
        tangent, bordered = self._branch(plain, len(z))
        size, step = float(np.linalg.norm(gradient)), DIFFERENCED * tangent
        weights = bordered.solve_transposed(gradient)[: orbits.size]
        sides = [
            measure_gradient(orbits, z + way * step, self.measure, self.output) for way in (1, -1)
        ]
        slope = (sides[0] - sides[1]) / (2 * DIFFERENCED)
        slope -= weights @ slope_along(orbits, z, tangent)[: orbits.size]
        return Conditions(np.array([gradient @ tangent / size]), slope[None] / size)

    def _branch(self, plain: Linearization, size: int) -> tuple[Array, SquareMatrix]:
        """Return the unit tangent of the branch, turned so that it is smooth, with its equations.

        With it as their last row these have a positive determinant. Shapes: returns (u,).
        """
        holds = np.eye(1, size, size + self.held)
        above = plain.conditions.gradients
        gradients = holds if above is None else np.vstack([above, holds])
        values = np.append(plain.conditions.values, 0.0)
        branch = replace(plain, conditions=Conditions(values, gradients))
        # A vector along no axis of anything leaves the kernel if one does.
        tangent = branch.bordered(np.cos(np.arange(1.0, size + 1))).tangent()
        bordered = branch.bordered(tangent)
        return bordered.sign * tangent, bordered


class _Along:
    """An output along an orbit."""

    def __init__(self, orbits: Orbits, z: Array, output: str) -> None:
        self._orbits, self._by, self._output = orbits, orbits.by, output
        self._nodes, self._constants = orbits.nodes(z), orbits.constants(z)
        self._directions = self._constants.rates[:, self._by.indices]

    def gradient(self, sign: int) -> Array:
        """Return the derivatives of the minimum (-1) or maximum (1), shape (u,)."""
        orbits, (n, size) = self._orbits, (len(self._orbits.scales), self._orbits.size)
        around = self._phase_of(sign) + np.array([-SEARCH.aside, SEARCH.aside])
        phases = self._by.before(around)[1]
        reached = self._by.propagate_to(self._nodes, self._constants, phases)
        rows, speeds = np.zeros((2, size + len(orbits.units))), np.zeros(2)
        scales = orbits.scales * np.sqrt(orbits.segments)
        for i, (node, state, matrix, vectors) in enumerate(zip(*reached, strict=True)):
            by_state, by_free, speeds[i] = self._slopes(state, float(phases[i]))
            rows[i, node * n : (node + 1) * n] = by_state @ matrix * scales
            rows[i, size:] = (by_state @ vectors + by_free) * orbits.units
        turns = speeds[0] * speeds[1] < 0
        weights = np.abs(speeds[::-1]) / np.abs(speeds).sum() if turns else np.full(2, 0.5)
        return np.asarray(weights @ rows)

    def _phase_of(self, sign: int) -> float:
        """Return the phase of the minimum (-1) or maximum (1)."""
        from scipy.optimize import brentq

        by = self._by
        even = np.arange(SEARCH.samples * by.period) / SEARCH.samples
        phases = np.sort(np.append(by.phase + even, by.start))
        phases = phases[np.diff(phases, append=np.inf) > SEARCH.aside]
        states = by.states(self._nodes, self._constants, phases)
        values, column = np.empty(len(phases)), by.flow.output_index(self._output)
        for flow, rows in by.flows_at(self._nodes, self._constants, phases):
            found = flow.outputs(states[rows], phases[rows], self._constants)
            values[rows] = found[:, column]
        place = int(np.argmax(sign * values))
        left = phases[place - 1] - (by.period if place == 0 else 0.0)
        right = phases[(place + 1) % len(phases)]
        right += by.period if place == len(phases) - 1 else 0.0

        def speed(phase: float) -> float:
            within = by.before(np.array([phase]))[1]
            (state,) = by.states(self._nodes, self._constants, within)
            return sign * self._slopes(state, float(within[0]))[2]

        if not speed(left) > 0 > speed(right):  # it is constant, or turns at once
            return float(phases[place])
        return float(brentq(speed, left, right, xtol=SEARCH.exact))

    def _slopes(self, state: Array, phase: float) -> tuple[Array, Array, float]:
        """Return the derivatives by a state and by what is free, and the rate. Shapes: state (n,).

        Returns (n,), (k,), ().
        """
        at = np.array([phase])
        ((flow, _),) = self._by.flows_at(self._nodes, self._constants, at)
        slopes = flow.output_slopes(self._output)
        by_state, by_phase, by_free = (
            item[0] for item in slopes.at(state, phase, self._constants, self._directions)
        )
        rates = flow.rates(state[None], at, self._constants)[0]
        return by_state, by_free, float(by_state @ rates + by_phase)
