"""Thresholds of many sets of parameters that need not be neighbours: responses side by side.

A response is carried up in the parameter until a multiplier has passed -1. The doubling is then
found and proved as in a map of thresholds (`batched_thresholds`).
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array, Mask
from slipfold.errors import BREAKDOWNS, InputError
from slipfold.flow.linear_response import linear_response
from slipfold.flow.switched.mode_equations import contacts_of
from slipfold.models.model import Model
from slipfold.models.variations import carried_whole
from slipfold.orbits.orbit_batch import OrbitBatch
from slipfold.thresholds.batched_orbits import find_orbits
from slipfold.thresholds.batched_thresholds import BatchedThresholds, Found, nothing_found
from slipfold.thresholds.stable_segment import SHARES, Segments

FIRST, LONGEST, SHORTEST = 0.02, 0.1, 1e-3
"""First, longest and shortest step, in spans."""

STEPS = 60
"""Steps after which a response is left alone."""

NEAR, FAR = 0.01, 0.05
"""Distance of an orbit from its guess, in scaled states: nearer, the next step may be longer;
farther, this one is taken again, shorter."""

BEGUN_NEAR = 0.3
"""An orbit this far from the linear response may belong to another branch."""

CLOSE = 1e-5
"""Orbits are corrected until a correction is shorter than this."""


def first_doublings(models: Sequence[Model], vary: str, span: tuple[float, float]) -> Array:
    """Return where responses first lose their stability by period doubling, shape (m,).

    NaN where that is not proved: what such a response does has to be found by itself. All models
    are of one kind.
    """
    values = np.full(len(models), np.nan)
    some, found = proved_doublings(BatchedThresholds(models[0], vary, span), models, vary)
    values[some[found.loses]] = found.segments.ends[found.loses]
    return values


def proved_doublings(
    batches: BatchedThresholds, models: Sequence[Model], vary: str
) -> tuple[NDArray[np.int64], Found]:
    """Return which responses come to a doubling, and what was found of these."""
    model, count = models[0], len(models[0].states)
    slips = all(contact.limits for contact in contacts_of(model))
    turns = np.any(model.whole_turns)
    parameters = np.array([item.vector for item in models])
    scales = np.array([item.state_scales() for item in models])
    orbits = batches.orbits(parameters, scales)
    carried = _Carried(orbits, (batches.first, batches.last))
    if model.forced and slips and not turns and carried_whole(count):
        carried.begin(models, vary)
        for _ in range(STEPS):
            if not carried.going.any():
                break
            carried.step()
    some = np.flatnonzero(np.isfinite(carried.ends))
    if not len(some):
        return some, nothing_found(count)
    guess = Segments(carried.ends[some], carried.paths(some))
    return some, batches.doublings(parameters[some], scales[some], guess)


class _Carried:
    """Responses on their way through the span.

    `ends` are guesses of where they double, NaN where there is none so far.
    """

    def __init__(self, orbits: OrbitBatch, span: tuple[float, float]) -> None:
        self._orbits, self._span = orbits, span
        m, n = orbits.scales.shape
        self.going: Mask = np.full(m, True)
        self.ends = np.full(m, np.nan)
        self._share, self._step, self._last_step = np.zeros(m), np.full(m, FIRST), np.zeros(m)
        self._states, self._change = np.full((m, n), np.nan), np.zeros((m, n))
        self._flip = np.full(m, np.nan)  # det (I + M), zero at a doubling
        self._known: list[list[tuple[float, Array]]] = [[] for _ in range(m)]

    def begin(self, models: Sequence[Model], vary: str) -> None:
        """Find the responses at the first value from the linear ones."""
        guesses = self._states.copy()
        for guess, model, scales in zip(guesses, models, self._orbits.scales, strict=True):
            with suppress(InputError, *BREAKDOWNS):  # of others at that value nothing is known
                there = model.replace(**{vary: self._span[0]})
                flow = self._orbits.flow
                constants = flow.constants(there.vector)
                guess[:] = linear_response(flow, constants, scales, 1, there.start)[0]
        everywhere, first = np.arange(len(models)), np.zeros(len(models))
        self._accept(everywhere, first, guesses, BEGUN_NEAR)
        self.going &= np.isfinite(self._states).all(axis=1)

    def step(self) -> None:
        """Take a step with each response that is on its way."""
        some = np.flatnonzero(self.going)
        step = np.minimum(self._step[some], 1 - self._share[some])
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.nan_to_num(step / self._last_step[some], nan=0.0, posinf=0.0)
        guesses = self._states[some] + ratio[:, None] * self._change[some]
        accepted = self._accept(some, self._share[some] + step, guesses, FAR)
        self._step[some[~accepted]] = step[~accepted] / 2
        at_end = self._share[some] >= 1
        self.going[some[at_end | (self._step[some] < SHORTEST)]] = False

    def _accept(self, some: NDArray[np.int64], shares: Array, guesses: Array, far: float) -> Mask:
        """Correct guesses, keep what is near them; return which that is."""
        own = self._orbits.rows(some)
        orbits = find_orbits(own, guesses, self._value_at(shares), CLOSE)
        states = own.states(np.arange(len(some)), orbits.z)[:, 0]
        distance = np.linalg.norm((states - guesses) / own.scales, axis=1)
        with np.errstate(invalid="ignore"):
            good = np.asarray(distance < far)
            unstable = (np.abs(orbits.multipliers) > 1).sum(axis=1)
        flip = (1 + orbits.multipliers).prod(axis=1).real
        for i in np.flatnonzero(good):
            case = some[i]
            self._known[case].append((shares[i], states[i]))
            moved = shares[i] - self._share[case]
            if unstable[i] == 1 and flip[i] < 0 < self._flip[case]:
                share = shares[i] - moved * flip[i] / (flip[i] - self._flip[case])
                self.ends[case] = self._span[0] + share * (self._span[1] - self._span[0])
            self.going[case] = not unstable[i]
            self._change[case] = states[i] - self._states[case] if moved else 0.0
            self._states[case], self._flip[case] = states[i], flip[i]
            self._share[case], self._last_step[case] = shares[i], moved
            if distance[i] < NEAR and moved:
                self._step[case] = min(1.6 * moved, LONGEST)
        return good

    def paths(self, some: NDArray[np.int64]) -> Array:
        """Guess the states at `SHARES` of the way to the ends, shape (k, len(SHARES), n)."""
        first, last = self._span
        found = []
        for case in some:
            shares, states = zip(*self._known[case], strict=True)
            wanted = np.array(SHARES) * (self.ends[case] - first) / (last - first)
            found.append([np.interp(wanted, shares, column) for column in np.array(states).T])
        return np.swapaxes(np.array(found), 1, 2)

    def _value_at(self, shares: Array) -> Array:
        """Return the parameter at shares of the span."""
        return np.asarray(self._span[0] + shares * (self._span[1] - self._span[0]))
