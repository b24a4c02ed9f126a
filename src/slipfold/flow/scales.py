"""Characteristic scales of states: from a short trajectory, or from the equations about rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from slipfold.arrays import Array, Indices, Mask
from slipfold.errors import InputError
from slipfold.flow.equations import Constants, power_of_two
from slipfold.flow.equilibrium import PHASES, linear_responses, mean_states
from slipfold.flow.flow import Flow, flow_of
from slipfold.flow.hybrid_flow import hybrid_flow_of
from slipfold.flow.intervals import Field, LinearPart
from slipfold.flow.modal_equations import modes_serve
from slipfold.flow.modes import Status, contacts_of
from slipfold.models.equilibria import search_equilibrium
from slipfold.models.model import Model


class SCALES:
    """The search for characteristic scales."""

    weak: float = 0.1  # feedback, over the typical rate, of a state that does not act back
    # Vibrations so many times faster than the slowest follow at once: in a beam, not in a chain
    fast: float = 64.0
    periods: int = 8  # of a trial trajectory: a resonance shows, an instability is still small
    samples: int = 16  # of it a period
    trial: float = 1e-4  # its error a step by modes: scales are powers of two, which hardly change
    # Most steps of it by modes, a second or two: twice what the fastest that are followed take
    steps: int = 50_000
    rounding: float = 1e-9  # of the displacement at rest, or of the fastest rate
    # Relative changes of states and coefficients that show which derivatives are rounding errors:
    # several, since two evaluations may round alike
    changes: tuple[float, ...] = (2.0**-46, -(2.0**-45), 2.0**-44, -(2.0**-43))
    cancelled: float = 0.1  # change, over the size, of a derivative that is a rounding error
    # Motion, over the largest of a state of the same unit, that is one: where symmetry forbids it
    unmoved: float = 1e-13
    # Nonlinear part of the rates, over the linear one, where its maximum counts
    bounded: float = 1e-2
    # Mean of rates, over the largest of the period, that is none: the sum of a harmonic force
    unbalanced: float = 1e-15
    # Ratio of the size at one of several values of a parameter to that at the first, above which
    # their geometric mean is taken: a branch of a thousand sizes takes ten times as many steps
    apart: float = 64.0


TRIAL = np.linspace(0.0, SCALES.periods, SCALES.periods * SCALES.samples + 1)
"""Phases of a trial trajectory."""


def balanced(matrix: Array, rate: float, loops: Indices) -> Array:
    """Return the scales of states that balance a system's matrix, shape (n,).

    Each group of coupled states has a free factor; its first state has the scale one.

    Shapes: matrix (n, n); loops (n,).
    """
    matrix = np.where(matrix < 1e-100 * matrix.max(), 0.0, matrix)  # else overflows
    size, groups = np.ones(len(matrix)), coupled(matrix)
    entries = matrix * ~np.eye(len(matrix), dtype=bool)
    own = np.diag(matrix)
    fastest = largest_in(loops, np.maximum(np.sqrt(entries * entries.T).max(axis=1), own))
    typical = rate or np.maximum(fastest, fastest[:, None])
    weak = SCALES.weak * np.where(np.equal(typical, 0), 1.0, typical)
    # The decay of a state that does not act back bounds its scale.
    lasting = np.maximum(weak, (loops != loops[:, None]) * own[:, None])
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        back = np.where(entries > 0, lasting**2 / entries, 0.0).T
    entries = np.maximum(entries, back)
    for _ in range(60):  # a chain of a hundred states needs no more
        scaled = entries * size / size[:, None]
        rows, columns = scaled.sum(axis=1), scaled.sum(axis=0)
        acts = (rows > 0) & (columns > 0)
        unequal = rows[acts] / columns[acts]
        size[acts] *= unequal**0.25
        if np.abs(np.log(unequal)).max(initial=0.0) < 0.1:  # scales become powers of two
            break
    return size / size[groups]


def coupled(matrix: Array) -> Indices:
    """Return for each state the first state coupled with it, directly or not.

    Shapes: matrix (n, n).
    """
    near = (matrix != 0) | (matrix.T != 0) | np.eye(len(matrix), dtype=bool)
    first = np.arange(len(matrix))
    while True:
        nearest = np.where(near, first, len(matrix)).min(axis=1)
        if np.array_equal(nearest, first):
            return first
        first = nearest


def loops_of(depends_on: Mask) -> Indices:
    """Return for each state the first state in a feedback loop with it.

    Shapes: depends_on (n, n), whether each rate depends on each state.
    """
    reached = depends_on | np.eye(len(depends_on), dtype=bool)
    for _ in range(len(depends_on).bit_length()):
        reached = reached @ reached
    return np.asarray((reached & reached.T).argmax(axis=1))


def largest_in(loops: Indices, values: Array) -> Array:
    """Return for each state the largest value in its loop. Shapes: values (n,)."""
    result = np.zeros(loops.max() + 1)
    np.fmax.at(result, loops, values)  # NaN is unknown
    return result[loops]


def followed_at_once(jacobian: Array, forcing: float) -> Array | None:
    """Return the projection of rates onto slow motion, shape (n, n); None if all motion is slow.

    It is the rate ``(I - h A)^-1 r`` of one implicit Euler step, with rates r and their derivatives
    A, over a time h in which slow motion hardly changes.

    Shapes: jacobian (n, n).

    Examples
    --------
    >>> from scipy.linalg import block_diag
    >>> modes = block_diag([[0.0, 1.0], [-1.0, 0.0]], [[0.0, 1.0], [-1e10, -1.0]])
    >>> slow = followed_at_once(modes, 0.0)
    >>> bool(np.linalg.norm(slow @ [0.0, 0.0, 0.0, 1.0]) < 1e-6)
    True
    >>> followed_at_once(modes, 1e5) is None
    True
    """
    if not np.isfinite(jacobian).all():
        return None
    values = np.linalg.eigvals(jacobian)
    largest = float(np.abs(values).max())
    turning = np.abs(values[np.abs(values.imag) > SCALES.rounding * largest])
    rate = SCALES.fast * max(float(turning.min(initial=np.inf)) if len(turning) else 0.0, forcing)
    if not 0 < rate < largest or not rate < turning.max(initial=0.0):
        return None
    return np.asarray(np.linalg.inv(np.eye(len(jacobian)) - jacobian / rate))


DISTANCES = 2.0 ** np.arange(-120, 121)
"""Distances from rest, in balanced states, at which nonlinearity is sought."""

DIRECTIONS = np.array([[1.0, 1.0], [1.0, -1.0], [1.0, 0.3], [0.3, -1.0]])
"""Directions of that search, as components of alternate states."""


def measured(
    model: Model,
    also: Sequence[Model] = (),
    *,
    motion: Array | None = None,
    start: Array | None = None,
) -> Model:
    """Return a model with characteristic scales of its states if it declares none.

    The linearized equations give the ratios of coupled states. A trajectory gives their size;
    without forcing it is the distance from rest at which the equations become nonlinear, or the
    size of the state of rest. The scales do not depend on units. They are powers of two.

    Shapes: motion (m, n_states); start (n_states,).
    """
    if not np.isnan(model.declared_scales()).any():
        return model
    start = model.start if start is None else start
    flow = _differentiable(model, start)
    looks = [_View(item, flow, start) for item in (model, *also)]
    looks = [look for look in looks if look.rests] or looks
    sizes = np.full(len(model.states), np.nan)
    looks_at = looks[: 1 if motion is not None else None]
    for look in looks_at:
        sizes = np.fmax(sizes, look.moved(motion))
    if (lags := looks[0].lags).any():
        means = np.array([look.mean for look in looks_at])
        sizes = np.where(lags, np.maximum(sizes, np.ptp(means, axis=0)), sizes)
    if np.isnan(sizes).any():
        sizes = np.where(np.isnan(sizes), _typical([look.bent for look in looks]), sizes)
    if np.isnan(sizes).any():
        resting = np.fmax.reduce([look.resting for look in looks])
        sizes = np.where(np.isnan(sizes), resting, sizes)
        sizes = np.where(np.isnan(sizes), looks[0].alike(sizes), sizes)
        sizes = np.where(np.isnan(sizes), looks[0].ratios, sizes)
    return model.with_scales(power_of_two(np.array([sizes, looks[0].equalized(sizes)])))


def _typical(sizes: Sequence[Array]) -> Array:
    """Return the first known sizes, or their geometric means with the largest ones.

    The means are taken where some first size is many times smaller than the largest. Friction
    bends at the speed of the plate, and at the first value the plate may hardly move.
    """
    first = sizes[0]
    for other in sizes[1:]:
        first = np.where(np.isnan(first), other, first)
    largest = np.fmax.reduce(sizes)
    with np.errstate(invalid="ignore"):
        small = (largest > SCALES.apart * first).any()
    return np.asarray(np.sqrt(first * largest) if small else first)


def measured_within(
    model: Model, values: Sequence[Mapping[str, float]], trajectory: Array | None = None
) -> Model:
    """Return a model with scales that suit several parameter values."""
    if not np.isnan(model.declared_scales()).any():
        return model
    others = []
    for changes in values:
        with suppress(InputError):  # they may contradict those of other parameters
            others.append(model.replace(**changes))
    first, *rest = others or [model]
    return model.with_scales(measured(first, rest, motion=trajectory).estimated_scales)


def has_slopes(model: Model, start: Array) -> bool:
    """Whether the rates have finite derivatives at a state, shape (n_states,)."""
    flow = flow_of(model)
    jacobians = flow.jacobians(start[None], np.zeros(1), flow.constants(model.vector))
    return bool(np.isfinite(jacobians).all())


def _differentiable(model: Model, start: Array) -> Flow:
    """Return a flow with derivatives at the start: dry contacts at rest have some in slip only.

    Shapes: start (n_states,).
    """
    if has_slopes(model, start) or not contacts_of(model):
        return flow_of(model)
    switched = hybrid_flow_of(model)
    slips = (Status.FORTH,) * len(switched.contacts)
    return flow_of(model) if switched.planar else switched.of(slips)


@dataclass(frozen=True, eq=False)
class _View:
    """A model about its state of rest. Scales have the shape (n,) and are NaN where unknown."""

    # The model and its flow
    model: Model
    flow: Flow
    start: Array  # state from which trajectories start

    @cached_property
    def constants(self) -> Constants:
        """Coefficients of the model, in unit scales."""
        return self.flow.constants(self.model.vector)

    @cached_property
    def rest(self) -> Array:
        """State of rest under the mean of the forcing, or the start if there is none."""
        start = self.start
        if self.flow is not flow_of(self.model):  # friction holds it
            return start
        result, slopes = self._at_start
        largest = np.abs(result).max(axis=0)
        if (np.abs(result.mean(axis=0)) <= SCALES.unbalanced * largest).all():
            return start
        ratios = self._balanced(slopes)
        guess = _largest(largest / ratios) / self._rate(slopes, ratios)
        given = self.flow, self.constants, ratios * (guess or 1.0), start[None]
        state = mean_states(*given)[0]
        if np.isnan(state).any() and not self.model.forced:
            equilibrium = search_equilibrium(self.model, start)
            state = start if equilibrium is None else equilibrium
            # On a line of equilibria it may differ from the start by rounding only.
            same = np.abs(state - start) < SCALES.rounding * self.model.state_scales()
            state = np.where(same, start, state)
        # Newton's method and the mean of a forcing leave rounding errors of zero.
        zero = 1e-15 * np.maximum(np.abs(start), ratios * guess)
        state = np.where(np.abs(state) < zero, 0.0, state)
        return np.where(np.isfinite(state), state, start)

    @cached_property
    def rests(self) -> bool:
        """Whether there is a state of rest: beyond a fold there is none, and nothing is near it."""
        if self.model.forced or self.flow is not flow_of(self.model):  # friction holds it
            return True
        return not (self.rest == self.start).all() or not self._around(self.start)[0].any()

    @cached_property
    def slopes(self) -> Array:
        """Mean moduli of the derivatives of the rates there, shape (n, n)."""
        return self._at_rest[1]

    @cached_property
    def ratios(self) -> Array:
        """Ratios of coupled states."""
        return self._balanced(self.slopes)

    @cached_property
    def groups(self) -> Indices:
        """The first state coupled with each one."""
        return coupled(self.slopes)

    @cached_property
    def loops(self) -> Indices:
        """The first state in a feedback loop with each one, at any state."""
        return loops_of(self.flow.equations.depends_on)

    @cached_property
    def lags(self) -> Mask:
        """Whether each state decays by itself, and slowly under forcing, as a temperature does.

        Its mean, which varies along a branch, is larger than the motion about it.
        """
        own = np.diag(self.slopes)
        with np.errstate(invalid="ignore", over="ignore"):  # an infinite derivative at the start
            mutual = np.sqrt(self.slopes * self.slopes.T) * ~np.eye(len(own), dtype=bool)
        slow = self.model.forced & (own > 0) & (own * SCALES.periods < 1)
        return np.asarray(slow & (mutual.max(axis=1) <= own))

    @cached_property
    def mean(self) -> Array:
        """State of rest; of states that lag, where the mean of their rates in motion vanishes."""
        if self.slow is not None or not (self.lags.any() and _largest(self.expected) > 0):
            return self.rest
        half = len(self.motion) // 2  # the motion begins in the other one
        rates = self.flow.rates(self.motion[half:], TRIAL[1 + half :], self.constants)
        away = rates.mean(axis=0) / np.where(self.lags, np.diag(self.slopes), np.inf)
        return self.rest + np.where(np.isfinite(away), away, 0.0)

    def moved(self, trajectory: Array | None) -> Array:
        """Return the scales that a trajectory shows."""
        if trajectory is None:
            reached = self._reached() if self.model.forced else np.zeros(len(self.rest))
        else:
            reached = np.ptp(trajectory, axis=0) / 2
        largest = self._in_group(reached / self.ratios)
        resting = np.maximum(np.abs(self.rest - self.start), np.abs(self.rest)) / self.ratios
        still = self._in_group(np.where(self.lags, 0.0, resting))
        # States that move little now may dominate where others reach the nonlinear range.
        far = _largest(largest * self.ratios / self.bent)
        largest = np.fmax(largest, np.where(largest > 0, far * self.bent / self.ratios, 0.0))
        # A slow forcing moves displacements only; the velocities belong to faster vibrations.
        sizes = np.maximum(reached, 1 / 8 * self.ratios * largest)
        for away in (self.mean - self.start, self.mean - self.rest):
            sizes = np.where(self.lags, np.maximum(sizes, np.abs(away)), sizes)
        moving = reached > SCALES.unmoved * self.alike(reached)
        moves = self._in_group(moving.astype(float)) > 0
        return np.where((largest > SCALES.rounding * still) & moves, sizes, np.nan)

    @cached_property
    def bent(self) -> Array:
        """Scales at which the equations become nonlinear."""
        sizes = np.full(len(self.rest), np.nan)
        for first in np.unique(self.groups):
            group = self.groups == first
            sizes[group] = self.ratios[group] * self._bent_distance(group)
        return sizes

    @cached_property
    def resting(self) -> Array:
        """Scales of the state of rest, where it is not zero."""
        away = self._in_group(np.maximum(np.abs(self.rest), np.abs(self.start)) / self.ratios)
        return self.ratios * np.where(away > 0, away, np.nan)

    def alike(self, sizes: Array) -> Array:
        """Return the largest size of the states of the same unit, NaN where none is known."""
        _, units = np.unique([item.unit for item in self.model.states], return_inverse=True)
        largest = largest_in(units, np.nan_to_num(sizes))
        return np.where(largest > 0, largest, np.nan)

    def equalized(self, sizes: Array) -> Array:
        """Return the scales for steps under forcing: modes of equal energy have the same.

        However little they move. The ratios are known of states that drive each other at rest, in
        vibrations not much slower than the forcing; others keep their sizes.
        """
        if not self.model.forced:  # where a cycle starts would depend on the scales
            return sizes
        with np.errstate(invalid="ignore", over="ignore"):
            rates = np.sqrt(self.slopes * self.slopes.T) * ~np.eye(len(sizes), dtype=bool)
        vibrates = np.nan_to_num(rates.max(axis=1)) > SCALES.weak * 2 * np.pi
        largest = self._in_group(np.where(vibrates, sizes, 0.0) / self.ratios)
        return np.where(vibrates, np.maximum(sizes, self.ratios * largest), sizes)

    @cached_property
    def _at_start(self) -> tuple[Array, Array]:
        return self._around(self.start)

    @cached_property
    def _at_rest(self) -> tuple[Array, Array]:
        return self._at_start if self.rest is self.start else self._around(self.rest)

    def _around(self, state: Array) -> tuple[Array, Array]:
        """Return rates over a period at a state, (p, n), and mean moduli of their derivatives."""
        states = np.tile(state, (len(PHASES), 1))
        rates, jacobians = self.flow.rates(states, PHASES, self.constants), self._jacobians(states)
        if self.slow is not None:
            rates, jacobians = rates @ self.slow.T, self.slow @ jacobians
        return rates, np.asarray(np.abs(jacobians).mean(axis=0))

    def _jacobians(self, states: Array) -> Array:
        """Return the derivatives of the rates at the phases, zero where they are rounding errors.

        Shapes: states (p, n); returns (p, n, n).
        """
        result = self.flow.jacobians(states, PHASES, self.constants)
        change = rounded_jacobians(self.flow, states, PHASES, self.constants, result)
        return np.where(change > SCALES.cancelled * np.abs(result).mean(axis=0), 0.0, result)

    @cached_property
    def slow(self) -> Array | None:
        """Projection of rates onto slow motion, shape (n, n); None if all motion is slow."""
        states = np.tile(self.start, (len(PHASES), 1))
        mean = self.flow.jacobians(states, PHASES, self.constants).mean(axis=0)
        return followed_at_once(mean, 2 * np.pi if self.model.forced else 0.0)

    def _balanced(self, slopes: Array) -> Array:
        if not np.isfinite(slopes).all():
            return np.ones(len(slopes))
        return balanced(slopes, 2 * np.pi if self.model.forced else 0.0, self.loops)

    def _rate(self, slopes: Array, ratios: Array) -> float:
        """Return about the fastest rate of the linear system and of the forcing."""
        own = _largest(slopes * ratios / ratios[:, None])
        return own + 2 * np.pi if self.model.forced else own or 1.0

    def _in_group(self, values: Array) -> Array:
        """Return the largest value in each group of coupled states."""
        return largest_in(self.groups, np.nan_to_num(values))

    @cached_property
    def expected(self) -> Array:
        """Amplitudes that the rates at rest suggest, all zero where nothing forces the states."""
        rates = self._at_rest[0]
        pushed = self._in_group(np.ptp(rates, axis=0) / self.ratios)
        if not _largest(pushed) > 0:
            return pushed
        sizes = self.ratios * pushed / self._rate(self.slopes, self.ratios)
        return np.where(sizes > 0, sizes, self.ratios * _largest(sizes / self.ratios))

    @cached_property
    def motion(self) -> Array:
        """States of a trajectory from rest at the later phases of the trial, NaN beyond its end."""
        constants = self.flow.constants(self.model.vector, power_of_two(self.expected))
        return self._trial(constants, TRIAL)[1:]

    def _reached(self) -> Array:
        """Return amplitudes of the trajectory from rest, the median over forcing periods."""
        if not _largest(self.expected) > 0:
            return self.expected
        if self.slow is not None:  # a trajectory would take very many steps
            given = self.flow, self.constants, self.ratios, SCALES.samples, self.start[None]
            return np.asarray(np.ptp(linear_responses(*given)[0], axis=0) / 2)
        states = self.motion
        reached = np.ptp(states.reshape(SCALES.periods, SCALES.samples, -1), axis=1) / 2
        whole = reached[np.isfinite(reached).all(axis=1)]
        if len(whole):
            sizes = (whole / self.ratios).max(axis=1)
            if sizes[-1] > max(SCALES.apart * sizes[0], 2 * sizes[-2:][0]):  # it runs away
                return np.fmax(self.expected, whole[0] * (sizes[0] / sizes[1]))
            return np.asarray(np.median(whole, axis=0))
        part = states[np.isfinite(states).all(axis=1)]
        return np.ptp(part, axis=0) / 2 if len(part) > 1 else self.expected

    def _trial(self, constants: Constants, grid: Array) -> Array:
        """Return the states of a trajectory from rest at the phases of a grid, NaN beyond its end.

        An integrator of many states takes longer to compile than all orbits by modes.
        """
        if not modes_serve(self.model):
            stiff = self.flow.is_stiff(self.rest, constants)
            return self.flow.trajectory(self.rest, constants, grid, patient=stiff)
        from scipy.integrate import LSODA  # takes a while to load

        field = Field(self.flow, constants, constants.scales, [], LinearPart())
        solver = LSODA(
            lambda phase, state: field.rates(state, np.asarray(phase)),
            grid[0],
            self.rest / field.scales,
            grid[-1],
            rtol=SCALES.trial,
            atol=SCALES.trial,
            jac=lambda phase, state: field.jacobians(state, np.asarray(phase)),
        )
        states = np.full((len(grid), len(self.rest)), np.nan)
        states[0], known = self.rest, 1
        for _ in range(SCALES.steps):
            solver.step()
            if not solver.step_size or not np.isfinite(solver.y).all():  # states have escaped
                break
            through = int(np.searchsorted(grid, solver.t, "right"))
            if through > known:
                part = solver.dense_output()(grid[known:through])
                states[known:through], known = part.T * field.scales, through
            if solver.status != "running":
                break
        return states

    def _bent_distance(self, group: Mask) -> float:
        """Return the distance from rest, in balanced states, at which rates bend, or NaN."""
        phase, ratios = PHASES[5:6], self.ratios[group]
        still = self.flow.rates(self.rest[None], phase, self.constants)
        matrix = self.flow.jacobians(self.rest[None], phase, self.constants)[0]
        # At a degenerate state of rest no rate is linear: the start shows how large they are.
        moduli = np.abs(matrix if self.slow is None else self.slow @ matrix)
        slopes = np.fmax(moduli, self._at_start[1])[np.ix_(group, group)]
        rows = (slopes * ratios / ratios[:, None]).max(axis=1)
        linear = _largest(rows)
        # Compare with rates in the loop, not with those of states that only follow it.
        rows = largest_in(self.loops[group], rows)
        rows = np.where(rows > 0, rows, linear or np.finfo(float).tiny)
        minimum = _largest(np.abs(self.rest[group]) / ratios)
        minimum += _largest(np.abs(still[0, group]) / ratios) / (linear or np.inf)
        distances = DISTANCES[SCALES.rounding * minimum < DISTANCES]
        if not len(distances):  # rates are infinite there
            return np.nan
        directions = np.zeros((len(DIRECTIONS), len(group)))
        directions[:, group] = DIRECTIONS[:, np.resize([0, 1], np.count_nonzero(group))] * ratios
        steps = distances[:, None, None] * directions
        states = (self.rest + steps).reshape(-1, len(group))
        rates = self.flow.rates(states, np.repeat(phase, len(states)), self.constants)
        with np.errstate(invalid="ignore", over="ignore"):
            others = (rates - still).reshape(steps.shape) - steps @ matrix.T
            others = np.abs(others if self.slow is None else others @ self.slow.T)
            fraction = (others[..., group] / ratios / rows).max(axis=(1, 2)) / distances
        large = ~(fraction <= 0.5)  # of the rates are nonlinear
        # What is bounded may count most long before something that grows.
        rises = fraction[1:] > fraction[:-1]
        hump = np.r_[False, rises] & np.r_[~rises, False] & (fraction > SCALES.bounded)
        if large.any():
            hump &= distances < distances[large.argmax()] / SCALES.apart
            large = hump & (fraction >= fraction[hump].max() / 2) if hump.any() else large
        if not large.any():  # bounded, as friction is: where it counts most
            maximum = fraction.max(initial=1e-6)  # rounding
            # Beside linear terms one that saturates counts ever more: half of it is enough.
            large = fraction >= (maximum / 2 if fraction[-1] >= maximum / 2 else maximum)
        first = int(large.argmax())
        return float(distances[first]) if large[first] and first else np.nan


def rounded_jacobians(
    flow: Flow, states: Array, phases: Array, constants: Constants, jacobians: Array
) -> Array:
    """Return what other rounding of states and coefficients changes the derivatives of rates by.

    It is the mean over the phases. Shapes: states (p, n); jacobians (p, n, n); returns (n, n).
    """
    change, coefficients = np.zeros(jacobians.shape[1:]), constants.values
    for relative in SCALES.changes:
        values = coefficients * _changes(coefficients, relative)
        changed = replace(constants, values=values)
        others = flow.jacobians(states * _changes(states[0], -relative), phases, changed)
        with np.errstate(invalid="ignore"):  # an infinite derivative at the start
            change = np.fmax(change, np.abs(others - jacobians).mean(axis=0))
    return change


def _changes(values: Array, relative: float) -> Array:
    """Return factors near one, no two of them equal. Shapes: values (n,)."""
    return 1.0 + relative * 8 * np.cos(np.arange(1, len(values) + 1))


def _largest(values: Array) -> float:
    return float(np.nan_to_num(values).max(initial=0.0))
