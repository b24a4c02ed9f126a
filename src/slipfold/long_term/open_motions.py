"""Motions that do not repeat yet: tori, chaos, or slow ways to a response, by pairs of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.ensembles import Crowd
from slipfold.long_term.birkhoff import average, bump
from slipfold.long_term.repeats import NEAR, repeats_of
from slipfold.long_term.verdict import SURE
from slipfold.models.model import Model
from slipfold.models.turns import mean_state, without_turns

PERIODIC, STICKS, STOPPED = "periodic", "sticks", "stopped"
TORUS, CHAOS, UNDECIDED = "torus", "chaos", "undecided"

PERIODS = (1000, 4000)
"""Forcing periods of pairs, one after the other."""

APART = 1e-7
"""Distance of a pair in scales: far above what steps in common leave of rounding."""

ZERO = 3e-4
"""Exponents a period that may be those of a torus, and their largest errors; no chaos is told."""

ROUNDING = 1e-7
"""Exponents a period that steps and rounding may leave of zero."""

EVEN = 2e-5
"""Errors of the exponents of chaos are larger: what grows more evenly leaves a response.

So does what nearly repeats at the beginning, which is not chaotic yet.
"""

LEAVES = 1e-2
"""Change in scales over some periods, at the beginning, of what may leave a response later."""

SHRUNK = 0.9
"""Share of its distance to a response that a motion has left at most, if it is seen to come to it;
less where its exponent lets expect less."""

KEPT = 48
"""Periods in which a motion is seen to repeat."""

CLASSES = 24
"""States are averaged apart by their number modulo this: periods that divide it show."""


@dataclass(frozen=True, eq=False)
class Told:
    """What motions do; shapes (k, ...). Of an interruption only those not undecided are told."""

    kinds: NDArray[np.object_]
    periods: NDArray[np.int64]
    exponents: Array
    states: Array
    means: Array
    interrupted: bool = False


def tell_open(
    models: list[Model], states: Array, tell: Callable[[int, int], None] = lambda done, more: None
) -> Told:
    """Follow each motion beside another one close to it; who is told may interrupt.

    The exponent is the mean growth of their distance, which is made small again each period. If it
    is above zero the motion is chaotic, if it is zero within its error a torus. If it is below,
    nearby motions come to one response: averages over states of equal number modulo 24 say of what
    period, if motions are coming nearer to these averages. What is judged when somebody interrupts
    is kept.

    Shapes: states (k, n).
    """
    found = Told(
        np.full(len(states), UNDECIDED, object),
        np.zeros(len(states), np.int64),
        np.full(len(states), np.nan),
        states.copy(),
        np.full(states.shape, np.nan),
    )
    rest = np.arange(len(states))
    try:
        for round_, periods in enumerate(PERIODS):
            if round_:
                tell(0, 2 * periods * len(rest))
            pairs = _Pairs([models[row] for row in rest], found.states[rest], periods)
            for _ in range(periods):
                pairs.go_on()
                tell(2 * len(rest), 0)
            pairs.judge(found, rest)
            rest = rest[found.kinds[rest] == UNDECIDED]
            if not len(rest):
                break
    except KeyboardInterrupt:
        return replace(found, interrupted=True)
    return found


class _Pairs:
    """Motions, each beside another one, for some periods."""

    def __init__(self, models: list[Model], states: Array, periods: int) -> None:
        self._scales, self._turns = models[0].state_scales(), models[0].whole_turns
        self._count, n = states.shape
        direction = np.random.default_rng(0).normal(size=states.shape)
        direction /= np.linalg.norm(direction, axis=1)[:, None]
        beside = states + APART * direction * self._scales
        # Side by side, so that a pair takes the same steps.
        both = np.stack([states, beside], axis=1).reshape(-1, n)
        self._crowd = Crowd([model for model in models for _ in range(2)], both)
        self._logarithms = np.zeros((periods, self._count))
        self._weights = bump(periods)
        self._sums = np.zeros((CLASSES, self._count, n))
        self._shares = np.zeros(CLASSES)
        self._first = np.empty((KEPT, self._count, n))
        self._last = np.full((KEPT, self._count, n), np.nan)
        self._sticks = np.zeros(self._count, bool)
        self._done = 0

    def go_on(self) -> None:
        """Carry all pairs over a period."""
        crowd = self._crowd
        crowd.go_on()
        states = crowd.states
        base = states[::2]
        between = without_turns(states[1::2] - base, self._turns) / self._scales
        distance = np.linalg.norm(between, axis=1)
        self._sticks |= crowd.stuck.reshape(-1, 2).any(axis=1)
        crowd.leave(np.repeat(self._sticks, 2))
        with np.errstate(divide="ignore", invalid="ignore"):
            self._logarithms[self._done] = np.log(distance / APART)
            between *= (APART / distance)[:, None]
        moved = np.full_like(states, np.nan)
        moved[1::2] = base + between * self._scales
        moved[1::2][self._sticks] = np.nan
        crowd.move(moved)
        place, weight = self._done % CLASSES, self._weights[self._done]
        if self._done < KEPT:
            self._first[self._done] = base
        near = self._first[place]  # of the same number: an angle is taken next to that
        self._sums[place] += weight * (near + without_turns(base - near, self._turns))
        self._shares[place] += weight
        self._last[self._done % KEPT] = base
        self._done += 1

    def judge(self, found: Told, rows: NDArray[np.intp]) -> None:
        """Say what the motions do, as far as that is clear."""
        last = np.roll(self._last, -(self._done % KEPT), axis=0)
        stopped = np.array([stop is not None for stop in self._crowd.stopped])[::2]
        repeats = repeats_of(last.transpose(1, 0, 2), self._scales, self._turns)
        grown = average(np.nan_to_num(self._logarithms[len(self._logarithms) // 4 :]))
        averages = self._sums / self._shares[:, None, None]
        for place, row in enumerate(rows):
            exponent, error = grown.values[place], grown.errors[place]
            found.states[row] = last[-1, place]
            found.exponents[row] = exponent
            slack = SURE * error + ROUNDING
            if stopped[place] or self._sticks[place]:
                found.kinds[row] = STOPPED if stopped[place] else STICKS
                found.exponents[row] = np.nan
            elif repeats[place]:
                self._set_periodic(found, row, last[-repeats[place] :, place])
            elif exponent > slack + ZERO and error > EVEN:
                if not self._nearly_repeats(self._first[:, place]):
                    found.kinds[row] = CHAOS
            elif error > ZERO:
                continue
            elif abs(exponent) <= min(slack, ZERO):
                found.kinds[row] = TORUS
            elif exponent < -slack and exponent * self._done < np.log(SHRUNK):
                # Of orbits of long periods averages are equal, too, but nothing shrinks.
                share = min(SHRUNK, np.exp(exponent * self._done / 2))
                states = self._first[:, place], last[:, place]
                period = self._comes_to(averages[:, place], *states, share)
                if period:
                    self._set_periodic(found, row, averages[:period, place])

    def _set_periodic(self, found: Told, row: int, states: Array) -> None:
        found.kinds[row], found.periods[row] = PERIODIC, len(states)
        found.means[row] = mean_state(states, self._turns)

    def _nearly_repeats(self, states: Array) -> bool:
        """Whether a motion has a response nearby, which it may be about to leave."""
        changes = [
            np.abs(without_turns(states[period:] - states[:-period], self._turns) / self._scales)
            for period in range(1, KEPT // 3 + 1)
        ]
        return min(change.max() for change in changes) < LEAVES

    def _comes_to(self, averages: Array, first: Array, last: Array, share: float) -> int:
        """Return the period of the averages, if the motion comes nearer to them; else 0."""
        numbers = np.arange(KEPT)
        late = (self._done - KEPT + numbers) % CLASSES
        before, after = (
            np.abs(without_turns(states - averages[which], self._turns) / self._scales).max()
            for states, which in ((first, numbers % CLASSES), (last, late))
        )
        if not after < max(share * before, NEAR):
            return 0
        for period in (1, 2, 3, 4, 6, 8, 12, 24):
            between = averages - averages[numbers[:CLASSES] % period]
            apart = np.abs(without_turns(between, self._turns) / self._scales).max()
            if apart <= max(NEAR, 0.1 * after):
                return period
        return 0
