"""Where two families of orbits cross in two parameters: conditions of a branch point."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from slipfold.arrays import Array
from slipfold.orbits.linearisation import Conditions, Linearisation
from slipfold.orbits.orbit_curve import Orbits

PLANE = 2
"""Parameters that vary: the last columns of the Jacobian."""

STEP = 1e-4
"""Half the distance over which the Jacobian is differenced, in scaled variables. The conditions are
exact; their gradients, right to 1e-8, serve Newton's steps and tangents alone."""


class _Null(NamedTuple):
    """What the Jacobian by the states is singular along, nearly: unit vectors and their value."""

    left: Array
    right: Array
    value: float
    inverse: Array
    """Inverse of the Jacobian beside them."""


def crossing_values(plain: Linearisation) -> Array:
    r"""Return the three numbers that vanish where two families of orbits cross, shape (3,).

    Over two parameters orbits are a surface. Two surfaces cross in a curve, as those of symmetric
    and of other orbits do, where a vector psi is orthogonal to all derivatives of the equations,

    .. math:: \psi^T F_x = 0, \quad \psi^T F_p = 0 .

    With the equations themselves these are two more than a curve needs, and compatible on it: they
    are solved by least squares. Else a branch point is met in one parameter alone.
    """
    return _values(plain, _null(plain))


def _values(plain: Linearisation, null: _Null) -> Array:
    pulled = null.left @ plain.jacobian[:, -PLANE:]
    return np.append(null.value, pulled) / _size(plain)


def crossing_conditions(orbits: Orbits, plain: Linearisation, z: Array) -> Conditions:
    """Return those numbers with their gradients, each a second derivative along one direction.

    The directions are the kernel of the equations' derivatives: the critical vector, and for each
    parameter how orbits move with it beside that.
    """
    null = _null(plain)
    steady = -null.inverse @ plain.jacobian[:, -PLANE:]
    kernel = np.zeros((1 + PLANE, len(z)))
    kernel[0, :-PLANE] = null.right
    kernel[1:, :-PLANE], kernel[1:, -PLANE:] = steady.T, np.eye(PLANE)
    gradients = [null.left @ _along(orbits, z, direction) for direction in kernel]
    return Conditions(_values(plain, null), np.array(gradients) / _size(plain))


def crossing_gap(orbits: Orbits, z: Array) -> float:
    """Return the largest of those numbers: how far an orbit is from such a crossing."""
    return float(np.abs(crossing_values(orbits.linearise(z))).max())


def critical_direction(orbits: Orbits, z: Array) -> Array:
    """Return the unit vector along which the states at a crossing may move, parameters held."""
    return _null(orbits.linearise(z)).right


def _null(plain: Linearisation) -> _Null:
    left, values, right = np.linalg.svd(plain.jacobian[:, :-PLANE])
    inverse = (right[:-1].T / values[:-1]) @ left[:, :-1].T
    one, other = _sign(left[:, -1]), _sign(right[-1])
    return _Null(one * left[:, -1], other * right[-1], float(one * other * values[-1]), inverse)


def _sign(vector: Array) -> float:
    """Return the sign that makes a vector smooth where it turns: that along no axis of anything."""
    return float(np.sign(vector @ np.cos(np.arange(1.0, len(vector) + 1)))) or 1.0


def _size(plain: Linearisation) -> float:
    return float(np.hypot(1.0, np.linalg.norm(plain.jacobian)))


def _along(orbits: Orbits, z: Array, direction: Array) -> Array:
    """Return the derivative of the Jacobian along a direction."""
    length = float(np.linalg.norm(direction))
    step = STEP / length * direction
    ahead, behind = orbits.linearise(z + step).jacobian, orbits.linearise(z - step).jacobian
    return np.asarray((ahead - behind) * (length / (2 * STEP)))
