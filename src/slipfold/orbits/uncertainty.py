"""How far an orbit and its multipliers can be trusted: computed again, and what rounding can do."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.continuation.newton import correct
from slipfold.errors import BREAKDOWNS
from slipfold.flow.equations import power_of_two
from slipfold.flow.flow import flow_of
from slipfold.models.model import Model
from slipfold.orbits.continued import (
    ROUNDING,
    by_mesh_shooting,
    hold_parameter,
    on_mesh,
    parameter_rounding,
)
from slipfold.orbits.discretization import RADAU, is_stiff, scheme_for
from slipfold.orbits.kinds import orbits_at
from slipfold.orbits.modal_shooting import ModalShooting, shooting_for
from slipfold.orbits.multipliers import product
from slipfold.orbits.orbit_curve import OrbitCurve, OrbitPoint
from slipfold.orbits.test_functions import floquet_multipliers, match_multipliers

SPREAD = 2.0
"""Two computations differ by a sample of both their errors; one twice as large is no surprise."""


def multiplier_rounding(monodromy: Array, multipliers: NDArray[np.complex128]) -> Array:
    r"""Return what rounding of the monodromy matrix can do to each multiplier, shape (n,).

    An eigenvalue with left and right vectors l, r moves by :math:`|l| |r| / |l^* r|` times the
    change of the matrix, n roundings of its norm; where that grows without bound, two eigenvalues
    meet and part like the square root of the change.
    """
    change = len(monodromy) * ROUNDING * max(1.0, float(np.linalg.norm(monodromy, 2)))
    try:
        values, right = np.linalg.eig(monodromy)
    except np.linalg.LinAlgError:
        return np.full(len(multipliers), np.inf)
    with np.errstate(all="ignore"):  # where two eigenvectors are one, lengths overflow
        try:
            left = np.linalg.inv(right)  # rows; the columns on the right have unit length
            lengths = np.linalg.norm(left, axis=1)
        except np.linalg.LinAlgError:
            lengths = np.full(len(right), np.inf)
        moved = np.fmin(change * lengths, np.sqrt(change))
    nearest = np.abs(multipliers[:, None] - values[None, :]).argmin(axis=1)
    return np.asarray(moved[nearest], dtype=float)


def multiplier_change(
    values: NDArray[np.complex128], others: NDArray[np.complex128], monodromy: Array
) -> Array:
    """Return how uncertain multipliers are that were computed twice, shape (n,)."""
    change = np.abs(values - match_multipliers(values, others))
    return SPREAD * change + multiplier_rounding(monodromy, values)


def recomputed(curve: OrbitCurve, point: OrbitPoint) -> tuple[OrbitPoint | None, float]:
    """Compute a point of a curve with other errors in every step, or smaller ones if possible.

    Also what rounding can do to its last parameter. None if that fails: nothing is known then.
    """
    try:
        exact = by_mesh_shooting(curve, point)
        if exact is None:
            other, guess, row = curve.shifted(point.z, point.tangent)
            correction = correct(other, guess, row)
            if not correction.converged:
                return None, np.inf
            again, bordered = other.point(correction, point.arclength), correction.bordered
        else:
            _, again = exact
            if again.linearization is None:  # a cycle of no amplitude
                return None, np.inf
            bordered = again.linearization.bordered(again.tangent)
        return again, parameter_rounding(bordered, again.z)
    except BREAKDOWNS:
        return None, np.inf


def multiplier_uncertainty(
    model: Model, parameters: Array, nodes: Array, period: int, multipliers: NDArray[np.complex128]
) -> Array:
    """Return how much each multiplier moves when the monodromy matrix is computed again.

    The second computation begins half a segment later, so that every step of the integrator falls
    elsewhere. The multipliers are the same in exact arithmetic; what differs is their error.

    Shapes: parameters (n_orbits, n_parameters); nodes (n_orbits, m, n_states); multipliers
    (n_orbits, n_states); returns (n_orbits, n_states).
    """
    if shooting_for(model) is ModalShooting:
        again = [_by_modes(model, *given, period) for given in zip(parameters, nodes, strict=True)]
        return _changes(multipliers, np.array(again))
    flow, scales = flow_of(model), model.state_scales()
    constants = flow.constants(parameters, power_of_two(scales))
    jacobian = flow.jacobians(nodes[0, :1], np.zeros(1), constants.rows(np.zeros(1, dtype=np.intp)))
    if scheme_for(jacobian).points.damps and is_stiff(jacobian[0]):
        given = zip(parameters, nodes, strict=True)
        again = [_by_collocation(model, *each, period) for each in given]
        changes = _changes(multipliers, np.array(again))
        # Radau points damp away what an interval does not resolve.
        unresolved = np.exp(-RADAU.decays * period)
        known = np.abs(multipliers) >= unresolved
        return np.where(known, changes, np.maximum(changes, unresolved))
    # The same segment of all orbits in one batch: lanes take about as many steps each.
    segments, orbits = (index.ravel() for index in np.indices(nodes.shape[1::-1]))
    own, length = constants.rows(orbits), period / nodes.shape[1]
    start = segments * length
    states = flow.advance(nodes[orbits, segments], start, start + length / 2, own)
    still = np.zeros((constants.values.shape[1], 1))
    blocks = flow.linearize(states, start + length / 2, start + 1.5 * length, own, still)[1]
    blocks = blocks.reshape(nodes.shape[1], *nodes.shape[::2], -1) * (scales / scales[:, None])
    monodromies = blocks[0]
    for block in blocks[1:]:
        monodromies = block @ monodromies
    return _changes(multipliers, monodromies)


def _by_modes(model: Model, parameters: Array, nodes: Array, period: int) -> Array:
    """Return the monodromy matrix of an orbit by modal shooting, over a mesh of its own.

    Shapes: parameters (n_p,); nodes (m, n); returns (n, n).
    """
    n, constants = nodes.shape[1], flow_of(model).constants(parameters)
    by = ModalShooting(model, {model.parameters[0].name: 1.0}, period, len(nodes))
    by = by.better(nodes, constants) or by
    other, nodes, _ = by.shifted(nodes, constants, np.zeros((len(nodes), n)), np.zeros(1))
    return product(other.transitions(nodes, constants)[1])


def _by_collocation(model: Model, parameters: Array, nodes: Array, period: int) -> Array:
    """Return the monodromy matrix of an orbit by collocation, on a finer mesh than one that fits.

    Shapes: parameters (n_p,); nodes (m, n); returns (n, n).
    """
    names = [parameter.name for parameter in model.parameters]
    own = model.replace(**dict(zip(names, parameters.tolist(), strict=True)))
    shot = orbits_at(own, period, len(nodes))
    orbits, z = on_mesh(shot, shot.unknown(nodes, own))
    other, finer, _ = orbits.shifted(z, hold_parameter(len(z) - 1))
    return product(other.by.transitions(other.nodes(finer), other.constants(finer))[1])


def _changes(multipliers: NDArray[np.complex128], monodromies: Array) -> Array:
    """Return how multipliers differ from those of other matrices. Shapes: (k, n), (k, n, n)."""
    result = np.full(multipliers.shape, np.inf)
    for row in np.flatnonzero(np.isfinite(monodromies).all(axis=(1, 2))):
        others = floquet_multipliers(monodromies[row])
        result[row] = multiplier_change(multipliers[row], others, monodromies[row])
    return result
