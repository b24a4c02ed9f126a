"""The equilibrium near a state of an autonomous model, and how it leaves it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.sizes.own_sizes import unfed_states
from slipfold.models.equilibria import damped_newton
from slipfold.models.evaluation import evaluation_of
from slipfold.models.model import Model

AT_REST = 1e-9
"""A state this near to an equilibrium, in scaled states, is there: Newton's method finds it to
1e-13, and users write starts with a dozen digits."""

PUSH = 1e-6
"""How far a motion is pushed off an unstable equilibrium, in scaled states: so little that it
leaves as the linearised equations say, far more than rounding."""

NEUTRAL = 1e-9
"""Growth, over the fastest rate, that rounding may feign."""


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """An equilibrium with its fastest growth."""

    state: Array  # shape (n,)
    distance: float  # how far the state is from which it was found, in scaled states
    # Largest real part of an eigenvalue, in 1/s; zero where it is no more than rounding
    growth: float
    # Real part of the eigenvector of that eigenvalue, of length one in scaled states
    direction: Array


def equilibrium_near(model: Model, state: Array) -> Equilibrium | None:
    """Return the equilibrium that Newton's method finds from a state, None if it finds none.

    Shapes: state (n,).
    """
    functions, scales = evaluation_of(model), model.state_scales()
    found = damped_newton(functions.linear_of(model), state[None], scales)[0]
    if np.isnan(found).any():
        return None
    jacobian = functions.jacobian(model, found) * (scales / scales[:, None])
    if not np.isfinite(jacobian).all():
        return None
    values, vectors = np.linalg.eig(jacobian)
    fastest = int(values.real.argmax())
    growth = float(values[fastest].real)
    if abs(growth) <= NEUTRAL * float(np.abs(values).max()):
        growth = 0.0
    direction = vectors[:, fastest].real
    # Its largest component is positive: always the same of two directions.
    direction *= np.sign(direction[np.abs(direction).argmax()]) / np.linalg.norm(direction)
    distance = float(np.abs((found - state) / scales).max())
    return Equilibrium(found, distance, growth, direction)


def pushed_off(model: Model, state: Array) -> Array | None:
    """Return a state beside an unstable equilibrium that a motion would sit on for ever.

    Shapes: state (n,); returns (n,).
    """
    scales = model.state_scales()
    functions = evaluation_of(model)
    rates, jacobian = functions.rates(model, state), functions.jacobian(model, state)
    if not (np.isfinite(rates).all() and np.isfinite(jacobian).all()):
        return None
    # Newton's step says how far away it is: this is cheap enough to be asked often.
    away = np.linalg.lstsq(jacobian * (scales / scales[:, None]), rates / scales, rcond=None)[0]
    if np.abs(away).max() > AT_REST:
        return None
    rest = equilibrium_near(model, state)
    if rest is None or rest.growth <= 0 or rest.distance > AT_REST or _leaves(model, state, rest):
        return None
    return state + PUSH * scales * rest.direction


def _leaves(model: Model, state: Array, rest: Equilibrium) -> bool:
    """Whether what nothing feeds, however little there is of it, grows back by itself."""
    jacobian = evaluation_of(model).jacobian(model, rest.state)
    for group in map(list, unfed_states(model)):
        growth = np.linalg.eigvals(jacobian[np.ix_(group, group)]).real.max()
        if np.any(state[group] != 0) and growth > 0:
            return True
    return False
