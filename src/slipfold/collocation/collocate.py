"""Collocation of an orbit on a mesh that adapts itself until halving it changes nothing."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.collocation.collocated_orbit import CollocatedOrbit
from slipfold.collocation.condensation import Iterate
from slipfold.collocation.mesh import equidistribute, halve, uniform
from slipfold.collocation.multipliers import (
    cycle_multipliers,
    multiplier_difference,
    product_eigenvalues,
)
from slipfold.collocation.newton import Solution, solve
from slipfold.collocation.reference import Reference, reference_of
from slipfold.collocation.vector_field import VectorField
from slipfold.collocation_points import gauss_points
from slipfold.models.model import Model
from slipfold.models.turns import NO_TURNS, turns_between

DEGREE = 6
"""Gauss points an interval: errors at its ends fall with the 12th power of its length, so that
1e-10 needs few intervals, and the blocks to be solved stay small."""

INTERVALS = 16
"""Intervals a forcing period to begin with."""

LARGEST = 1024
"""Intervals a forcing period at most."""

TOLERANCE = 1e-10
"""Difference to the result on half as many intervals, whose error is 2^12 times as large."""


@dataclass(frozen=True, eq=False)
class Guess:
    """A periodic function near the orbit."""

    period: int  # period of the orbit in units of phase
    samples: Array  # scaled states at equidistant phases, shape (count, n)
    time: float  # seconds in a unit of phase
    # Whole turns of angles in scaled states, zero for other states, shape (n,)
    turns: Array = field(default_factory=lambda: NO_TURNS)

    def on(self, edges: Array, degree: int) -> Iterate:
        """Interpolate to a mesh. Shapes: edges (N + 1,)."""
        from scipy.interpolate import CubicSpline

        phases = np.linspace(0.0, self.period, len(self.samples) + 1)
        closed = np.concatenate([self.samples, self.samples[:1]])
        jumps = turns_between(np.diff(closed, axis=0), self.turns) * self.turns
        rise = -jumps.sum(axis=0) / self.period  # of angles that turn round
        closed[1:] -= np.cumsum(jumps, axis=0)
        closed -= rise * phases[:, None]
        spline = CubicSpline(phases, closed, bc_type="periodic")
        begin = edges[:-1]
        inside = begin[:, None] + np.diff(edges)[:, None] * gauss_points(degree).points
        nodes = spline(begin) + rise * begin[:, None]
        return Iterate(edges, nodes, spline(inside) + rise * inside[..., None], self.time)


@dataclass(frozen=True, eq=False)
class Collocated:
    """The solution on one mesh with what follows from it."""

    solution: Solution  # what Newton's method came to
    multipliers: NDArray[np.complex128]  # shape (n,), largest modulus first

    def difference(self, other: Collocated) -> float:
        """Return how far the result on twice as many intervals is from this one."""
        coarse, fine = self.solution.iterate, other.solution.iterate
        size = max(1.0, float(np.abs(other.multipliers).max()))
        return max(
            float(np.abs(coarse.nodes - fine.nodes[::2]).max()),
            abs(coarse.time / fine.time - 1),
            multiplier_difference(self.multipliers, other.multipliers) / size,
        )


def on_mesh(field: VectorField, guess: Iterate, reference: Reference) -> Collocated:
    """Solve on one mesh."""
    solution = solve(field, guess, reference)
    if reference.rates is None:
        return Collocated(solution, product_eigenvalues(solution.matrices))
    iterate = solution.iterate
    rates = field.linear(iterate.nodes, iterate.edges[:-1])[0]
    trivial, others = cycle_multipliers(solution.matrices, rates)
    larger = int(np.count_nonzero(np.abs(others) > 1))
    return Collocated(solution, np.insert(others, larger, trivial))


def collocate(
    model: Model,
    samples: Array,
    period: int = 1,
    *,
    anchors: int = 8,
    degree: int = DEGREE,
    singular: bool = False,
) -> CollocatedOrbit:
    """Find the periodic orbit near a guess, and its multipliers.

    Polynomials of degree m on each interval meet the equations at its m Gauss points (de Boor and
    Swartz, SIAM Journal on Numerical Analysis 10 (1973) 582-606): the states at the edges, the
    duration and the multipliers have errors of order 2 m. The mesh is adapted, then halved until
    that no longer changes the result.

    Shapes: samples (count, n_states).

    >>> from slipfold.models import model_named
    >>> angles = 2 * np.pi * np.arange(16)[:, None] / 16
    >>> circle = np.hstack([np.cos(angles), np.sin(angles)])
    >>> orbit = collocate(model_named("stuart-landau", r=1, w=1, duration=6), circle)
    >>> round(orbit.duration / np.pi, 10)
    2.0
    """
    field = VectorField(model)
    guess = Guess(period, samples / field.scales, field.period, field.turns)
    reference = reference_of(field, guess.samples[:: len(samples) // anchors], singular)
    edges = uniform(period, INTERVALS * period, anchors)
    fine, best = on_mesh(field, guess.on(edges, degree), reference), np.inf
    while True:
        if fine.solution.converged:
            edges = _adapted(field, fine, len(edges) - 1, anchors)
        coarse = on_mesh(field, guess.on(edges, degree), reference)
        edges = halve(edges)
        fine = on_mesh(field, guess.on(edges, degree), reference)
        both = coarse.solution.converged and fine.solution.converged
        error = coarse.difference(fine) if both else np.inf
        settled = error < TOLERANCE
        stalled = both and error > best / 2
        if settled or stalled or len(edges) > LARGEST * period:
            return _as_orbit(fine, field, reference, period, error, settled)
        best = error


def _adapted(field: VectorField, collocated: Collocated, count: int, anchors: int) -> Array:
    iterate = collocated.solution.iterate
    slopes = iterate.time * field.linear(iterate.stages, iterate.phases)[0]
    gauss = gauss_points(iterate.stages.shape[1])
    return equidistribute(iterate.edges, slopes, gauss, count, anchors)


def _as_orbit(
    collocated: Collocated,
    field: VectorField,
    reference: Reference,
    period: int,
    error: float,
    settled: bool,
) -> CollocatedOrbit:
    solution = collocated.solution
    iterate = solution.iterate
    states = iterate.nodes * field.scales
    return CollocatedOrbit(
        field.model,
        period,
        iterate.edges,
        states,
        states[reference.places(iterate.edges)],
        iterate.time * period,
        collocated.multipliers,
        solution.mismatch,
        error,
        settled,
    )
