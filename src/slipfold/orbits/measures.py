"""Derivatives of what is measured of an output over an orbit: extrema, rms, first harmonic."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.newton import WholeMatrix
from slipfold.newton import zero_between
from slipfold.orbits.extrema import AVERAGED
from slipfold.orbits.linearization import Conditions, Linearization
from slipfold.orbits.orbit_curve import Orbits
from slipfold.orbits.switched_shooting import DIFFERENCED


class MEASURE:
    """How the extrema of an output over an orbit are found, and how exactly."""

    samples: int = 64  # a forcing period or round, besides the nodes: they find the right extremum
    exact: float = 1e-13  # phases to which it is located: the derivatives have as many digits
    # Phases beside it at which derivatives are taken: the error goes with the square
    aside: float = 1e-7
    # The same where no corner can lie between, and derivatives are differenced: seven digits
    apart: float = 3e-5
    # Step of differences of smooth derivatives, in scaled variables; near a narrow resonance second
    # derivatives change within a thousandth
    step: float = 3e-5
    borders: int = 3  # times that a system is bordered anew: twice suffice
    # Samples a forcing period of which means are taken at most: they are doubled until the mean
    # changes by no more than this part
    most: int = 1024
    change: float = 1e-12
    points: int = 16  # of a Gaussian rule, between changes of contacts: a quarter of `samples`


WEIGHTS = {"max": {1: 1.0}, "min": {-1: 1.0}, "peak_to_peak": {-1: -1.0, 1: 1.0}}
"""Weights of minimum (-1) and maximum (1) in each measure."""


def mean_of(orbits: Orbits, z: Array, measure: str, output: str) -> float:
    """Return a measure of `AVERAGED` of an output over an orbit."""
    return _Along(orbits, z, output).mean(measure)[0]


def measure_gradient(orbits: Orbits, z: Array, measure: str, output: str) -> Array:
    """Return the derivatives of a measure of an output over an orbit by its unknown, shape (u,).

    The phase of an extremum moves as well, but where the output is smooth this has no effect of
    first order. At a corner, where contacts change, it has one: derivatives are taken on both sides
    and weighed so that the rates of the output cancel.
    """
    along = _Along(orbits, z, output)
    if measure in AVERAGED:
        _, phases, weights = along.mean(measure)
        return np.asarray(weights @ along.rows(phases)[0])
    return np.sum([w * along.extremum(sign).gradient for sign, w in WEIGHTS[measure].items()], 0)


class Extremal:
    r"""That a measure has an extremum along the branch on which one of two parameters is held.

    With its gradient a and a tangent of that branch :math:`F_z \tau = 0, \tau_{held} = 0,
    a^T \tau = 0`: the matrix of these rows is singular. So it is where two branches merge, too,
    which have two tangents: one of them is orthogonal to a.

    `held` is the place of that parameter in the unknown, counted from its end.
    """

    def __init__(self, measure: str, output: str, held: int) -> None:
        self.measure, self.output, self.held = measure, output, held
        self._known: tuple[Array | None, list[_Extremum]] = None, []

    def gradient(self, orbits: Orbits, z: Array) -> Array:
        """Return the derivatives of the measure, shape (u,)."""
        if self.measure in AVERAGED:
            return measure_gradient(orbits, z, self.measure, self.output)
        weights, found = WEIGHTS[self.measure].values(), self._extrema(orbits, z)
        return np.sum([w * item.gradient for w, item in zip(weights, found, strict=True)], 0)

    def value(self, orbits: Orbits, plain: Linearization, z: Array) -> float:
        """Return how far it is from being met: the least singular value, with a sign."""
        return self._least(plain, self.gradient(orbits, z))[0]

    def conditions(self, orbits: Orbits, plain: Linearization, z: Array) -> Conditions:
        """Return the same with its derivatives where it is met.

        Those of the matrix are needed along its right null vector alone. They are differences in
        one step along it, since second derivatives are symmetric.
        """
        gradient = self.gradient(orbits, z)
        value, left, right = self._least(plain, gradient)
        weight = float(left[-1] / np.linalg.norm(gradient))
        slope = self._bent(orbits, z, left, right, weight)
        return Conditions(np.array([value]), slope[None])

    def _least(self, plain: Linearization, gradient: Array) -> tuple[float, Array, Array]:
        """Return the least singular value of the matrix with the sign of the determinant.

        Also its left and right vectors, from systems bordered by their approximations.
        """
        size = len(gradient)
        holds = np.eye(1, size, size + self.held)
        rows = plain.jacobian, holds, gradient[None] / np.linalg.norm(gradient)
        whole, last = np.zeros((size + 1, size + 1)), np.eye(1, size + 1, size)[0]
        whole[:size, :size] = np.concatenate(rows)
        # Vectors along no axis of anything are borders of any matrix.
        left = right = np.append(np.cos(np.arange(1.0, size + 1)), 0.0)
        for _ in range(MEASURE.borders):
            whole[:size, size] = left[:size] / np.linalg.norm(left[:size])
            whole[size, :size] = right[:size] / np.linalg.norm(right[:size])
            bordered = WholeMatrix(whole)
            right, left = bordered.solve(last), bordered.solve_transposed(last)
        sign = bordered.sign if np.isfinite(right).all() else np.nan
        # The row that holds a parameter has no part in this unit: others may be held instead.
        unit = float(np.linalg.norm(np.delete(left[:size], size - 2)))
        return sign * float(right[size]) / unit, -sign * left[:size] / unit, right[:size]

    def _bent(self, orbits: Orbits, z: Array, left: Array, right: Array, weight: float) -> Array:
        """Return the derivative of the rows' sum with weights, along the right vector, shape (u,).

        Extrema that move smoothly are not searched again: their phase goes with the rate.
        """
        mean = self.measure in AVERAGED
        known = [] if mean else self._extrema(orbits, z)
        smooth = orbits.by.smooth if mean else all(item.is_smooth for item in known)
        pairs = [] if mean else list(zip(WEIGHTS[self.measure].items(), known, strict=True))

        def rows(step: float) -> Array:
            there = z + step * right
            along, size = _Along(orbits, there, self.output), orbits.size
            found = [
                share * (along.gradient_at(item.phase) if smooth else along.extremum(sign).gradient)
                for (sign, share), item in pairs
            ] or [self.gradient(orbits, there)]
            whole = left[:size] @ orbits.linearize(there).jacobian[:size]
            return np.asarray(whole + weight * np.sum(found, axis=0))

        step = MEASURE.step if smooth else DIFFERENCED
        result = (rows(step) - rows(-step)) / (2 * step)
        moved = [share * item.moved(right) for (_, share), item in pairs if smooth]
        return result + weight * np.sum(moved, axis=0)

    def _extrema(self, orbits: Orbits, z: Array) -> list[_Extremum]:
        """Return minimum and maximum, as far as they matter, found once for each place in turn."""
        if self._known[0] is not z:
            along = _Along(orbits, z, self.output)
            self._known = z, [along.extremum(sign) for sign in WEIGHTS[self.measure]]
        return self._known[1]


@dataclass(frozen=True, eq=False)
class _Extremum:
    """The extremum of an output along an orbit."""

    phase: float
    gradient: Array  # its derivatives by the unknown, shape (u,)
    change: Array  # what they differ by at two phases beside it, shape (u,)
    turn: float  # what the rate of the output differs by there
    is_smooth: bool  # whether no change of contacts and no node can lie between

    def moved(self, direction: Array) -> Array:
        """Return the change of the gradient by the phase, which moves along a direction."""
        rates = self.change / (2 * MEASURE.apart)
        return np.asarray(
            -rates * (self.change @ direction) / self.turn if self.turn else 0 * rates
        )


class _Along:
    """An output along an orbit."""

    def __init__(self, orbits: Orbits, z: Array, output: str) -> None:
        self._orbits, self._by, self._output = orbits, orbits.by, output
        self._nodes, self._constants = orbits.nodes(z), orbits.constants(z)
        self._directions = self._constants.rates[:, self._by.indices]

    def extremum(self, sign: int) -> _Extremum:
        """Return the minimum (-1) or maximum (1)."""
        phase = self._phase_of(sign)
        around = phase + np.array([-MEASURE.apart, 0.0, MEASURE.apart])
        if self._by.smooth and np.ptp(self._by.before(around)[0]) == 0:
            rows, speeds = self.rows(around)
            change, turn = rows[2] - rows[0], float(speeds[2] - speeds[0])
            return _Extremum(phase, rows[1], change, turn, True)
        rows, speeds = self.rows(phase + np.array([-MEASURE.aside, MEASURE.aside]))
        turns = speeds[0] * speeds[1] < 0
        weights = np.abs(speeds[::-1]) / np.abs(speeds).sum() if turns else np.full(2, 0.5)
        return _Extremum(phase, np.asarray(weights @ rows), rows[1] - rows[0], 0.0, False)

    def gradient_at(self, phase: float) -> Array:
        """Return the derivatives at a phase, shape (u,)."""
        return np.asarray(self.rows(np.array([phase]))[0][0])

    def mean(self, measure: str) -> tuple[float, Array, Array]:
        """Return a mean of the output, the phases of its samples, and its derivatives by these."""
        count, before = MEASURE.samples, np.inf
        while True:
            phases, shares = self._samples(count)
            values = self._values(phases)
            if measure == "rms":
                size = float(np.sqrt(shares @ values**2))
                weights = shares * values / (size or 1.0)
            else:
                turned = 2 * shares * np.exp(-2j * np.pi * phases)
                part = turned @ values
                size = float(abs(part))
                vibrates = size > MEASURE.change * np.abs(values).max()  # else it is rounding
                weights = (np.conj(part) * turned).real * (vibrates / (size or 1.0))
            settled = abs(size - before) <= MEASURE.change * np.abs(values).max()
            if settled or count >= MEASURE.most:
                return size, phases, weights
            count, before = 2 * count, size

    def _samples(self, count: int) -> tuple[Array, Array]:
        """Return phases, about so many a forcing period, and their shares in a mean, (q,), (q,).

        Between changes of contacts they are Gaussian: corners and jumps cost no digits.
        """
        by = self._by
        if by.smooth:
            even = np.arange(count * by.period) / count
            return by.before(by.phase + even)[1], np.full(len(even), 1 / len(even))
        points, shares = np.polynomial.legendre.leggauss(MEASURE.points)
        ends = np.clip(by.changes(self._nodes, self._constants), by.phase, by.phase + by.period)
        edges = np.concatenate([[by.phase], np.sort(ends), [by.phase + by.period]])
        panels = np.ceil(np.diff(edges) * count / MEASURE.points).astype(int)
        begins = np.repeat(edges[:-1], panels)
        lengths = np.repeat(np.diff(edges) / np.maximum(panels, 1), panels)
        begins += lengths * np.concatenate([np.arange(some) for some in panels])
        phases = begins[:, None] + lengths[:, None] * (1 + points) / 2
        return phases.ravel(), (lengths[:, None] * shares / (2 * by.period)).ravel()

    def _values(self, phases: Array) -> Array:
        """Return the output at phases, shape (q,)."""
        by = self._by
        states = by.states(self._nodes, self._constants, phases)
        values, column = np.empty(len(phases)), by.flow.output_index(self._output)
        for flow, rows in by.flows_at(self._nodes, self._constants, phases):
            found = flow.outputs(states[rows], phases[rows], self._constants)
            values[rows] = found[:, column]
        return values

    def rows(self, phases: Array) -> tuple[Array, Array]:
        """Return the derivatives at phases by the unknown, (q, u), and rates of the output, (q,).

        Shapes: phases (q,).
        """
        orbits, (n, size) = self._orbits, (len(self._orbits.scales), self._orbits.size)
        phases = self._by.before(phases)[1]
        reached = self._by.propagate_to(self._nodes, self._constants, phases)
        rows = np.zeros((len(phases), size + len(orbits.units)))
        speeds, scales = np.zeros(len(phases)), orbits.scales * np.sqrt(orbits.segments)
        for i, (node, state, matrix, vectors) in enumerate(zip(*reached, strict=True)):
            by_state, by_free, speeds[i] = self._slopes(state, float(phases[i]))
            rows[i, node * n : (node + 1) * n] = by_state @ matrix * scales
            rows[i, size:] = (by_state @ vectors + by_free) * orbits.units
        return rows, speeds

    def _phase_of(self, sign: int) -> float:
        """Return the phase of the minimum (-1) or maximum (1)."""
        by = self._by
        even = np.arange(MEASURE.samples * by.period) / MEASURE.samples
        phases = np.sort(np.append(by.phase + even, by.start))
        phases = phases[np.diff(phases, append=np.inf) > MEASURE.aside]
        values = self._values(phases)
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
        return zero_between(speed, left, right, MEASURE.exact)

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
