"""Equilibria, perturbations off them, linear responses about them, and intervals of time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array, Indices
from slipfold.flow.equations import Constants
from slipfold.flow.flow import Flow, flow_of
from slipfold.flow.sharp_turns import invariant_groups
from slipfold.models.equilibria import damped_newton
from slipfold.models.model import Model, evaluation_of
from slipfold.models.quantities import DURATION


def state_sizes(model: Model, states: Array) -> Array:
    """Return the scales of states at given values: invariant groups have their own size.

    Shapes: states (..., n); returns (..., n).
    """
    scales = model.state_scales()
    scaled = np.abs(states / scales)
    sizes = np.maximum(1.0, np.broadcast_to(scaled.max(axis=-1, keepdims=True), states.shape))
    for group in map(list, invariant_groups_of(model)):
        sizes[..., group] = scaled[..., group].max(axis=-1, keepdims=True)
    return np.asarray(sizes * scales)


def invariant_groups_of(model: Model) -> list[tuple[int, ...]]:
    """Return the groups of states whose zero is invariant at the parameter values."""
    flow, scales = flow_of(model), model.state_scales()
    constants = flow.constants_of(model)

    def rates(states: Array) -> Array:
        phases = np.resize([0.1, 0.3, 0.6, 0.8], len(states))
        return flow.rates(states * scales, phases, constants)

    return invariant_groups(rates, len(scales))


class EQUILIBRIUM:
    """Distances from equilibria, and the search for an interval of time."""

    # In scaled states; also the growth, over the fastest rate, that is rounding
    distance: float = 1e-9  # at which a state is on it: Newton's method leaves 1e-13
    perturbation: float = 1e-6  # off an unstable one: grows linearly, and is far above rounding
    trial_steps: int = 500  # of a trial trajectory, ten rounds of a smooth cycle
    trial_length: float = 1e4  # of the same, in times of the fastest rate


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """An equilibrium with its fastest growth."""

    state: Array  # shape (n,)
    distance: float  # from the initial guess, in scaled states
    # Largest real part of an eigenvalue, in 1/s; zero if it is rounding
    growth: float
    # Real part of its eigenvector, of length one in scaled states
    direction: Array


def equilibrium_near(model: Model, state: Array) -> Equilibrium | None:
    """Return the equilibrium that Newton's method finds from a state, None if it finds none.

    Shapes: state (n,).
    """
    functions, scales = evaluation_of(model), model.state_scales()
    result = damped_newton(functions.linear_of(model), state[None], scales)[0]
    if np.isnan(result).any():
        return None
    jacobian = functions.jacobian(model, result) * (scales / scales[:, None])
    if not np.isfinite(jacobian).all():
        return None
    values, vectors = np.linalg.eig(jacobian)
    fastest = int(values.real.argmax())
    growth = float(values[fastest].real)
    if abs(growth) <= EQUILIBRIUM.distance * float(np.abs(values).max()):
        growth = 0.0
    direction = vectors[:, fastest].real
    # The largest component is positive, which makes the direction unique.
    direction *= np.sign(direction[np.abs(direction).argmax()]) / np.linalg.norm(direction)
    distance = float(np.abs((result - state) / scales).max())
    return Equilibrium(result, distance, growth, direction)


def perturbed_from_equilibrium(model: Model, state: Array) -> Array | None:
    """Return a perturbed state if a trajectory is on an unstable equilibrium, else None.

    Shapes: state (n,); returns (n,).
    """
    scales = model.state_scales()
    functions = evaluation_of(model)
    rates, jacobian = functions.rates(model, state), functions.jacobian(model, state)
    if not (np.isfinite(rates).all() and np.isfinite(jacobian).all()):
        return None
    # Newton's step estimates the distance at low cost.
    away = np.linalg.lstsq(jacobian * (scales / scales[:, None]), rates / scales, rcond=None)[0]
    if np.abs(away).max() > EQUILIBRIUM.distance:
        return None
    rest = equilibrium_near(model, state)
    if (
        rest is None
        or rest.growth <= 0
        or rest.distance > EQUILIBRIUM.distance
        or _leaves(model, state, rest)
    ):
        return None
    return state + EQUILIBRIUM.perturbation * scales * rest.direction


def _leaves(model: Model, state: Array, rest: Equilibrium) -> bool:
    """Whether a small state of an invariant group grows by itself."""
    jacobian = evaluation_of(model).jacobian(model, rest.state)
    for group in map(list, invariant_groups_of(model)):
        growth = np.linalg.eigvals(jacobian[np.ix_(group, group)]).real.max()
        if np.any(state[group] != 0) and growth > 0:
            return True
    return False


def with_duration(model: Model, state: Array, periods: int | None) -> tuple[Model, int | None]:
    """Return an autonomous model with a suitable ``duration``, and the number of intervals."""
    unit = model.values[DURATION.name]
    natural = _natural(model, state)
    if periods is None and unit == DURATION.default:
        return model.replace(**{DURATION.name: natural}), None
    # The integrator's steps in an interval are bounded.
    return shortened(model, periods, math.ceil(unit / natural) if unit > 8 * natural else 1)


def shortened(model: Model, periods: int | None, parts: int = 8) -> tuple[Model, int | None]:
    """Return an autonomous model with a fraction of its ``duration``, and the number of these."""
    if parts == 1:
        return model, periods
    shorter = model.replace(**{DURATION.name: model.values[DURATION.name] / parts})
    return shorter, None if periods is None else periods * parts


def _natural(model: Model, state: Array) -> float:
    """Return about half the period of a trajectory, rounded to 1, 2 or 5."""
    scales = model.state_scales()
    jacobian = evaluation_of(model).jacobian(model, state)
    if not np.isfinite(jacobian).all():  # there may be none where a contact sticks, but beside it
        state = state + EQUILIBRIUM.perturbation * scales
        jacobian = evaluation_of(model).jacobian(model, state)
    if not np.isfinite(jacobian).all():
        return DURATION.default
    values = np.linalg.eigvals(jacobian * (scales / scales[:, None]))
    fastest = float(np.abs(values).max())
    if not fastest > 0:
        return DURATION.default
    flow = flow_of(model.replace(**{DURATION.name: 1.0}))
    constants = flow.constants_of(model.replace(**{DURATION.name: 1.0}))
    slower = np.abs(values[values.real > -np.abs(values.imag)])
    slow = float(slower.max(initial=0.0)) or fastest
    length, steps = EQUILIBRIUM.trial_length / fastest, EQUILIBRIUM.trial_steps
    trajectory = flow.dense(state, constants, length, steps, 20 * 12 / slow)
    if trajectory is None:  # it reverses
        return rounded_down(12 / slow)
    # A round is about two of 20 intervals. Steps of what begins small are longer at first: the
    # fastest eigenvalue turns or grows by 12 at most. Fast decay limits no implicit steps. Where
    # slip reverses steps grow ever shorter: half a period of the fastest vibration is enough.
    most = 12 / (slow if trajectory.implicit else fastest)
    return rounded_down(max(min(trajectory.end / 20, most), math.pi / fastest))


def rounded_down(length: float) -> float:
    """Return the next shorter length that is 1, 2 or 5 with a power of ten."""
    magnitude = 10.0 ** math.floor(math.log10(length))
    return magnitude * max(step for step in (1, 2, 5) if step * magnitude <= length * 1.000001)


PHASES = np.arange(32) / 32
"""Phases that average the forcing: exact for up to 31 harmonics."""


def mean_states(flow: Flow, constants: Constants, scales: Array, starts: Array) -> Array:
    """Return the equilibrium under the forcing's mean from each start, shape (k, n_states).

    Coefficients may differ from row to row. Shapes: scales (n_states,) or (k, n_states); starts
    (k, n_states).
    """
    averaged = PHASES if flow.equations.forced else PHASES[:1]
    n, count = flow.dimension, len(averaged)

    def linear(states: Array, rows: Indices) -> tuple[Array, Array]:
        at, phases = np.repeat(states, count, axis=0), np.tile(averaged, len(states))
        own = constants.rows(rows.repeat(count))
        rates, jacobians = (of(at, phases, own) for of in (flow.rates, flow.jacobians))
        rates, jacobians = rates.reshape(-1, count, n), jacobians.reshape(-1, count, n, n)
        return rates.mean(axis=1), jacobians.mean(axis=1)

    result = damped_newton(linear, starts, scales)
    lost = np.flatnonzero(np.isnan(result).any(axis=1))
    if len(lost):  # the state of rest may be singular
        near, wide = starts + 1e-3 * scales, np.broadcast_to(scales, starts.shape)
        result[lost] = damped_newton(
            lambda states, rows: linear(states, lost[rows]), near[lost], wide[lost]
        )
    return result


def linear_responses(
    flow: Flow, constants: Constants, scales: Array, segments: int, starts: Array
) -> Array:
    """Return steady linear responses about mean states at equidistant phases.

    Coefficients may differ from one to the next.

    Shapes: scales (n_states,) or (k, n_states); starts (k, n_states); returns (k, m, n_states).
    """
    k, n, count = *starts.shape, len(PHASES)
    centers = mean_states(flow, constants, scales, starts)
    states, phases = np.repeat(centers, count, axis=0), np.tile(PHASES, k)
    own = constants.rows(np.arange(k).repeat(count))
    rates, jacobians = (of(states, phases, own) for of in (flow.rates, flow.jacobians))
    forcing = np.fft.fft(rates.reshape(k, count, n), axis=1) / count
    jacobians = jacobians.reshape(k, count, n, n).mean(axis=1)
    nodes = np.repeat(centers[:, None], segments, axis=1)
    for row, wide in enumerate(np.broadcast_to(scales, starts.shape)):
        nodes[row] += _vibration(forcing[row], jacobians[row], wide, np.arange(segments) / segments)
    return nodes


def _vibration(forcing: Array, jacobian: Array, scales: Array, phases: Array) -> Array:
    """Return the linear answer to harmonics of a forcing, shape (m, n).

    Shapes: forcing (32, n); jacobian (n, n); scales (n,); phases (m,).
    """
    n, result = len(scales), np.zeros((len(phases), len(scales)))
    forced = np.abs(forcing / scales).max(axis=1)
    for harmonic in 1 + np.flatnonzero(forced[1:9] > np.finfo(float).eps * forced.max()):
        stiffness = (2j * np.pi * harmonic * np.eye(n) - jacobian) * scales
        if np.isfinite(stiffness).all():
            # Rows are normalized: else slow modes would be rounding errors of fast ones.
            sizes = np.abs(stiffness).max(axis=1)
            # Without damping a harmonic may be resonant: least squares leaves out unforced modes.
            answer = np.linalg.lstsq(stiffness / sizes[:, None], forcing[harmonic] / sizes)[0]
            turns = np.exp(2j * np.pi * harmonic * phases)[:, None]
            result += 2 * (turns * (scales * answer)).real
    return result
