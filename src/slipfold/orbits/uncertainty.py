"""How far multipliers can be trusted: the orbit integrated anew with other steps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.models.model import Model
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.floquet import floquet_multipliers, match_multipliers

__all__ = ["multiplier_uncertainty"]

Array = NDArray[np.float64]


def multiplier_uncertainty(
    model: Model,
    parameters: Array,
    nodes: Array,
    period: int,
    multipliers: NDArray[np.complex128],
) -> Array:
    """Return how much each multiplier moves when the monodromy matrix is computed anew.

    The second computation begins half a segment later, so that every step of the integrator falls
    elsewhere. The multipliers are the same in exact arithmetic; what differs is their error.

    Parameters
    ----------
    model
        The model; its parameter values play no part.
    parameters
        Parameter vectors, shape (n_orbits, n_parameters).
    nodes
        Orbits, shape (n_orbits, m, n_states).
    period
        Period in forcing periods.
    multipliers
        What is to be judged, shape (n_orbits, n_states): the derivatives they came from may have
        been taken a little beside the orbit, which counts as their error as well.

    Returns
    -------
    ndarray, shape (n_orbits, n_states)
        In the order of the multipliers.
    """
    names = [item.name for item in model.parameters]
    result = np.empty((len(nodes), nodes.shape[2]))
    for i, (vector, orbit) in enumerate(zip(parameters, nodes, strict=True)):
        vary = names[0]
        exact = model.replace(**dict(zip(names, vector, strict=True)))
        problem = PeriodicProblem(exact, vary, period, 1.0, len(orbit))
        z = problem.pack(orbit, vector[0])
        fixed = np.zeros(len(z))
        fixed[-1] = 1.0
        values = multipliers[i]
        other, moved, _ = problem.shifted(z, fixed)
        again = other.linearise(moved)
        others = match_multipliers(values, floquet_multipliers(again.monodromy))
        result[i] = np.abs(values - others)
    return result
