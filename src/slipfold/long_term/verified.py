"""Attractors (orbits, cycles, equilibria, tori, chaos), verified, with regions of attraction."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property

import numpy as np

from slipfold.arrays import Array, Indices, Mask
from slipfold.bifurcations.branches.gaps import BranchSearch
from slipfold.errors import InputError
from slipfold.flow.ensembles import stroboscopic_samples
from slipfold.flow.equilibrium import equilibrium_near
from slipfold.flow.flow import flow_of
from slipfold.flow.guarded_flow import GuardStop
from slipfold.long_term.attractor import (
    Attractor,
    at_rest,
    of_exponents,
    of_orbit,
    preserves_volume,
    stroboscopic_states,
)
from slipfold.long_term.exponents import find_exponents, growth_from, growth_through_stick
from slipfold.models.angles import distances, embedded, wrap_angles
from slipfold.models.model import Model
from slipfold.orbits.find import may_slip, periodic_orbit
from slipfold.orbits.kinds import any_parameter, orbits_at
from slipfold.orbits.multipliers import product
from slipfold.orbits.orbit_batch import orbits_from
from slipfold.orbits.periodic_orbit import PeriodicOrbit, StickSlipOrbit
from slipfold.orbits.switched_shooting import SwitchedShooting
from slipfold.text import stability_word


class Trajectories:
    """Trajectories in one batch; one whose contacts stick continues individually.

    Periods are those of the forcing, or intervals of the ``duration`` of an autonomous model.
    """

    def __init__(self, model: Model, starts: Array) -> None:
        self.model = model
        self.states = starts.copy()  # shape (k, n)
        self.stops: dict[int, GuardStop] = {}  # why trajectories ended, by their place
        self.stuck = np.zeros(len(starts), bool)  # whether contacts stuck in the last periods
        self._periods = np.zeros(len(starts), int)
        self._period = flow_of(model).constants_of(model).period

    def advance(self, which: Indices, periods: int) -> Array:
        """Continue some trajectories; return their states at the start of each period and the end.

        States after the end of a trajectory are NaN. Shapes: returns (k, periods + 1, n).
        """
        points = stroboscopic_samples(self.model, self.states[which], None, periods)
        known = np.isfinite(points.states).all(axis=2).sum(axis=1)
        self.states[which] = points.states[np.arange(len(which)), known - 1]
        self.stuck[which] = points.stuck.any(axis=1)
        for index, stop in zip(which, points.stopped, strict=True):
            if stop is not None:
                before = self._periods[index] * self._period
                self.stops[int(index)] = replace(stop, time=before + stop.time)
        self._periods[which] += known - 1
        return points.states


class CycleLine:
    """The closed polygon through samples of a cycle.

    Contacts that stick all the time may rest anywhere in a range, and that moves the cycle: how
    far they are displaced does not count.
    """

    def __init__(self, orbit: PeriodicOrbit, scales: Array) -> None:
        phases, self.samples = orbit.sample(1024)  # between which the line is straight
        self._scales, self._whole = scales, orbit.model.angle_periods
        self._along = self._apart(np.roll(self.samples, -1, axis=0), self.samples)
        self._displaced, moved = _displacements(orbit, scales)
        self._moved = moved[np.arange(len(phases)) * len(moved) // len(phases)]
        self._squares = np.einsum("sa,sa->s", self._along, self._along)

    def distance(self, states: Array) -> Array:
        """Return the distance of states from the line. Shapes: (..., n), returns (...)."""
        flat = states.reshape(-1, states.shape[-1])
        return np.array([self._from(state) for state in flat]).reshape(states.shape[:-1])

    def _from(self, state: Array) -> float:
        apart = self._apart(state, self.samples)
        apart -= np.einsum("sak,sk->sa", self._moved, apart @ self._displaced.T)
        fractions = np.clip(np.einsum("sa,sa->s", apart, self._along) / self._squares, 0.0, 1.0)
        nearby = apart - fractions[:, None] * self._along
        return float(np.sqrt(np.einsum("sa,sa->s", nearby, nearby).min()))

    def _apart(self, states: Array, points: Array) -> Array:
        return wrap_angles(states - points, self._whole) / self._scales


def _displacements(orbit: PeriodicOrbit, scales: Array) -> tuple[Array, Array]:
    """Return what displaces contacts that rest, and how that moves a cycle at equal phases.

    Shapes: scales (n,); returns (k, n), (p, n, k).
    """
    n, phases = len(scales), np.arange(0.0, 1.0, 1 / ATTRACTOR.samples)
    none = np.empty((0, n)), np.empty((len(phases), n, 0))
    if not isinstance(orbit, StickSlipOrbit):
        return none
    orbits = orbits_at(orbit.model, by=SwitchedShooting, segments=1)
    constants, by = orbits.constants(orbits.unknown(orbit.state[None], orbit.model)), orbits.by
    assert isinstance(by, SwitchedShooting)
    rest = by.resting(orbit.state[None], constants)
    if rest is None:
        return none
    nodes, ratios = np.tile(orbit.state, (len(phases), 1)), scales / scales[:, None]
    matrices = by.propagate(nodes, 0 * phases, phases + phases[1], constants)[1] * ratios
    displaced = rest.displaced * scales / orbits.scales
    equations = np.vstack([matrices[-1] - np.eye(n), displaced])
    unit = np.eye(len(equations))[:, n:]
    return displaced, matrices @ np.linalg.lstsq(equations, unit, rcond=None)[0]


class ATTRACTOR:
    """Distances and numbers of trials that verify an attractor."""

    # Distances are in scaled states
    first_distance: float = 1e-4  # that is tried: the flow is nearly linear there
    ratio: int = 4  # between distances that are tried
    trials: int = 7  # in each direction
    probes: int = 24  # states at a distance from which all trajectories must approach
    same: float = 1e-6  # distance of two orbits that are the same
    decay: float = 0.03  # of distances by multipliers in rounds that need to bring half of that
    fewest: int = 2  # of these rounds: modes that are not orthogonal grow at first
    max_rounds: int = 100
    inside: float = 0.9  # fraction of the states on a torus or chaos near the stored ones
    nearly: float = 0.03  # return of a trajectory near an orbit that Newton's method then finds
    near_cycle: float = 3e-3  # distance of a trajectory on a cycle
    samples: int = 64  # an interval for the search of a return
    point: float = 1e-5  # extent of a cycle that is an equilibrium
    exponents: tuple[int, ...] = (2000, 8000)  # periods after which exponents decide
    tolerance: float = 1e-8  # of these exponents
    preserved: float = 1e-9  # sum of exponents per period that is zero but for rounding
    reach: float = 1.5  # half width of the default box, in scales
    stored: int = 33  # last states of each trajectory that are examined
    visiting: int = 256  # periods in which a trajectory visits most of a torus or chaos
    paced: int = 7  # trajectories from which the interval is chosen
    slower: float = 8.0  # ratio of intervals, where they arrive and before, above which it grows
    search_values: int = 4  # of the parameter at which trajectories start
    search_periods: int = BranchSearch.periods  # of each trajectory
    search_starts: int = 32  # trajectories at each, and starts of Newton's method
    same_branch: float = 1e-4  # distance of two orbits that are the same: branches are interpolated


class AttractorRegion(ABC):
    """An attractor with a region of attraction around it."""

    def __init__(self, model: Model, attractor: Attractor) -> None:
        self.attractor = attractor
        self._scales, self._whole = model.state_scales(), model.angle_periods

    @abstractmethod
    def catches(self, states: Array) -> Mask:
        """Whether the last states of trajectories lie in the region. Shapes: (k, m, n) to (k,)."""

    @abstractmethod
    def distance(self, states: Array) -> Array:
        """Return how far states are from it, in scaled states. Shapes: (..., n), returns (...)."""

    def _apart(self, states: Array, points: Array) -> Array:
        return wrap_angles(states - points, self._whole) / self._scales

    def _directions(self) -> Array:
        """Directions in which trajectories are tried, of length one, shape (probes, n)."""
        result = np.random.default_rng(0).standard_normal((ATTRACTOR.probes, len(self._scales)))
        return np.asarray(result / np.linalg.norm(result, axis=1)[:, None])


class PointRegion(AttractorRegion):
    """A periodic orbit seen once a period, or an equilibrium seen at intervals.

    Distances shrink each round in the norm x' P x with M' P M - r P + r = 0; r is the spectral
    radius of the monodromy matrix M. Trajectories from several distances show how far that holds in
    the nonlinear equations.

    A contact that sticks all the time may rest anywhere in a range: then orbits that differ by
    that are one attractor, and do not count as apart.
    """

    def __init__(self, model: Model, attractor: Attractor) -> None:
        super().__init__(model, attractor)
        self._period = attractor.period or 1
        trajectory = Trajectories(model, attractor.state[None])
        self.points = trajectory.advance(np.arange(1), self._period)[0, :-1]
        matrix = _monodromy(model, attractor.state, self._period)
        self._across = _across_rests(matrix)
        matrix = matrix @ self._across
        radius = max(float(np.abs(np.linalg.eigvals(matrix)).max()), 1e-2)
        self._metric = _metric(matrix / np.sqrt(radius))
        self._rate = 0.5 * (1 + np.sqrt(radius))
        self._radius = self._find_radius(model)

    def catches(self, states: Array) -> Mask:
        """Whether one of the states lies in the region."""
        return np.asarray((self._length(states) < self._radius).any(axis=1))

    def distance(self, states: Array) -> Array:
        """Return the distance from the nearest of its states at phase zero."""
        apart = self._apart(states[..., None, :], self.points) @ self._across.T
        return np.asarray(np.abs(apart).max(axis=-1).min(axis=-1))

    def _length(self, states: Array) -> Array:
        apart = self._apart(states, self.attractor.state) @ self._across.T
        with np.errstate(invalid="ignore"):
            return np.asarray(np.linalg.norm(apart @ self._metric.T, axis=-1))

    def _find_radius(self, model: Model) -> float:
        """Return the largest distance tried from which every trajectory approaches."""
        around = np.linalg.solve(self._metric, self._directions().T).T * self._scales

        def nearer(tried: float) -> bool:
            trajectories = Trajectories(model, self.attractor.state + tried * around)
            ends = trajectories.advance(np.arange(ATTRACTOR.probes), self._period)[:, -1]
            return bool(np.all(self._length(ends) < self._rate * tried))  # not of what is no number

        return _farthest(nearer, ATTRACTOR.first_distance)


class CycleRegion(AttractorRegion):
    """A cycle of an autonomous model, with distances measured across it."""

    def __init__(self, model: Model, orbit: PeriodicOrbit, attractor: Attractor) -> None:
        super().__init__(model, attractor)
        self._line = CycleLine(orbit, self._scales)
        across = np.delete(orbit.multipliers, np.abs(orbit.multipliers - 1).argmin())
        rate = min(max(float(np.abs(across).max(initial=0.0)), 1e-3), 1 - 1e-3)
        rounds = min(
            max(np.log(ATTRACTOR.decay) / np.log(rate), ATTRACTOR.fewest), ATTRACTOR.max_rounds
        )
        self._intervals = int(np.ceil(rounds * orbit.duration / model.values["duration"]))
        self._radius = self._find_radius(model)

    def catches(self, states: Array) -> Mask:
        """Whether the last state lies in the region."""
        return np.asarray(self.distance(states[:, -1]) < self._radius)

    def distance(self, states: Array) -> Array:
        """Return the distance from its line."""
        return self._line.distance(states)

    def _find_radius(self, model: Model) -> float:
        directions, samples = self._directions(), self._line.samples
        nearby = samples[:: len(samples) // ATTRACTOR.probes][: ATTRACTOR.probes]
        # Farther away there may be another attractor inside, which few directions would meet.
        farthest = 0.25 * float((np.ptp(samples, axis=0) / self._scales).max())

        def nearer(tried: float) -> bool:
            if tried > farthest:
                return False
            trajectories = Trajectories(model, nearby + tried * directions * self._scales)
            ends = trajectories.advance(np.arange(ATTRACTOR.probes), self._intervals)[:, -1]
            return bool(np.all(self.distance(ends) < 0.5 * tried))

        return _farthest(nearer, 10 * ATTRACTOR.first_distance)


class CloudRegion(AttractorRegion):
    """A torus or chaos, represented by the states of one trajectory on it."""

    def __init__(self, model: Model, attractor: Attractor) -> None:
        from scipy.spatial import KDTree

        super().__init__(model, attractor)
        trajectory = Trajectories(model, attractor.state[None])
        states = trajectory.advance(np.arange(1), 3000)[0]
        self.points = states[np.isfinite(states).all(axis=1)]
        self._tree = KDTree(self._embedded(self.points))
        half = len(self.points) // 2
        others = KDTree(self._embedded(self.points[:half]))
        self._radius = 3.0 * float(
            np.quantile(others.query(self._embedded(self.points[half:]))[0], ATTRACTOR.inside)
        )

    def catches(self, states: Array) -> Mask:
        """Whether nearly all states of a trajectory lie on it."""
        return np.asarray((self.distance(states) < self._radius).mean(axis=1) >= ATTRACTOR.inside)

    def holds(self, other: CloudRegion) -> bool:
        """Whether another cloud is the same attractor."""
        return bool((self.distance(other.points) < self._radius).mean() > 0.5)

    def distance(self, states: Array) -> Array:
        """Return the distance from the nearest of its states."""
        inside = self._embedded(states)
        finite = np.isfinite(inside).all(axis=-1)
        result = np.full(states.shape[:-1], np.inf)
        result[finite] = self._tree.query(inside[finite])[0]
        return result

    def _embedded(self, states: Array) -> Array:
        """Return scaled states, with angles on circles."""
        return embedded(states, self._scales, self._whole)


def _farthest(nearer: Callable[[float], bool], tried: float) -> float:
    """Return the largest distance tried from which all trajectories approach, else zero."""
    if nearer(tried):
        for _ in range(ATTRACTOR.trials):
            if not nearer(ATTRACTOR.ratio * tried):
                break
            tried *= ATTRACTOR.ratio
        return tried
    for _ in range(ATTRACTOR.trials):
        tried /= ATTRACTOR.ratio
        if nearer(tried):
            return tried
    return 0.0


def _monodromy(model: Model, state: Array, period: int) -> Array:
    """Return the derivatives of a state some periods later, in scaled states."""
    growth = growth_from(model, state)
    matrices = growth.derivatives(period)
    if growth.integration.stopped is not None:
        growth = growth_through_stick(model, state)
        matrices = growth.derivatives(period)
    # Each trajectory has scales from its own start.
    ratios = growth.model.state_scales() / model.state_scales()
    return product(matrices.reshape(-1, *matrices.shape[2:])) * ratios[:, None] / ratios


def _across_rests(matrix: Array) -> Array:
    """Return what removes from states where contacts rest: perturbations that a map keeps."""
    left, values, right = np.linalg.svd(matrix - np.eye(len(matrix)))
    kept = values < ATTRACTOR.preserved
    across = np.linalg.pinv(left[:, kept].T @ right[kept].T, ATTRACTOR.preserved)
    return np.eye(len(matrix)) - right[kept].T @ across @ left[:, kept].T


def _metric(matrix: Array) -> Array:
    """Return W such that |W x| shrinks under a contracting matrix."""
    from scipy.linalg import solve_discrete_lyapunov

    products = solve_discrete_lyapunov(matrix.T, np.eye(len(matrix)))
    return np.asarray(np.linalg.cholesky(0.5 * (products + products.T)).T)


class AttractorSet:
    """The attractors found so far, and the search for others."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.known: list[AttractorRegion] = []
        self._slips = may_slip(model)  # else each orbit turns, sticking or not

    def attractor_near(self, states: Array, sticks: bool) -> AttractorRegion | None:
        """Return a new attractor that the last states of a trajectory converge to, if there is one.

        Shapes: states (m, n).
        """
        if not self.model.forced:
            return self._at_rest(states[-1]) or self._cycle(states, sticks)
        gaps = self._gaps(states)
        for k in np.flatnonzero(gaps < ATTRACTOR.nearly)[:3]:  # periods to try
            if self._is_known(states[-1], 10.0 * gaps[k] + ATTRACTOR.same):
                return None
            known = self._orbit(states[-1], int(k) + 1, sticks)
            if known is not None:
                return known
        return None

    def classified(self, state: Array, sticks: bool) -> AttractorRegion | None:
        """Return the torus or chaos that a trajectory is on by its exponents, new or known.

        If the exponents show a periodic trajectory, return its orbit if that is new. Shapes: state
        (n,).
        """
        if self._preserved:  # nothing attracts, chaotic or not
            return None
        for periods in ATTRACTOR.exponents:
            try:
                result = find_exponents(self.model, state, periods, ATTRACTOR.tolerance)
            except InputError:
                return None
            # Along an attractor volumes shrink, and the sum of exponents is their rate.
            if abs(result.estimates[-1].exponents.sum()) <= ATTRACTOR.preserved:
                return None
            if (
                result.classification.kind == "periodic"
                and result.classification.period is not None
            ):
                return self._orbit(result.state, result.classification.period, sticks)
            if result.classification.kind in ("torus", "chaos"):
                cloud = CloudRegion(result.model, of_exponents(result, self._next))
                clouds = [known for known in self.known if isinstance(known, CloudRegion)]
                return next((known for known in clouds if known.holds(cloud)), cloud)
        return None

    @cached_property
    def _preserved(self) -> bool:
        """Whether formulas show that nothing attracts, chaotic or not."""
        return preserves_volume(self.model)

    @property
    def _next(self) -> int:
        return len(self.known) + 1

    def _gaps(self, states: Array) -> Array:
        """Return the change of a trajectory over its last 1, 2, ... periods, in scaled states."""
        return distances(self.model, states[-1], states[-2:-18:-1])

    def _orbit(self, state: Array, period: int, sticks: bool) -> AttractorRegion | None:
        if not sticks and self._slips:
            (nodes,) = orbits_from(self.model, period, state[None])
            if nodes is None:
                return None
            state = nodes[0]
        any_parameter(self.model)  # else it would seem that there is no orbit
        try:
            orbit = periodic_orbit(self.model, period, state)
        except InputError:
            return None
        away = distances(self.model, stroboscopic_states(orbit), orbit.state)
        for shorter in range(1, period):
            if period % shorter == 0 and away[shorter] < ATTRACTOR.same:
                return self._orbit(orbit.state, shorter, sticks)
        if not _attracts(orbit) or self._is_known(orbit.state, ATTRACTOR.same):
            return None
        return PointRegion(orbit.model, of_orbit(orbit, self._next))

    def _at_rest(self, state: Array) -> AttractorRegion | None:
        rest = equilibrium_near(self.model, state)
        if rest is None or rest.growth >= 0 or rest.distance >= ATTRACTOR.nearly:
            return None
        if self._is_known(rest.state, ATTRACTOR.same):
            return None
        return PointRegion(self.model, at_rest(self.model, rest.state, self._next))

    def _cycle(self, states: Array, sticks: bool) -> AttractorRegion | None:
        state = states[-1]
        duration = None if sticks else self._round(states)  # one that sticks is simulated on
        if (duration is None and not sticks) or self._is_known(state, ATTRACTOR.near_cycle):
            return None
        try:
            orbit = periodic_orbit(self.model, state=state, duration=duration)
        except InputError:
            return None
        extent = np.ptp(orbit.nodes, axis=0) / self.model.state_scales()
        if (
            extent.max() < ATTRACTOR.point
            or not _attracts(orbit)
            or self._is_known(orbit.state, ATTRACTOR.near_cycle)
        ):
            return None
        return CycleRegion(self.model, orbit, of_orbit(orbit, self._next))

    def _round(self, states: Array) -> float | None:
        """Return the seconds after which the end of a trajectory nearly returns, if it does."""
        flow, count = flow_of(self.model), len(states) - 1
        constants = flow.constants_of(self.model)
        finely = flow.sample(
            states[:-1], np.zeros(count), np.ones(count), ATTRACTOR.samples, constants
        )
        passed = finely.reshape(-1, states.shape[1])[::-1]
        apart = wrap_angles(passed - states[-1], self.model.angle_periods)
        away = np.linalg.norm(apart / self.model.state_scales(), axis=1)
        left = np.flatnonzero(away > 0.5 * away.max())
        near = (
            left[0] + np.flatnonzero(away[left[0] :] < ATTRACTOR.nearly * away.max())
            if len(left)
            else left
        )
        if away.max() < ATTRACTOR.point or not len(near):
            return None
        (ends,) = np.nonzero(np.diff(near) > 1)
        first = near[: ends[0] + 1] if len(ends) else near
        nearest = int(first[away[first].argmin()])
        return (nearest + 1) * constants.period / ATTRACTOR.samples

    def _is_known(self, state: Array, reach: float) -> bool:
        points = [known for known in self.known if not isinstance(known, CloudRegion)]
        return any(float(known.distance(state)) < reach for known in points)


def _attracts(orbit: PeriodicOrbit) -> bool:
    return stability_word(orbit.multipliers, cycle=not orbit.model.forced) == "stable"
