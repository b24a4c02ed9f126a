"""Classification of ensembles of trajectories: periodic, torus, chaos, sticking or stopped."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array, Indices, Mask
from slipfold.flow.ensembles import BatchSteps, Ensemble, models_with
from slipfold.flow.equilibrium import EQUILIBRIUM
from slipfold.flow.explicit_steps import EXPLICIT
from slipfold.flow.flow import flow_of
from slipfold.long_term.exponents import EXPONENTS, average, bump
from slipfold.models.angles import ScaledStates, distances, mean_state, wrap_angles
from slipfold.models.model import Model
from slipfold.progress import Observer, Progress


class CLASSIFICATION:
    """When a trajectory counts as periodic, torus or chaos."""

    floor: float = 1e-8  # change in scales over a period that may be an error of the integration
    near: float = 1e-3  # distance from its limit at which a trajectory counts as converged
    pair_periods: tuple[int, ...] = (1000, 4000)  # of pairs in the first and second attempt
    separation: float = 1e-7  # of a pair in scales: far above rounding, as both take the same steps
    zero: float = 3e-4  # largest exponent per period of a torus, and its largest error
    shrunk: float = 0.9  # largest fraction of its distance that a converging trajectory keeps
    recent: int = 48  # last periods in which a trajectory must repeat
    longest: int = 16  # period that is looked for
    classes: int = 24  # states are averaged by their number modulo this: shows its divisors
    stuck: int = 32  # periods with stick after which a trajectory is left
    batch: int = 2048  # trajectories; an interruption loses at most one batch
    same_mean: float = 1e-2  # distance between the means of two responses of one period
    transient: int = 400  # forcing periods before a trajectory in a region must repeat
    margin: int = 2  # cells between a place and the border of its region


def repeats_of(model: ScaledStates, states: Array) -> Indices:
    """Return the period of each trajectory in states; 0 where it is unknown.

    The change over a period is an error of the integration, or it shrinks so fast that the changes
    still to come, a geometric series, are small. A trajectory that spirals into a response nearly
    repeats after each revolution, so the period is the shortest one with a change that small. A
    change over half the period that is next to nothing will still fade.

    Shapes: states (..., m, n); returns (...).
    """
    count = states.shape[-2]
    result = np.zeros(states.shape[:-2], np.int64)
    changes, left = {}, np.zeros(states.shape[:-2])
    for period in range(1, min(CLASSIFICATION.longest, count // 3) + 1):
        change = distances(model, states[..., period:, :], states[..., :-period, :])
        width = max(change.shape[-1] // 3, 1)
        first, last = change[..., :width].max(axis=-1), change[..., -width:].max(axis=-1)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = last / first
            rate = ratio ** (period / (change.shape[-1] - width))
            rest = last * rate / (1 - rate)
        settles = (last <= CLASSIFICATION.floor) | ((ratio < 0.9) & (rest <= CLASSIFICATION.near))
        new = settles & (result == 0)
        result[new], left[new] = (
            period,
            np.where(last <= CLASSIFICATION.floor, CLASSIFICATION.floor, rest)[new],
        )
        changes[period] = last
    for period in sorted(changes, reverse=True):
        # A spiral is up to four times as far apart as its distance from the response.
        within = (result % period == 0) & (result > 0) & (changes[period] <= 4 * left)
        result[within] = period
    for period in sorted(changes, reverse=True):
        # So small a change over part of a period will fade.
        result[(result > period) & (result % period == 0) & (changes[period] <= 1e-5)] = period
    return result


def sampled_outputs(model: Model, vary: str, values: Array, states: Array, samples: int) -> Array:
    """Return all outputs at equal intervals of the forcing period that follows each state.

    NaN of a trajectory that sticks.

    Shapes: values (m,); states (m, n); returns (m, samples, n_outputs).
    """
    flow = flow_of(model)
    parameters = np.tile(model.vector, (len(values), 1))
    parameters[:, [item.name for item in model.parameters].index(vary)] = values
    scales = np.tile(flow.constants_of(model).scales, (len(values), 1))
    result = np.empty((len(values), samples, len(flow.output_names)))
    phases = np.arange(samples) / samples
    for first in range(0, len(values), EXPLICIT.ensemble_batch):
        some = slice(first, first + EXPLICIT.ensemble_batch)
        constants = flow.constants(parameters[some], scales[some])
        between = states[None, some]
        if samples > 1:
            steps = BatchSteps(model, constants)
            between = steps.samples(states[some].T, samples).transpose(0, 2, 1)
        for index, phase in enumerate(phases):
            rows = np.full(between.shape[1], phase)
            result[some, index] = flow.outputs(between[index], rows, constants)
    return result


PERIODIC, STICKS, STOPPED = "periodic", "sticks", "stopped"
TORUS, CHAOS, UNDECIDED = "torus", "chaos", "undecided"


@dataclass(frozen=True, eq=False)
class Classified:
    """What trajectories do; shapes (k, ...), or of r runs (r, k, ...)."""

    kinds: NDArray[np.object_]
    periods: Indices
    exponents: Array
    states: Array
    means: Array
    changes: Array  # of the state over the period, in scales; NaN where it was not seen

    @classmethod
    def unknown(cls, kind: str, states: Array) -> Classified:
        """Return trajectories of which the states alone are known. Shapes: states (..., n)."""
        shape = states.shape[:-1]
        exponents, changes = np.full((2, *shape), np.nan)
        periods = np.zeros(shape, np.int64)
        means = np.full_like(states, np.nan)
        return cls(np.full(shape, kind, object), periods, exponents, states, means, changes)

    def put(self, rows: Any, others: Classified) -> None:
        """Replace a subset."""
        for name, values in vars(others).items():
            getattr(self, name)[rows] = values

    def rows(self, rows: Any) -> Classified:
        """Return a subset."""
        return Classified(*(values[rows] for values in vars(self).values()))

    def joined(self, others: Classified) -> Classified:
        """Return these runs and others."""
        pairs = zip(vars(self).values(), vars(others).values(), strict=True)
        return Classified(*(np.concatenate(pair) for pair in pairs))


def classify_open(
    models: list[Model],
    states: Array,
    on_progress: Callable[[int, int], None] = lambda done, more: None,
) -> tuple[Classified, bool]:
    """Follow each trajectory and a neighbor; return whether that was interrupted.

    The exponent is the mean growth of their distance, which is reset each period. A trajectory with
    a positive exponent is chaotic; with one that is zero within its error it is a torus. A negative
    exponent means a response. Its period follows from averages over states of equal number modulo
    24 if trajectories approach these averages. After an interruption those that are not yet
    classified are undecided.

    Shapes: states (k, n).
    """
    result = Classified.unknown(UNDECIDED, states.copy())
    rest = np.arange(len(states))
    try:
        for round_, periods in enumerate(CLASSIFICATION.pair_periods):
            if round_:
                on_progress(0, 2 * periods * len(rest))
            pairs = _Pairs([models[row] for row in rest], result.states[rest], periods)
            for _ in range(periods):
                pairs.advance()
                on_progress(2 * len(rest), 0)
            pairs.judge(result, rest)
            rest = rest[result.kinds[rest] == UNDECIDED]
            if not len(rest):
                break
    except KeyboardInterrupt:
        return result, True
    return result, False


class _Pairs:
    """Trajectories, each with a neighbor, for some periods."""

    def __init__(self, models: list[Model], states: Array, periods: int) -> None:
        self._model = models[0]
        self._scales, self._angle_periods = self._model.state_scales(), self._model.angle_periods
        self._count, n = states.shape
        direction = np.random.default_rng(0).normal(size=states.shape)
        direction /= np.linalg.norm(direction, axis=1)[:, None]
        nearby = states + CLASSIFICATION.separation * direction * self._scales
        # In one batch, so that a pair takes the same steps.
        both = np.stack([states, nearby], axis=1).reshape(-1, n)
        self._ensemble = Ensemble([model for model in models for _ in range(2)], both)
        self._logarithms = np.zeros((periods, self._count))
        self._weights = bump(periods)
        self._sums = np.zeros((CLASSIFICATION.classes, self._count, n))
        self._weight_sums = np.zeros(CLASSIFICATION.classes)
        self._first = np.empty((CLASSIFICATION.recent, self._count, n))
        self._last = np.full((CLASSIFICATION.recent, self._count, n), np.nan)
        self._sticks = np.zeros(self._count, bool)
        self._done = 0

    def advance(self) -> None:
        """Propagate all pairs over a period."""
        ensemble = self._ensemble
        ensemble.advance()
        states = ensemble.states
        base = states[::2]
        between = wrap_angles(states[1::2] - base, self._angle_periods) / self._scales
        distance = np.linalg.norm(between, axis=1)
        self._sticks |= ensemble.stuck.reshape(-1, 2).any(axis=1)
        ensemble.leave(np.repeat(self._sticks, 2))
        with np.errstate(divide="ignore", invalid="ignore"):
            self._logarithms[self._done] = np.log(distance / CLASSIFICATION.separation)
            between *= (CLASSIFICATION.separation / distance)[:, None]
        moved = np.full_like(states, np.nan)
        moved[1::2] = base + between * self._scales
        moved[1::2][self._sticks] = np.nan
        ensemble.move(moved)
        index, weight = self._done % CLASSIFICATION.classes, self._weights[self._done]
        if self._done < CLASSIFICATION.recent:
            self._first[self._done] = base
        near = self._first[index]  # of the same number: an angle is taken next to that
        self._sums[index] += weight * (near + wrap_angles(base - near, self._angle_periods))
        self._weight_sums[index] += weight
        self._last[self._done % CLASSIFICATION.recent] = base
        self._done += 1

    def judge(self, result: Classified, rows: Indices) -> None:
        """Classify the trajectories where the evidence is clear."""
        last = np.roll(self._last, -(self._done % CLASSIFICATION.recent), axis=0)
        stopped = np.array([stop is not None for stop in self._ensemble.stopped])[::2]
        repeats = repeats_of(self._model, last.transpose(1, 0, 2))
        grown = average(np.nan_to_num(self._logarithms[len(self._logarithms) // 4 :]))
        averages = self._sums / self._weight_sums[:, None, None]
        for index, row in enumerate(rows):
            exponent, error = grown.values[index], grown.errors[index]
            result.states[row] = last[-1, index]
            result.exponents[row] = exponent
            slack = EXPONENTS.sure * error + 1e-7  # rounding
            if stopped[index] or self._sticks[index]:
                result.kinds[row] = STOPPED if stopped[index] else STICKS
                result.exponents[row] = np.nan
            elif repeats[index]:
                self._set_periodic(result, row, last[-repeats[index] :, index])
            # A trajectory that grows evenly, or nearly repeats at first, is leaving a response.
            elif exponent > slack + CLASSIFICATION.zero and error > 2e-5:
                if not self._nearly_repeats(self._first[:, index]):
                    result.kinds[row] = CHAOS
            elif error > CLASSIFICATION.zero:
                continue
            elif abs(exponent) <= min(slack, CLASSIFICATION.zero):
                result.kinds[row] = TORUS
            elif exponent < -slack and exponent * self._done < np.log(CLASSIFICATION.shrunk):
                # Averages over a long period are equal as well, but then no distance shrinks.
                fraction = min(CLASSIFICATION.shrunk, np.exp(exponent * self._done / 2))
                states = self._first[:, index], last[:, index]
                period = self._converges_to(averages[:, index], *states, fraction)
                if period:
                    self._set_periodic(result, row, averages[:period, index])

    def _set_periodic(self, result: Classified, row: int, states: Array) -> None:
        result.kinds[row], result.periods[row] = PERIODIC, len(states)
        result.means[row] = mean_state(states, self._angle_periods)

    def _nearly_repeats(self, states: Array) -> bool:
        """Whether a trajectory nearly repeats, and may be about to leave a response."""
        periods = range(1, CLASSIFICATION.recent // 3 + 1)
        changes = (distances(self._model, states[each:], states[:-each]) for each in periods)
        return min(change.max() for change in changes) < 1e-2

    def _converges_to(self, averages: Array, first: Array, last: Array, fraction: float) -> int:
        """Return the period of the averages if the trajectory approaches them, else 0."""
        numbers = np.arange(CLASSIFICATION.recent)
        late = (self._done - CLASSIFICATION.recent + numbers) % CLASSIFICATION.classes
        before, after = (
            distances(self._model, states, averages[which]).max()
            for states, which in ((first, numbers % CLASSIFICATION.classes), (last, late))
        )
        if not after < max(fraction * before, CLASSIFICATION.near):
            return 0
        for period in (1, 2, 3, 4, 6, 8, 12, 24):
            same = averages[numbers[: CLASSIFICATION.classes] % period]
            apart = distances(self._model, averages, same).max()
            if apart <= max(CLASSIFICATION.near, 0.1 * after):
                return period
        return 0


NOT_DONE = "not done"

OPEN = "open"
"""Kind of a trajectory that must be followed for longer."""


class TrajectoryGrid:
    """Trajectories at many parameter values, in one run or several, with results so far."""

    def __init__(
        self,
        model: Model,
        values: Mapping[str, Array],
        runs: int,
        start: Array,
        transient: int,
        observer: Observer | None,
    ) -> None:
        count = len(next(iter(values.values())))
        self.models = models_with(model, count, values)
        self.model = model.with_scales(self.models[0].estimated_scales)
        self.scales = self.models[0].state_scales()
        # A perturbation, since symmetry could keep a trajectory on an unstable response.
        self.start = start + EQUILIBRIUM.perturbation * self.scales
        self.transient, self.observer = transient, observer
        self.known = Classified.unknown(NOT_DONE, np.full((runs, count, len(start)), np.nan))
        self.done, self.total = 0, runs * count * self.periods_of_a_motion

    @property
    def periods_of_a_motion(self) -> int:
        """Forcing periods after which each trajectory is judged."""
        return self.transient + CLASSIFICATION.recent

    def from_rest(self, run: int) -> None:
        """Follow a trajectory from the start in each cell."""
        cells = np.arange(len(self.models))
        for first in range(0, len(cells), CLASSIFICATION.batch):
            rows = cells[first : first + CLASSIFICATION.batch]
            self.follow(run, rows, np.tile(self.start, (len(rows), 1)))

    def follow(self, run: int, cells: Indices, starts: Array) -> Array:
        """Follow trajectories in some cells; return last states, or the start if they ended."""
        result = self._followed(cells, starts)
        self.known.put((run, cells), result)
        self.known.put((run, cells), self._followed_again(cells, result))
        return np.where(
            np.isnan(result.states).any(axis=1, keepdims=True), self.start, result.states
        )

    def judged(self, cells: Indices, starts: Array) -> Classified:
        """Follow and classify trajectories in some cells without storing them."""
        return self._followed_again(cells, self._followed(cells, starts))

    def _followed_again(self, cells: Indices, result: Classified) -> Classified:
        """Follow trajectories that still converge once more: near a saddle they leave again."""
        nearer = np.flatnonzero((result.periods > 0) & (result.changes > CLASSIFICATION.floor))
        if len(nearer):
            self.total += len(nearer) * self.periods_of_a_motion
            result.put(nearer, self._followed(cells[nearer], result.states[nearer]))
        return result

    def _followed(self, cells: Indices, starts: Array) -> Classified:
        """Follow trajectories once."""
        models = [self.models[cell] for cell in cells]
        total = self.periods_of_a_motion
        window = np.full((CLASSIFICATION.recent + 1, *starts.shape), np.nan)
        stuck = np.zeros(len(cells), np.int64)
        sticks = np.zeros(len(cells), bool)
        with Ensemble(models, starts) as ensemble:
            for period in range(1, total + 1):
                ensemble.advance()
                stuck += ensemble.stuck
                ensemble.leave(stuck >= CLASSIFICATION.stuck)
                if period > self.transient:
                    sticks |= ensemble.stuck
                if period >= self.transient:
                    window[period - self.transient] = ensemble.states
                self._report(len(cells))
            states = ensemble.states
            stopped = np.array([stop is not None for stop in ensemble.stopped])
        window[:, stuck >= CLASSIFICATION.stuck] = np.nan  # they were left where they were
        return self._judge(window, np.where(stopped[:, None], np.nan, states), sticks)

    def _judge(self, window: Array, states: Array, sticks: Mask) -> Classified:
        """Classify trajectories, as far as they repeat, stick or stopped."""
        model = self.models[0]
        periods = repeats_of(model, window.transpose(1, 0, 2))
        before = window[-1 - periods, np.arange(len(states))]
        result = Classified.unknown(OPEN, states)
        result.kinds[periods > 0] = PERIODIC
        result.kinds[sticks] = STICKS
        result.kinds[np.isnan(states).any(axis=1)] = STOPPED
        result.periods[:] = periods
        result.changes[:] = distances(model, window[-1], before)
        for row in np.flatnonzero(periods):
            result.means[row] = mean_state(window[-periods[row] :, row], model.angle_periods)
        return result

    def classify_open(self) -> None:
        """Follow trajectories of all runs for longer that neither repeat nor stick."""
        runs, cells = np.nonzero(self.known.kinds == OPEN)
        self.total += 2 * len(cells) * CLASSIFICATION.pair_periods[0]
        for first in range(0, len(cells), CLASSIFICATION.batch):
            some = slice(first, first + CLASSIFICATION.batch)
            run, cell = runs[some], cells[some]
            result, interrupted = self.classified_open(cell, self.known.states[run, cell])
            known = (result.kinds != UNDECIDED) | (not interrupted)
            self.known.put((run[known], cell[known]), result.rows(known))
            if interrupted:
                raise KeyboardInterrupt

    def classified_open(self, cells: Indices, states: Array) -> tuple[Classified, bool]:
        """Follow trajectories for longer; return classes, and whether that was interrupted."""
        return classify_open([self.models[cell] for cell in cells], states, self._report_pairs)

    def _report(self, periods: int) -> None:
        self.done += periods
        if self.observer is not None:
            self.observer(Progress("forcing periods", self.done, max(self.total, self.done)))

    def _report_pairs(self, periods: int, more: int) -> None:
        self.total += more
        self._report(periods)

    @property
    def reported_kinds(self) -> NDArray[np.str_]:
        """Kinds of the trajectories so far."""
        return np.where(self.known.kinds == OPEN, NOT_DONE, self.known.kinds).astype(str)
