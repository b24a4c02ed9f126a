"""Equilibria of a model, by Newton's method from its start or from states around it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from slipfold.arrays import Array, Indices
from slipfold.errors import InputError
from slipfold.models.angles import distances, wrap_angles
from slipfold.models.model import Model, evaluation_of
from slipfold.newton import solve_each


def check_followed(model: Model) -> None:
    """Refuse parameter values without steady sliding."""
    for item in model.variable_parameters:
        try:
            item.check(model.values[item.name])
        except InputError as error:
            raise InputError(
                f"{error} unless it is simulated; without forcing a contact that rests would stick "
                "for ever: give a law such as Jenkins or Regularized"
            ) from None
    for name in model.resting:
        raise InputError(
            f"the slip of the contact {name} is zero or swings where states are zero; "
            "give its surface a constant speed other than zero, count states from steady sliding, "
            "so that this speed is in the slip, as in Vd - v, or simulate"
        )


def damped_newton(
    linear: Callable[[Array, Indices], tuple[Array, Array]],
    starts: Array,
    scales: Array,
    *,
    iterations: int = 60,
    halvings: int = 30,
    tolerance: float = 1e-13,
    rounding: float = 1e-8,
) -> Array:
    """Find equilibria by damped Newton iteration from each start; NaN where it fails.

    A step is halved until the scaled rates shrink, which keeps the search on the side of a
    singularity on which the structure itself would stay. `linear` gives rates and Jacobians of
    states, with the numbers of their starts. A step is compared with the states, or their scales:
    at `tolerance` only rounding is left, and below `rounding` a step is taken in full, since the
    rates may no longer shrink.

    Shapes: linear (a, n), (a,) -> (a, n), (a, n, n); starts (k, n); scales (n,) or (k, n); returns
    (k, n).
    """
    states, roots = starts.copy(), np.full_like(starts, np.nan)
    active, before = np.arange(len(starts)), np.full(len(starts), np.inf)
    rates, jacobians = linear(states, active)
    scales = np.broadcast_to(scales, starts.shape)
    for _ in range(iterations):
        if not len(active):
            break
        at = states[active]
        steps = _newton_steps(jacobians[active], rates[active])
        lengths = np.max(np.abs(steps) / np.maximum(scales[active], np.abs(at)), axis=1)
        full = lengths <= rounding
        # With fast modes rounding alone may make a longer step: then it does not shrink.
        done = (lengths <= tolerance) | (full & (lengths > 0.5 * before[active]))
        before[active] = lengths
        roots[active[done]] = (at + steps)[done]
        trying = np.flatnonzero(~done & np.isfinite(lengths))
        accepted = [active[:0]]
        for fractions in np.split(0.5 ** np.arange(halvings), [1]):
            if not len(trying):  # mostly the first is enough
                break
            rows = active[trying]
            tried = at[trying, None] + fractions[:, None] * steps[trying, None]
            with np.errstate(over="ignore"):  # a trial state may be anywhere
                new_rates, new_jacobians = _on_each(linear, tried, rows)
                norms = np.linalg.norm(new_rates / scales[rows, None], axis=2)
                less = norms < np.linalg.norm(rates[rows] / scales[rows], axis=1)[:, None]
            less |= full[trying, None]
            good = less.any(axis=1)
            first = np.flatnonzero(good), less.argmax(axis=1)[good]
            states[rows[good]], rates[rows[good]] = tried[first], new_rates[first]
            jacobians[rows[good]] = new_jacobians[first]
            accepted.append(rows[good])
            trying = trying[~good]
        active = np.sort(np.concatenate(accepted))
    return roots


def _on_each(
    linear: Callable[[Array, Indices], tuple[Array, Array]], states: Array, rows: Indices
) -> tuple[Array, Array]:
    """Evaluate rates and Jacobians at states of shape (a, b, n), from starts (a,)."""
    rates, jacobians = linear(states.reshape(-1, states.shape[2]), rows.repeat(states.shape[1]))
    return rates.reshape(states.shape), jacobians.reshape(*states.shape, states.shape[2])


def _newton_steps(jacobians: Array, rates: Array) -> Array:
    """Return Newton's steps; zero at an equilibrium, else NaN where the Jacobian is singular."""
    moving = np.asarray(rates.any(axis=1))
    steps = np.where(moving[:, None], np.nan, np.zeros_like(rates))
    moving &= np.isfinite(rates).all(axis=1) & np.isfinite(jacobians).all(axis=(1, 2))
    steps[moving] = -solve_each(jacobians[moving], rates[moving])
    return steps


def find_static_point(model: Model) -> Array:
    """Find the static point from the model's start, forcing off. Returns shape (n_states,)."""
    check_followed(model)
    amplitude = model.forcing_amplitude
    unforced = model if amplitude is None else model.replace(**{amplitude: 0.0})
    functions = evaluation_of(unforced)
    scales = unforced.state_scales()

    linear = functions.linear_of(unforced)
    state = damped_newton(linear, unforced.start[None], scales)[0]
    size = float(np.max(np.abs(state) / scales))
    # It may have few digits yet; a smaller one may be zero but for rounding.
    if 1e-12 < size < 1:
        finer = damped_newton(linear, state[None], size * scales)[0]
        state = state if np.isnan(finer).any() else finer
    if np.isnan(state).any():
        raise InputError(
            f"no static point of {model!r} was found from zero; the static load is too large for "
            "the structure, lower it or stiffen the structure"
        )
    return state


def search_equilibrium(model: Model, start: Array) -> Array | None:
    """Return an equilibrium near a state; None if the search fails.

    Newton's method may be stuck where it begins, as on the axis of a symmetry or at the top of a
    parabola, or run into a singularity. Then it starts again from states around it, the
    same ones every time, nearby ones first; the nearest equilibrium from one distance is taken.

    Shapes: start (n_states,).
    """
    linear, scales = evaluation_of(model).linear_of(model), model.state_scales()
    root = damped_newton(linear, start[None], scales)[0]
    if not np.isnan(root).any():
        return wrap_angles(root, model.angle_periods)
    around = np.random.default_rng(0)
    for reach in (0.1, 1.0, 10.0, 100.0):  # in scaled states
        starts = start + reach * scales * around.uniform(-1.0, 1.0, (24, len(start)))
        if reached := equilibria_in(model, starts):
            return min(reached, key=lambda at: float(distances(model, at, start)))
    return None


def equilibria_in(model: Model, starts: Array) -> list[Array]:
    """Return the equilibria that Newton's method finds from many starts, each once.

    Equilibria beyond a limit of the model are left out. Shapes: starts (k, n).
    """
    functions, scales, limits = evaluation_of(model), model.state_scales(), model.limits
    # There are other starts, so none is worth many halvings.
    states = damped_newton(functions.linear_of(model), starts, scales, halvings=12)
    result: list[Array] = []
    for state in states[np.isfinite(states).all(axis=1)]:
        outputs = functions.outputs(model, state, np.zeros(()))
        values = dict(zip(functions.names, outputs, strict=True))
        if not all(values[limit.output] > limit.bound for limit in limits):
            continue
        reduced = wrap_angles(state, model.angle_periods)
        if all(distances(model, reduced, other) > 1e-8 for other in result):
            result.append(reduced)
    return result
