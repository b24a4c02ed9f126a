"""Many motions in groups that march side by side, on all cores."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.flow import flow_of
from slipfold.flow.guarded_flow import Stop
from slipfold.flow.simulate import LARGEST, unbounded_at
from slipfold.flow.strobes.march import TOGETHER, March
from slipfold.flow.strobes.own_motion import OwnMotion
from slipfold.flow.switched.simulate import told_in_slip
from slipfold.models.model import Model
from slipfold.models.turns import without_turns
from slipfold.threads import cores


class Crowd:
    """Motions from one forcing period to the next; a context, in which threads are kept."""

    def __init__(
        self,
        models: list[Model],
        starts: Array,
        threads: int | None = None,
    ) -> None:
        self._groups = [
            _Group(models[first : first + TOGETHER], starts[first : first + TOGETHER])
            for first in range(0, len(starts), TOGETHER)
        ]
        self._pool = ThreadPoolExecutor(min(threads or cores(), len(self._groups)))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._pool.shutdown()

    @property
    def states(self) -> Array:
        """Present states, NaN of motions that stopped, shape (k, n)."""
        return np.concatenate([group.states.T for group in self._groups])

    @property
    def stuck(self) -> NDArray[np.bool_]:
        """Whether a contact stuck or was open in the last period, shape (k,)."""
        return np.concatenate([group.stuck for group in self._groups])

    @property
    def stopped(self) -> tuple[Stop | None, ...]:
        """Why and when each motion ended early."""
        return tuple(stop for group in self._groups for stop in group.stopped)

    def go_on(self) -> None:
        """Carry all motions over a period."""
        if len(self._groups) == 1:  # without the detour through another thread
            self._groups[0].go_on()
        else:
            list(self._pool.map(_Group.go_on, self._groups))

    def move(self, states: Array) -> None:
        """Put motions elsewhere; those left out are NaN. Shapes: states (k, n)."""
        first = 0
        for group in self._groups:
            some = states[first : first + len(group.models)]
            kept = np.isfinite(some).all(axis=1)
            group.states[:, kept] = some[kept].T
            first += len(group.models)

    def leave(self, which: NDArray[np.bool_]) -> None:
        """Let some motions stay where they are from now on. Shapes: which (k,)."""
        first = 0
        for group in self._groups:
            group.left |= which[first : first + len(group.models)]
            first += len(group.models)


class _Group:
    """Motions that march together while they can."""

    def __init__(self, models: list[Model], starts: Array) -> None:
        self.models = models
        self.states = starts.T.copy()
        self.stopped: list[Stop | None] = [None] * len(models)
        self.stuck = np.zeros(len(models), bool)
        self.left = np.zeros(len(models), bool)
        self._over = np.zeros(len(models), bool)  # which have stopped
        flow, first = flow_of(models[0]), models[0]
        parameters = np.array([model.vector for model in models])
        scales = flow.constants_of(first).scales
        self._constants = flow.constants(parameters, np.tile(scales, (len(models), 1)))
        # Elsewhere contacts may stick at any time.
        slips = told_in_slip(first, starts, self._constants)
        self._march = March(first, self._constants) if slips else None
        self._own: dict[int, OwnMotion] = {}
        self._scales = scales[:, None]
        self._done = 0

    def go_on(self) -> None:
        """Carry all motions over a period."""
        before = self.states
        over = self.left | self._over
        if over.all():
            return
        alone = over | self.stuck
        # Those that go on by themselves keep their places: the state of another stands in for them.
        going = np.flatnonzero(~alone)
        after = np.full_like(before, np.nan)
        if self._march is not None and len(going):
            after = self._march.period(np.where(alone, before[:, going[:1]], before))
            after[:, alone] = np.nan
            after[:, np.abs(after / self._scales).max(axis=0) > LARGEST] = np.nan
        self.stuck &= np.isnan(after).any(axis=0) | self.left
        after[:, self.left] = before[:, self.left]
        for lane in np.flatnonzero(np.isnan(after).any(axis=0) & ~over):
            after[:, lane] = self._alone(int(lane), before[:, lane])
        self.states = without_turns(after.T, self.models[0].whole_turns).T
        self._done += 1

    def _alone(self, lane: int, state: Array) -> Array:
        if lane not in self._own:
            self._own[lane] = OwnMotion(self.models[lane], self._constants.rows(lane), state)
        own, after = self._own[lane], np.full_like(state, np.nan)
        for reached in own.go_on(state, 1, self._done):
            after = reached
        size = np.abs(after / self._scales[:, 0]).max()
        if own.stopped is None and not size <= LARGEST:
            time = (self._done + 1) * self._constants.rows(lane).period
            own.stopped, after = unbounded_at(time, size), np.full_like(after, np.nan)
        self.stopped[lane], self.stuck[lane] = own.stopped, own.stuck
        self._over[lane] = own.stopped is not None
        return after
