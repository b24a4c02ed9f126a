"""An attractor that is known: which states are so near to it that their motions end there."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.long_term.attractor import Attractor
from slipfold.long_term.cycle_line import CycleLine
from slipfold.long_term.growth import growth_from, growth_through_stick
from slipfold.long_term.motions import Motions
from slipfold.models.model import Model
from slipfold.models.turns import without_turns
from slipfold.orbits.periodic_orbit import PeriodicOrbit

NEAR = 1e-4
"""Distance, in scaled states, that is tried first: what attracts should be linear there."""

FARTHER, TIMES = 4, 7
"""By how much that distance is made longer at a time, and how often at most; if need be shorter."""

PROBES = 24
"""States at a distance whose motions must come nearer."""

SAME = 1e-6
"""Distance, in scaled states, of two orbits that are one."""

ACROSS = 0.25
"""Share of its own width at which nothing more is taken to come to a cycle without being tried."""

DECAY, FEWEST, MOST_ROUNDS = 0.03, 2, 100
"""By how much the multipliers shorten distances from a cycle in the rounds in which motions must
come nearer by half, and how many rounds these are at least and at most: what is not orthogonal to
the others grows at first."""

POINTS = 3000
"""States at phase zero that stand for a torus or for chaos."""

SPACINGS = 3.0
"""Distance from such a state, in the distance at which others follow, that lies on it."""

INSIDE = 0.9
"""Share of the states of a motion on it that lie so near."""


class Known(ABC):
    """An attractor, with what lies near it."""

    def __init__(self, model: Model, attractor: Attractor) -> None:
        self.attractor = attractor
        self._scales, self._whole = model.state_scales(), model.whole_turns

    @abstractmethod
    def catches(self, strobes: Array) -> NDArray[np.bool_]:
        """Whether each motion ends here, by its last states, shapes (k, m, n), returns (k,)."""

    @abstractmethod
    def distance(self, states: Array) -> Array:
        """Return how far states are from it, in scaled states. Shapes: (..., n), returns (...)."""

    def _apart(self, states: Array, points: Array) -> Array:
        return without_turns(states - points, self._whole) / self._scales

    def _directions(self) -> Array:
        """Directions in which motions are tried, of length one, shape (PROBES, n)."""
        found = np.random.default_rng(0).standard_normal((PROBES, len(self._scales)))
        return np.asarray(found / np.linalg.norm(found, axis=1)[:, None])


class KnownPoint(Known):
    """A periodic orbit seen once a period, or an equilibrium seen at intervals.

    Near it distances are measured so that each round makes them shorter: with the monodromy matrix
    M of spectral radius r, in the norm x' P x of M' P M - r P + r = 0. How far that holds in the
    equations themselves motions tell that begin at such distances.
    """

    def __init__(self, model: Model, attractor: Attractor) -> None:
        super().__init__(model, attractor)
        self._period = attractor.period or 1
        motion = Motions(model, attractor.state[None])
        self.points = motion.go_on(np.arange(1), self._period)[0, :-1]
        matrix = _monodromy(model, attractor.state, self._period)
        radius = max(float(np.abs(np.linalg.eigvals(matrix)).max()), 1e-2)
        self._metric = _metric(matrix / np.sqrt(radius))
        self._rate = 0.5 * (1 + np.sqrt(radius))
        self._reach = self._found_reach(model)

    def catches(self, strobes: Array) -> NDArray[np.bool_]:
        """Whether a motion passed near it once."""
        return np.asarray((self._length(strobes) < self._reach).any(axis=1))

    def distance(self, states: Array) -> Array:
        """Return the distance from the nearest of its states at phase zero."""
        apart = self._apart(states[..., None, :], self.points)
        return np.asarray(np.abs(apart).max(axis=-1).min(axis=-1))

    def _length(self, states: Array) -> Array:
        apart = self._apart(states, self.attractor.state)
        with np.errstate(invalid="ignore"):
            return np.asarray(np.linalg.norm(apart @ self._metric.T, axis=-1))

    def _found_reach(self, model: Model) -> float:
        """Return the largest of some distances from which every motion comes nearer."""
        around = np.linalg.solve(self._metric, self._directions().T).T * self._scales

        def nearer(tried: float) -> bool:
            motions = Motions(model, self.attractor.state + tried * around)
            ends = motions.go_on(np.arange(PROBES), self._period)[:, -1]
            return bool(np.all(self._length(ends) < self._rate * tried))  # not of what is no number

        return _farthest(nearer, NEAR)


class KnownCycle(Known):
    """A cycle of an autonomous model, near which only the distance across it counts."""

    def __init__(self, model: Model, orbit: PeriodicOrbit, attractor: Attractor) -> None:
        super().__init__(model, attractor)
        self._line = CycleLine(orbit, self._scales)
        across = np.delete(orbit.multipliers, np.abs(orbit.multipliers - 1).argmin())
        rate = min(max(float(np.abs(across).max(initial=0.0)), 1e-3), 1 - 1e-3)
        rounds = min(max(np.log(DECAY) / np.log(rate), FEWEST), MOST_ROUNDS)
        self._intervals = int(np.ceil(rounds * orbit.duration / model.values["duration"]))
        self._reach = self._found_reach(model)

    def catches(self, strobes: Array) -> NDArray[np.bool_]:
        """Whether a motion has come beside it, which it then does not leave."""
        return np.asarray(self.distance(strobes[:, -1]) < self._reach)

    def distance(self, states: Array) -> Array:
        """Return the distance from its line."""
        return self._line.distance(states)

    def _found_reach(self, model: Model) -> float:
        directions, samples = self._directions(), self._line.samples
        beside = samples[:: len(samples) // PROBES][:PROBES]
        # What is farther may be another attractor inside of it, which few directions would meet.
        farthest = ACROSS * float((np.ptp(samples, axis=0) / self._scales).max())

        def nearer(tried: float) -> bool:
            if tried > farthest:
                return False
            motions = Motions(model, beside + tried * directions * self._scales)
            ends = motions.go_on(np.arange(PROBES), self._intervals)[:, -1]
            return bool(np.all(self.distance(ends) < 0.5 * tried))

        return _farthest(nearer, 10 * NEAR)


class KnownCloud(Known):
    """A torus or chaos, by the states of one motion on it."""

    def __init__(self, model: Model, attractor: Attractor) -> None:
        from scipy.spatial import KDTree

        super().__init__(model, attractor)
        motion = Motions(model, attractor.state[None])
        states = motion.go_on(np.arange(1), POINTS)[0]
        self.points = states[np.isfinite(states).all(axis=1)]
        self._tree = KDTree(self._embedded(self.points))
        half = len(self.points) // 2
        others = KDTree(self._embedded(self.points[:half]))
        self._reach = SPACINGS * float(
            np.quantile(others.query(self._embedded(self.points[half:]))[0], INSIDE)
        )

    def catches(self, strobes: Array) -> NDArray[np.bool_]:
        """Whether nearly all states of a motion lie on it."""
        return np.asarray((self.distance(strobes) < self._reach).mean(axis=1) >= INSIDE)

    def holds(self, other: KnownCloud) -> bool:
        """Whether another is the same: of two attractors each lies beside the other."""
        return bool((self.distance(other.points) < self._reach).mean() > 0.5)

    def distance(self, states: Array) -> Array:
        """Return the distance from the nearest of its states."""
        inside = self._embedded(states)
        finite = np.isfinite(inside).all(axis=-1)
        found = np.full(states.shape[:-1], np.inf)
        found[finite] = self._tree.query(inside[finite])[0]
        return found

    def _embedded(self, states: Array) -> Array:
        """Return scaled states, with angles on circles."""
        turning = self._whole > 0
        angles = states[..., turning]
        parts = [states[..., ~turning] / self._scales[~turning], np.cos(angles), np.sin(angles)]
        return np.concatenate(parts, axis=-1)


def _farthest(nearer: Callable[[float], bool], tried: float) -> float:
    """Return the largest of some distances from which all motions come nearer; zero if none is."""
    if nearer(tried):
        for _ in range(TIMES):
            if not nearer(FARTHER * tried):
                break
            tried *= FARTHER
        return tried
    for _ in range(TIMES):
        tried /= FARTHER
        if nearer(tried):
            return tried
    return 0.0


def _monodromy(model: Model, state: Array, period: int) -> Array:
    """Return the derivatives of a state some periods later, in scaled states."""
    growth = growth_from(model, state)
    matrices = growth.carried(period)
    if growth.stopped is not None:
        growth = growth_through_stick(model, state)
        matrices = growth.carried(period)
    found = np.eye(len(state))
    for matrix in matrices.reshape(-1, *found.shape):
        found = matrix @ found
    # A motion is scaled by its own start.
    ratios = growth.model.state_scales() / model.state_scales()
    return found * ratios[:, None] / ratios


def _metric(matrix: Array) -> Array:
    """Return W so that |W x| shrinks under a contracting matrix."""
    from scipy.linalg import solve_discrete_lyapunov

    products = solve_discrete_lyapunov(matrix.T, np.eye(len(matrix)))
    return np.asarray(np.linalg.cholesky(0.5 * (products + products.T)).T)
