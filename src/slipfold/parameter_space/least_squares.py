"""Parameters of a model by least squares, with intervals from profiles."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.errors import BREAKDOWNS, InputError
from slipfold.models.model import Model
from slipfold.parameter_space.explanation import Explanation, Readings
from slipfold.parameter_space.measurement import Measurement
from slipfold.progress import Observer, Progress

Report = Callable[[Explanation], None]

ROUNDS = 12
"""Maximum number of times that orbits are assigned to readings again."""

DECREASE = 1e-6
"""Smallest relative decrease of the sum of squares: far below the accuracy of intervals."""

CRAWL = 1e-3
"""Relative decrease of the sum of squares below which no more steps are tried where orbits vanish:
trust regions shrink fourfold each time that an orbit is lost."""


class _Finished(Exception):
    """The search ends: steps that lose orbits no longer decrease the sum of squares."""


def best_of_rounds(
    start: Explanation,
    free: tuple[str, ...],
    report: Report = lambda found: None,
    scale: float = np.inf,
    close: float = DECREASE,
) -> tuple[Explanation, float, bool]:
    """Return the best explanation near a start, the typical distance, and whether it converged.

    Each iteration minimizes the sum of squares for fixed orbits, then assigns orbits to the
    readings again, with these orbits among the candidates. So the sum never grows, and iterations
    cannot cycle. The typical distance is at most the given `scale`; `close` is that of `closest`.
    """
    best, scale = start, min(start.scale, scale)
    for _ in range(ROUNDS):
        report(best)
        held = closest(best, free, scale, close)
        found = held.readings.explained(held.model, held)
        narrower = min(scale, found.scale)
        better = found.cost(narrower) < (1 - DECREASE) * best.cost(narrower)
        done = not better and narrower >= (1 - DECREASE) * scale
        best, scale = found if better else best, narrower
        if done:
            return best, scale, True
    return best, scale, False


def closest(
    start: Explanation, free: tuple[str, ...], scale: float, close: float = DECREASE
) -> Explanation:
    """Return the least squares for fixed orbits, of the rows that are used.

    The search ends where the relative change of the parameters or of the sum of squares is below
    `close`.
    """
    from scipy.optimize import least_squares  # its import takes half a second

    rows = start.used(scale)
    if not free or not rows.any():
        return start
    low, high = np.array([start.readings.bounds[name] for name in free]).T
    here = np.array([start.model.values[name] for name in free])
    cache: dict[bytes, Explanation | None] = {here.tobytes(): start}
    best, lost = start, 0

    def at(values: Array) -> Explanation | None:
        key = values.tobytes()
        if key not in cache:
            cache[key] = best.moved(dict(zip(free, values.tolist(), strict=True)), rows)
        return cache[key]

    def away(values: Array) -> Array:
        nonlocal lost
        found = at(values)
        if found is None:  # SciPy takes a shorter step then
            lost += 1
            return np.full(size, np.inf)
        return found.residuals(rows)

    def slopes(values: Array) -> Array:
        nonlocal best, lost
        found = at(values)
        if found is None:  # rounding moved it to its bound, where the orbit is lost
            raise _Finished
        before, now = (float(np.sum(item.residuals(rows) ** 2)) for item in (best, found))
        if found is not start and lost and before - now < CRAWL * now:
            raise _Finished
        best, lost = found, 0
        return np.nan_to_num(found.slopes(free, rows))

    size = len(start.residuals(rows))
    try:
        solved: Any = least_squares(
            away, here, slopes, bounds=(low, high), x_scale=high - low, method="dogbox",
            xtol=close, ftol=close, gtol=1e-14, max_nfev=60,
        )  # fmt: skip
    except _Finished:
        return best
    return at(solved.x) or best


PROFILE_CLOSE = 1e-2
"""Relative error of an end where orbits vanish, over its distance from the fitted value."""

REACHED = 0.96
"""Growth of the sum of squares, over that at the ends, at which a parabola gives the end with about
the square of the remaining error."""

BETTER = 1e-2
"""Decrease of the sum of squares, over the growth at the ends, that makes a fit better."""

POINTS = 60
"""Maximum number of points of a profile on one side."""

CHECKS = 3
"""Maximum number of times that orbits are assigned again at its end."""


class BetterFit(Exception):
    """A profile has a smaller sum of squares than the fit."""

    def __init__(self, found: Explanation) -> None:
        super().__init__()
        self.found = found


@dataclass(frozen=True, eq=False)
class Profile:
    """The sum of squares about a fit; an interval ends where it has grown by `rise`."""

    best: Explanation
    scale: float
    rise: float
    known: Sequence[Explanation]  # computed before: some may lie in other minima
    report: Callable[[Explanation], None]

    def end(self, place: int, way: int, slopes: Array, step: float) -> float:
        """Return the end of the interval of a parameter, downward (-1) or upward (1).

        It is the bound of the parameter if the sum of squares grows by less. Raises `BetterFit`.
        `slopes` are the initial derivatives of the others, `step` is the first step.

        Shapes: slopes (p,).
        """
        inside = [item for item in self.known if self._growth(item) <= self.rise]
        here = max([self.best, *inside], key=lambda item: way * item.values[place])
        for _ in range(CHECKS):
            here = self._followed(here, place, way, slopes, step)
            if here.values[place] == self._bound(place, way):
                break
            again = here.readings.explained(here.model, here)
            if self._growth(again) > 0.9 * self._growth(here):
                break
            here = again  # other orbits are nearer to the readings there
        value, growth, bound = here.values[place], self._growth(here), self._bound(place, way)
        if growth > REACHED * self.rise:
            value += (value - self.best.values[place]) * (np.sqrt(self.rise / growth) - 1)
        return float(min(value, bound) if way > 0 else max(value, bound))

    def _followed(
        self, here: Explanation, place: int, way: int, slopes: Array, step: float
    ) -> Explanation:
        """Return the last point of a profile at which the sum of squares has not grown too much.

        Where orbits vanish, as at a fold, steps are halved. Just beyond, orbits are assigned to the
        readings again; the profile continues if others are near enough.
        """
        bound, middle, least = (
            self._bound(place, way),
            self.best.values[place],
            PROFILE_CLOSE * step,
        )
        over: tuple[float, float] | None = None
        for _ in range(POINTS):
            value = float(here.values[place])
            limit = bound if over is None else over[0]
            room = abs(limit - value)
            if room == 0 or self._growth(here) > REACHED * self.rise:
                break
            if over is not None and room <= max(PROFILE_CLOSE * abs(limit - middle), least):
                break
            length = min(step, room if over is None else self._between(here, over[1], room))
            target = limit if length == room else value + way * length
            there = self._held(here, place, target, slopes)
            if there is None and length > max(PROFILE_CLOSE * abs(target - middle), least):
                step = length / 2
                continue
            if there is None:
                there = self._assigned_again(here, place, target)
            self.report(there)
            growth = self._growth(there)
            if growth > self.rise:
                over = target, growth
            else:
                slopes = (there.values - here.values) / (target - value)
                here, step = there, 2 * length
        return here

    def _bound(self, place: int, way: int) -> float:
        return list(self.best.readings.bounds.values())[place][max(way, 0)]

    def _growth(self, found: Explanation) -> float:
        """Return by how much the sum of squares is above that of the fit."""
        growth = found.cost(self.scale) - self.best.cost(self.scale)
        if growth < -BETTER * self.rise:
            raise BetterFit(found)
        return growth

    def _between(self, here: Explanation, growth: float, room: float) -> float:
        """Return the step to where a parabola through two points has grown by `rise`."""
        inner, middle, outer = np.sqrt(
            np.clip([self._growth(here), (1 + REACHED) / 2 * self.rise, growth], 0, 9 * self.rise)
        )
        return float(np.clip((middle - inner) / (outer - inner), 0.05, 0.95) * room)

    def _held(
        self, here: Explanation, place: int, target: float, slopes: Array
    ) -> Explanation | None:
        """Return the best explanation by the same orbits with a parameter held; None if lost."""
        names, rows = tuple(here.readings.bounds), here.used(self.scale)
        low, high = np.array(list(here.readings.bounds.values())).T
        for rates in (slopes, np.zeros_like(slopes)):
            values = np.clip(here.values + rates * (target - here.values[place]), low, high)
            values[place] = target
            there = here.moved(dict(zip(names, values.tolist(), strict=True)), rows)
            if there is not None:
                return closest(there, names[:place] + names[place + 1 :], self.scale)
        return None

    def _assigned_again(self, here: Explanation, place: int, target: float) -> Explanation:
        """Return the best explanation with a parameter held, after orbits are assigned again."""
        names = tuple(here.readings.bounds)
        start = here.readings.explained(here.model.replace(**{names[place]: target}))
        return best_of_rounds(start, names[:place] + names[place + 1 :])[0]


Truth = NDArray[np.bool_]

CONFIDENCE = 0.95

STARTS = 3
"""Logarithm to base 2 of the number of further initial values within the bounds: where the response
jumps, the sum of squares has several minima."""

DESCENTS = 3
"""Fits from the best of these if they explain the readings; else until as many agree."""

CLOSE = 1e-11
"""Change of the parameters, over their bounds, at which a fit ends."""

SAME = 1e-3
"""Relative difference of sums of squares in the same minimum."""

UNLIKELY = 1e-3
"""Probability of so large a sum of squares below which readings are not explained."""

EXACT = 1e-9
"""Minimum of the typical residual, in ranges of the readings: the accuracy of orbits."""

WIDER = 1.5
"""Ratio of an interval to that of the linearized model above which its error is not reliable."""

LISTED = 5
"""Maximum number of excluded rows that are named."""

REPEATS = 20
"""Maximum number of times that a fit begins again from a better one."""

BLIND = 1e-10
"""Singular value of the scaled derivatives, over the largest or the readings' error, below which
the readings do not determine a combination of parameters."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """A fitted parameter.

    Parameters
    ----------
    name, unit
        Its name and unit.
    value
        Its fitted value.
    error
        Its standard error, of the model linearized about the result; infinite if the readings do
        not determine it.
    low, high
        Ends of the interval of 95 % confidence, from the profile of the sum of squares; a bound
        where it is open there.
    least, most
        Bounds that were given.
    correlation
        With each of the fitted parameters, shape (p,).
    """

    name: str
    unit: str
    value: float
    error: float
    low: float
    high: float
    least: float
    most: float
    correlation: Array


@dataclass(frozen=True, eq=False)
class Fitted:
    """The parameters with the smallest sum of squares."""

    best: Explanation
    scale: float  # typical distance of a row
    estimates: tuple[Estimate, ...]
    scatter: float  # root mean square of the weighted residuals, by degrees of freedom
    converged: bool
    message: str


def find_fit(
    model: Model,
    measurement: Measurement,
    bounds: Mapping[str, tuple[float, float]],
    observer: Observer | None = None,
) -> Fitted:
    """Find the parameters within bounds with which stable responses are nearest to readings."""
    _check(measurement, tuple(bounds))
    readings = Readings.weighted(measurement, bounds)
    known: list[Explanation] = []

    def report(found: Explanation) -> None:
        known.append(found)
        if observer is not None:
            values = {name: found.model.values[name] for name in bounds}
            away = found.residuals(found.used(found.scale))
            distance = float(np.sqrt(np.mean(away**2)))
            named = "  ".join(f"{name} = {value:.6g}" for name, value in values.items())
            text = f"{named}  distance {distance:.3g}"
            observer(Progress("rounds", len(known), None, text, {**values, "distance": distance}))

    near, scale = _least(readings, model, report)
    for _ in range(REPEATS):
        best, scale, converged = best_of_rounds(near, tuple(bounds), report, scale, CLOSE)
        fit = _Fit(best, scale)
        try:
            ends = fit.intervals(known, report)
            break
        except BetterFit as better:
            near = better.found
    else:
        ends, converged = np.array(list(bounds.values())), False
    return Fitted(
        best, scale, fit.estimates(ends), fit.scatter, converged, fit.message(ends, converged)
    )


def _check(measurement: Measurement, names: tuple[str, ...]) -> None:
    if not names:
        raise InputError("no parameter is fitted; give at least one with its bounds")
    if measurement.vary in names:
        raise InputError(
            f"{measurement.vary} was varied in the measurement, so it cannot be fitted; fit others"
        )


def _least(
    readings: Readings, model: Model, report: Callable[[Explanation], None]
) -> tuple[Explanation, float]:
    """Return the best of several fits: from the given values, and from others in the bounds."""
    from scipy.stats import qmc

    names = tuple(readings.bounds)
    low, high = np.array(list(readings.bounds.values())).T
    starts = [readings.explained(model)]
    for share in qmc.Sobol(len(names), seed=0).random_base2(STARTS):
        values = dict(zip(names, (low + share * (high - low)).tolist(), strict=True))
        try:
            starts.append(readings.explained(model.replace(**values)))
        except (InputError, *BREAKDOWNS):  # the model has no response there
            continue
    starts[1:] = sorted(starts[1:], key=lambda item: item.cost(item.scale))
    best, scale, again = starts[0], starts[0].scale, 0
    for number, start in enumerate(starts, 1):
        found, size, _ = best_of_rounds(start, names, report)
        gain = best.cost(scale) - found.cost(size)
        again = 1 if gain > SAME * best.cost(scale) else again + (gain > -SAME * best.cost(scale))
        if gain > 0:
            best, scale = found, size
        if again >= DESCENTS or (number >= DESCENTS and _likelihood(best, scale) > UNLIKELY):
            break
    return best, scale


def _likelihood(best: Explanation, scale: float) -> float:
    """Return the probability of a larger sum of squares; 0 if rows are excluded.

    If errors are not known, any sum is equally likely.
    """
    from scipy.special import chdtrc

    readings, rows = best.readings, best.used(scale)
    freedom = int(readings.counts[rows].sum()) - len(readings.bounds)
    if freedom < 1 or not rows[readings.counts > 0].all():
        return 0.0
    return float(chdtrc(freedom, best.cost(scale))) if readings.known else 1.0


class _Fit:
    """Covariance, intervals and message of the best explanation of readings."""

    def __init__(self, best: Explanation, scale: float) -> None:
        self.best, self.scale = best, scale
        self.readings, self.rows = best.readings, best.used(scale)
        self.names = tuple(self.readings.bounds)
        count = int(self.readings.counts[self.rows].sum())
        self.freedom = count - len(self.names)
        if self.freedom < 1:
            raise InputError(
                f"stable responses explain {count} of {self.readings.counts.sum()} readings, too "
                f"few for {len(self.names)} parameters; begin nearer to what was measured, or fit "
                "fewer parameters"
            )
        self.scatter = float(np.linalg.norm(best.residuals(self.rows)) / np.sqrt(self.freedom))

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the parameters as the linearized model has it, shape (p, p)."""
        slopes = self.best.slopes(self.names, self.rows)
        sizes = np.array([np.ptp(ends) for ends in self.readings.bounds.values()])
        known = covariance_of(slopes[np.isfinite(slopes).all(axis=1)], sizes)
        return known if self.readings.known else known * self.scatter**2

    @property
    def reach(self) -> float:
        """Half of an interval over the standard error, where a profile is a parabola."""
        from scipy.special import ndtri, stdtrit

        share = 0.5 + CONFIDENCE / 2
        return float(ndtri(share) if self.readings.known else stdtrit(self.freedom, share))

    def intervals(self, known: list[Explanation], report: Callable[[Explanation], None]) -> Array:
        """Return the ends of the intervals of confidence, shape (p, 2). Raises `BetterFit`."""
        typical = 1.0 if self.readings.known else max(self.scatter, EXACT)
        rise = (self.reach * typical) ** 2
        profile = Profile(self.best, self.scale, rise, tuple(known), report)
        ends = np.empty((len(self.names), 2))
        for place, (low, high) in enumerate(self.readings.bounds.values()):
            variance = self.covariance[place, place]
            with np.errstate(invalid="ignore"):  # infinite where readings say nothing
                slopes = np.nan_to_num(self.covariance[place] / variance)
            step = min(self.reach * float(np.sqrt(variance)), high - low) or high - low
            ends[place] = [profile.end(place, way, slopes, step) for way in (-1, 1)]
        return ends

    def estimates(self, ends: Array) -> tuple[Estimate, ...]:
        """Return the estimate of each parameter. Shapes: ends (p, 2)."""
        errors = np.sqrt(np.diag(self.covariance))
        with np.errstate(invalid="ignore"):
            correlations = self.covariance / np.outer(errors, errors)
        np.fill_diagonal(correlations, 1.0)
        found = []
        for row, (name, (least, most)) in enumerate(self.readings.bounds.items()):
            unit, value = self.best.model.parameter(name).unit, self.best.model.values[name]
            interval = float(ends[row, 0]), float(ends[row, 1])
            error = float(errors[row])
            found.append(
                Estimate(name, unit, value, error, *interval, least, most, correlations[row])
            )
        return tuple(found)

    def message(self, ends: Array, converged: bool) -> str:
        """Return warnings about a fit, empty if there are none."""
        said = (
            []
            if converged
            else ["the fit has not converged; begin nearer, or fit fewer parameters"]
        )
        if self.readings.known and _likelihood(self.best, self.scale) < UNLIKELY:
            said.append("the readings lie farther from the model than their errors explain")
        for item in self.estimates(ends):
            if not np.isfinite(item.error):
                said.append(
                    f"the readings say nothing about {item.name}" if len(self.names) == 1 else
                    f"the readings cannot distinguish {item.name} from the others"
                )  # fmt: skip
            elif item.high - item.low > WIDER * 2 * self.reach * item.error and (
                self.readings.known or self.scatter > EXACT
            ):
                said.append(
                    f"the sum of squares is not a parabola over {item.name}, so that its error "
                    "says little: use its interval"
                )
            bounds = {"lower": (item.low, item.least), "upper": (item.high, item.most)}
            met = [side for side, (end, bound) in bounds.items() if end == bound]
            if met:
                said.append(f"the interval of {item.name} is open at its {' and '.join(met)} bound")
        return "; ".join([*said, *self._left_out()])

    def _left_out(self) -> list[str]:
        """Say which rows are excluded, and why."""
        measured = self.readings.measurement
        unit = f" {measured.unit}".rstrip()
        reasons = self.best.reasons(self.scale)
        rows = [
            f"row {row + 1} ({measured.vary} = {measured.values[row]:.6g}{unit}: {reason})"
            for row, reason in enumerate(reasons)
            if reason
        ]
        more = f" and {len(rows) - LISTED} more" if len(rows) > LISTED else ""
        out = f"{len(rows)} of {len(reasons)} rows are left out: {', '.join(rows[:LISTED])}{more}"
        return [out] if rows else []


def covariance_of(slopes: Array, sizes: Array) -> Array:
    """Return the covariance of parameters from the derivatives of readings of unit error.

    Infinite where readings do not determine one. Shapes: slopes (k, p), sizes (p,); returns (p, p).
    """
    _, singular, rows = np.linalg.svd(slopes * sizes, full_matrices=True)
    sharp = np.zeros(len(sizes))
    sharp[: len(singular)] = singular
    known = sharp > BLIND * max(sharp.max(), 1.0)
    covariance = (rows[known].T / sharp[known] ** 2) @ rows[known] * np.outer(sizes, sizes)
    blind = (np.abs(rows[~known]) > np.sqrt(BLIND)).any(axis=0)
    covariance[blind] = covariance[:, blind] = np.nan
    covariance[blind, blind] = np.inf
    return np.asarray(covariance)
