"""Many orbits of one model corrected at once: their segments side by side in the lanes of the flow.

One orbit after the other fills the lanes with its own segments and pays for each call.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.continuation.newton import Rule, correct_many, solve_each
from slipfold.flow import Flow
from slipfold.flow.scaled import power_of_two
from slipfold.models.model import Model
from slipfold.models.turns import NO_TURNS, without_turns
from slipfold.orbits.carry_to import hold_parameter
from slipfold.orbits.forced_orbits import ForcedOrbits
from slipfold.orbits.linearisation import Linearisation

__all__ = ["Corrected", "correct_orbits", "orbits_from", "transitions"]

Array = NDArray[np.float64]

LAST_CORRECTION = 1e-6
"""A correction shorter than this is the last: as Newton's method squares it, what is left is below
1e-10. The derivatives, taken before it, are good to about ten times its length."""

LONGEST_CORRECTION = 0.5
"""A correction this long, in scaled variables, leads to another branch."""

ITERATIONS = 6


def transitions(
    flow: Flow,
    nodes: Array,
    vectors: Array,
    scales: Array,
    free: list[int],
    units: Array,
    period: int = 1,
    whole: Array = NO_TURNS,
) -> tuple[Array, Array, Array]:
    """Return mismatch and derivatives of all segments' ends, each orbit in its scaled states.

    `vectors` are the parameters of each orbit, `units` the scales of those that are `free`; `whole`
    is what a turn of each state is.

    Shapes: nodes (k, m, n); vectors (k, n_p); scales (k, n); units (f,); returns mismatch
    (k, m, n), blocks (k, m, n, n), along (k, m, n, f).
    """
    k, m, n = nodes.shape
    constants = flow.constants(vectors, power_of_two(scales))
    edges = np.arange(m + 1) * (period / m)
    ends, blocks, along = flow.linearise(
        nodes.reshape(k * m, n),
        np.tile(edges[:-1], k),
        np.tile(edges[1:], k),
        constants.repeated(m),
        np.repeat(constants.rates[:, :, free], m, axis=0),
    )
    following = np.roll(nodes, -1, axis=1)
    return (
        without_turns(ends.reshape(k, m, n) - following, whole) / scales[:, None],
        blocks.reshape(k, m, n, n) * (scales[:, None, :] / scales[:, :, None])[:, None],
        along.reshape(k, m, n, -1) * (units / scales[:, None, :, None]),
    )


@dataclass(frozen=True, eq=False)
class Corrected:
    """Orbits of one period."""

    z: Array  # unknowns, shape (k, m n + 1); NaN where Newton's method failed
    # Monodromy matrices in scaled states, taken within the last correction of `z`, shape (k, n, n)
    monodromies: Array
    # Unit tangents of the branch, along the rows of the hyperplanes, shape (k, m n + 1)
    tangents: Array

    def some(self, rows: list[int]) -> Corrected:
        """Return some of the orbits."""
        return Corrected(self.z[rows], self.monodromies[rows], self.tangents[rows])

    @property
    def found(self) -> NDArray[np.bool_]:
        """Whether each orbit was found, shape (k,)."""
        return np.asarray(np.isfinite(self.z).all(axis=1))


def correct_orbits(
    orbits: ForcedOrbits, guesses: Array, rows: Array, close: float = LAST_CORRECTION
) -> Corrected:
    """Find the orbits of one branch nearest guesses, each in the hyperplane through it.

    Shapes: guesses, rows (k, m n + 1).
    """
    k, size = guesses.shape
    n = len(orbits.scales)
    monodromies, tangents = np.full((k, n, n), np.nan), np.full((k, size), np.nan)

    def steps(some: NDArray[np.int64], z: Array) -> Array:
        parts = _linearise(orbits, z)
        monodromies[some] = [part.monodromy for part in parts]
        matrices = [part.bordered(row).matrix for part, row in zip(parts, rows[some], strict=True)]
        right = np.zeros((len(some), size, 2))
        right[:, :-1, 0] = [-part.defect for part in parts]
        right[:, -1, 0] = np.einsum("ka,ka->k", rows[some], guesses[some] - z)
        right[:, -1, 1] = 1.0
        solved = solve_each(np.array(matrices), right)
        tangents[some] = solved[:, :, 1] / np.linalg.norm(solved[:, :, 1], axis=1)[:, None]
        return np.asarray(solved[:, :, 0])

    rule = Rule(close, LONGEST_CORRECTION, iterations=ITERATIONS)
    return Corrected(correct_many(steps, guesses, rule).z, monodromies, tangents)


def orbits_from(model: Model, period: int, states: Array) -> list[Array | None]:
    """Return the nodes of the stable orbits of a period that states nearly repeat on.

    Shapes: states (k, n); returns k times (m, n), None where there is none.
    """
    orbits = ForcedOrbits(model, {model.parameters[0].name: 1.0}, period)
    zero = np.zeros(len(states))
    constants = orbits.flow.constants_of(model)
    nodes = orbits.flow.sample(states, zero, zero + period, orbits.segments, constants)
    found: list[Array | None] = [None] * len(states)
    passed = np.flatnonzero(np.isfinite(nodes).all(axis=(1, 2)))
    if not len(passed):
        return found
    guesses = np.array([orbits.unknown(item, model) for item in nodes[passed]])
    rows = np.tile(hold_parameter(orbits.size), (len(passed), 1))
    corrected = correct_orbits(orbits, guesses, rows)
    for i, k in enumerate(passed):
        if corrected.found[i] and np.abs(np.linalg.eigvals(corrected.monodromies[i])).max() < 1:
            found[k] = orbits.nodes(corrected.z[i])
    return found


def _linearise(orbits: ForcedOrbits, z: Array) -> list[Linearisation]:
    """Return mismatch and derivatives of each orbit."""
    residual, blocks, along = transitions(
        orbits.flow,
        np.array([orbits.nodes(item) for item in z]),
        np.array([orbits.vector(item) for item in z]),
        np.tile(orbits.scales, (len(z), 1)),
        orbits.indices,
        orbits.units / np.sqrt(orbits.segments),
        orbits.period,
        orbits.model.whole_turns,
    )
    return [Linearisation(*item) for item in zip(residual, blocks, along, strict=True)]
