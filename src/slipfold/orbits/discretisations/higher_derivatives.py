"""Second and third derivatives of the ends of intervals, through the system that solves them."""

from __future__ import annotations

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.implicit.intervals import Field, Solved


def curved_ends(field: Field, solved: Solved, pulled: Array, vector: Array) -> tuple[Array, Array]:
    """Return the derivatives of the ends' change along a vector, by nodes and parameters."""
    along = solved.equations.along(vector)
    bent, mixed = field.curvatures(solved.stages, solved.phases, along)
    pushes = np.concatenate([bent @ solved.moved, bent @ pulled + mixed], axis=3)
    ends = solved.answered(pushes)[1]
    n = vector.shape[1]
    return ends[:, :, :n], ends[:, :, n:]


def cubed_ends(field: Field, solved: Solved, vector: Array) -> Array:
    """Return the third derivatives of the ends along a vector, from those of the rates."""
    first = solved.equations.along(vector)
    bent = field.curvatures(solved.stages, solved.phases, first)[0]
    second = solved.answered(bent @ first[..., None])[0]
    cubes = field.cubes(solved.stages, solved.phases, first)[..., None]
    return solved.answered(cubes + 3 * bent @ second)[1][..., 0]
