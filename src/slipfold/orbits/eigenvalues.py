"""How the eigenvalues of an equilibrium are seen, as multipliers."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array, Complex
from slipfold.orbits.linearization import Linearization
from slipfold.orbits.multipliers import Multipliers
from slipfold.orbits.test_functions import Degeneracy


class UNIT:
    """The time over which multipliers of equilibria are stated."""

    angle: float = 0.8  # that the fastest rate makes: far from the half turn of a period doubling
    widest: float = 128.0  # ratio of vibrations beyond which the fastest does not set the unit
    vibrates: float = 1e-9  # imaginary part over the fastest rate that rounding may make
    slow: float = 0.1  # norm of a Jacobian below which the unit stops: it is zero at a fold
    slowest: float = 1e-3  # ratio of rates beyond which decay does not set the unit


class Eigenvalues(Multipliers):
    """Eigenvalues of the Jacobian, mapped: the imaginary axis to the unit circle, zero to one."""

    tests = ("fold", "HB")
    of_product = False

    def factors(self, part: Linearization) -> Array:
        """Return the matrix itself: nothing is propagated from one phase to another."""
        return part.monodromy[None]

    gives_unit = False
    """Whether results state multipliers over the unit of time; else over the model's duration."""

    @abstractmethod
    def unit(self, jacobian: Array) -> float:
        """Return the unit of time, in the model's durations. Shapes: jacobian (n, n)."""

    def turn(self, multiplier: complex) -> float:
        """Return how far a mode turns in the unit of time, from its multiplier on the circle."""
        return float(np.angle(multiplier))

    def turned(self, angle: float) -> complex:
        """Return the multiplier of a mode that turns so far in the unit of time."""
        return complex(np.exp(1j * angle))

    def growth(self, part: Linearization) -> float:
        """Return infinity: no bound is computed."""
        return np.inf


class Paced(Eigenvalues):
    r"""Multipliers :math:`e^{\lambda \tau}` of the flow over a unit of time that keeps pace.

    Where eigenvalues turn or grow faster than at the beginning of the branch the unit is shorter,
    so that no angle wraps but of vibrations much faster than others.
    """

    gives_unit = True

    def unit(self, jacobian: Array) -> float:
        """Return the unit of time, in the model's durations."""
        if not np.isfinite(jacobian).all():
            return 1.0
        values = np.linalg.eigvals(jacobian)
        fastest = max(_turning(values), float(values.real.max()))
        return UNIT.angle / max(UNIT.angle, fastest)

    def matrix(self, part: Linearization) -> Array:
        """Return the matrix of the flow over the unit of time."""
        return transition(part.blocks[0] - np.eye(part.blocks.shape[1]))


class Cayley(Eigenvalues):
    r"""The eigenvalues of Cayley's transform, for which no frequency is too high.

    .. math:: M = (I - A)^{-1} (I + A), \quad A = J / (2 r)

    with the Jacobian J in scaled states and its Frobenius norm r, or less beside decay that is much
    faster than all vibrations. It has a derivative, :math:`dM = (I - A)^{-1} dA (I + M)`, in which
    r may be taken as constant: multiplied by any number, eigenvalues on the imaginary axis stay
    there.
    """

    def unit(self, jacobian: Array) -> float:
        """Return the unit of time, in the model's durations."""
        size = float(np.linalg.norm(jacobian))
        if not np.isfinite(size):
            return np.nan
        turning = _turning(np.linalg.eigvals(jacobian)) / UNIT.slowest
        return 1.0 / max(min(size, turning or size), UNIT.slow)

    def turn(self, multiplier: complex) -> float:
        """Return the same: the transform takes i w, over the unit of time, to 2 arctan(w/2)."""
        return 2 * math.tan(np.angle(multiplier) / 2)

    def turned(self, angle: float) -> complex:
        """Return the same, transformed."""
        return (1 + 0.5j * angle) / (1 - 0.5j * angle)

    def matrix(self, part: Linearization) -> Array:
        """Return Cayley's transform of the Jacobian."""
        identity, inside = _halved(part)
        return np.asarray(np.linalg.solve(identity - inside, identity + inside))

    def lifted(self, found: Degeneracy, part: Linearization) -> tuple[Array, Array]:
        """Return the vectors of a function of the matrix as those of one of the Jacobian."""
        identity, inside = _halved(part)
        left = np.linalg.solve((identity - inside).T, found.left.T).T / 2
        return left, found.right @ (identity + part.monodromy).T


def _halved(part: Linearization) -> tuple[Array, Array]:
    """The identity, and half of the Jacobian per unit of time."""
    identity = np.eye(part.blocks.shape[1])
    return identity, (part.blocks[0] - identity) / 2


def eigenvalues_of(jacobian: Array) -> Complex:
    """Return eigenvalues, largest real part first, the upper one of a pair before the lower.

    NaN where rates have no derivatives. Shapes: jacobian (n, n).

    >>> eigenvalues_of(np.full((1, 1), np.nan))
    array([nan+nanj])
    """
    if not np.isfinite(jacobian).all():
        return np.full(len(jacobian), complex(np.nan, np.nan))
    values = np.linalg.eigvals(jacobian).astype(complex)
    # Real parts of a pair differ by rounding.
    real = np.round(values.real / (np.abs(values).max() or 1.0), 12)
    return values[np.lexsort((-values.imag, -real))]


MODE_UNITS = {"growth rate": "1/s", "frequency": "Hz", "damping ratio": ""}
"""What tables say of a mode of an equilibrium, and the units."""


def modes_of(jacobian: Array) -> Array:
    """Return what `MODE_UNITS` names of each pair of eigenvalues and each real one, fastest first.

    Shapes: jacobian (n, n), returns (n_modes, 3).

    >>> modes_of(np.array([[-3.0, 4.0], [-4.0, -3.0]])).round(3)
    array([[-3.   ,  0.637,  0.6  ]])
    """
    if not np.isfinite(jacobian).all():
        return np.empty((0, len(MODE_UNITS)))
    values = eigenvalues_of(jacobian)
    values = values[values.imag >= 0]
    size = np.abs(values)
    damping = np.divide(-values.real, size, out=np.zeros_like(size), where=size > 0)
    return np.column_stack([values.real, values.imag / (2 * math.pi), damping])


def transition(jacobian: Array) -> Array:
    """Return the matrix of the flow over a time, shape (n, n). Shapes: jacobian (n, n)."""
    from scipy.linalg import expm  # a tenth of a second to import, for equilibria alone

    if not np.isfinite(jacobian).all():
        return np.full_like(jacobian, np.nan)
    return np.asarray(expm(jacobian), dtype=float)


def unit_of_time(jacobian: Array, push: Array | None = None) -> float:
    """Return a time over which the multipliers of an equilibrium are well separated, in s.

    At a fold all rates may vanish: there it is set by `push`, the rates at which the change of a
    parameter moves the equilibrium, in scales of the states. Shapes: jacobian (n, n), push (n,).
    """
    if not np.isfinite(jacobian).all():
        return 1.0
    values = np.linalg.eigvals(jacobian)
    sizes = np.sort(np.abs(values))
    rate = max(_turning(values), float(values.real.max()), float(sizes[0]))
    straight = np.abs(values.imag) <= UNIT.vibrates * sizes[-1]
    decay = float(np.abs(values[straight]).max(initial=0.0))
    rate = max(rate, min(decay, rate / UNIT.slowest))
    if push is not None:
        rate = max(rate, _rate_of_motion(jacobian, push, max(rate, UNIT.vibrates * sizes[-1])))
    return UNIT.angle / rate if rate > 0 and math.isfinite(rate) else 1.0


def _rate_of_motion(jacobian: Array, push: Array, least: float) -> float:
    """Return the rate at which a push moves the state far, where fast decay does not oppose it."""
    rate, identity = UNIT.slowest * float(np.abs(push).max()), np.eye(len(jacobian))
    while 2 * least < rate / 2 < np.inf:  # far from any eigenvalue
        moved = np.linalg.solve(rate / 2 * identity - jacobian, push)
        if UNIT.slowest * np.abs(moved).max() > 1:
            break
        rate /= 2
    return rate


def _turning(values: NDArray[Any]) -> float:
    """Return the rate of the fastest vibration that sets the unit of time."""
    turning = np.abs(values.imag)
    moving = turning[turning > UNIT.vibrates * np.abs(values).max()]
    return float(min(moving.max(), UNIT.widest * moving.min())) if len(moving) else 0.0
