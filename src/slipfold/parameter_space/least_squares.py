"""Parameters of a model fitted to a measurement by least squares, with intervals from profiles."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

import numpy as np

from slipfold.arrays import Array
from slipfold.errors import BREAKDOWNS, InputError
from slipfold.models.model import Model
from slipfold.parameter_space.explanation import LIMITS, Explanation, Weighted
from slipfold.parameter_space.measurement import Measurement
from slipfold.parameter_space.stable_orbits import covariance_of
from slipfold.progress import Observer, Progress
from slipfold.read_only import Documented

Report = Callable[[Explanation], None]


class _Finished(Exception):
    """The search ends: steps that lose orbits no longer decrease the sum of squares."""


def best_of_rounds(
    start: Explanation,
    free: tuple[str, ...],
    report: Report = lambda found: None,
    scale: float = np.inf,
    close: float = LIMITS.decrease,
) -> tuple[Explanation, float, bool]:
    """Return the best explanation near a start, the typical distance, and whether it converged.

    Each iteration minimizes the sum of squares for fixed orbits, then assigns orbits to the
    rows again, with these orbits among the candidates. So the sum never grows, and iterations
    cannot cycle. The typical distance is at most the given `scale`; `close` is that of `closest`.
    """
    best, scale, enough = start, min(start.scale, scale), 1 - LIMITS.decrease
    for _ in range(LIMITS.rounds):
        report(best)
        held = closest(best, free, scale, close)
        again = held.measured.explained(held.model, held)
        narrower = min(scale, again.scale)
        better = again.cost(narrower) < enough * best.cost(narrower)
        done = not better and narrower >= enough * scale
        best, scale = again if better else best, narrower
        if done:
            return best, scale, True
    return best, scale, False


def closest(
    start: Explanation, free: tuple[str, ...], scale: float, close: float = LIMITS.decrease
) -> Explanation:
    """Return the least squares for fixed orbits, of the rows that are used.

    The search ends when the relative change of the parameters or of the sum of squares is below
    `close`.
    """
    from scipy.optimize import least_squares  # its import takes half a second

    rows = start.used(scale)
    if not free or not rows.any():
        return start
    low, high = np.array([start.measured.bounds[name] for name in free]).T
    here = np.array([start.model.values[name] for name in free])
    known: dict[bytes, Explanation | None] = {here.tobytes(): start}
    best, lost, missing = start, False, np.full(len(start.residuals(rows)), np.inf)

    def at(values: Array) -> Explanation | None:
        key = values.tobytes()
        if key not in known:
            known[key] = best.moved(free, values, rows)
        return known[key]

    def away(values: Array) -> Array:
        nonlocal lost
        there = at(values)
        lost = lost or there is None
        return missing if there is None else there.residuals(rows)  # SciPy then steps shorter

    def slopes(values: Array) -> Array:
        nonlocal best, lost
        there = at(values)
        if there is None:  # rounding moved it to a bound at which there is no orbit
            raise _Finished
        before, now = (float(np.sum(item.residuals(rows) ** 2)) for item in (best, there))
        if there is not start and lost and before - now < LIMITS.same * now:
            raise _Finished
        best, lost = there, False
        return np.nan_to_num(there.slopes(free, rows))

    try:
        solved: Any = least_squares(
            away, here, slopes, bounds=(low, high), x_scale=high - low, method="dogbox",
            xtol=close, ftol=close, gtol=1e-14, max_nfev=LIMITS.iterations,
        )  # fmt: skip
    except _Finished:
        return best
    return at(solved.x) or best


# -- intervals from profiles -----------------------------------------------------------------------


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
    report: Report

    def end(self, place: int, way: int, slopes: Array, step: float) -> float:
        """Return the end of the interval of a parameter, downward (-1) or upward (1).

        It is the bound of the parameter if the sum of squares grows by less than `rise` there.
        `slopes` are the initial derivatives of the other parameters, `step` is the first step.
        Raises `BetterFit`.

        Shapes: slopes (p,).
        """
        bound = float(self.best.measured.ends[max(way, 0), place])
        inside = [item for item in self.known if self._growth(item) <= self.rise]
        here = max([self.best, *inside], key=lambda item: way * item.values[place])
        for _ in range(LIMITS.agreeing):
            here = self._followed(here, place, bound, slopes, step)
            if here.values[place] == bound:
                break
            again = here.measured.explained(here.model, here)
            if self._growth(again) > 0.9 * self._growth(here):
                break
            here = again  # other orbits are nearer to the rows there
        value, growth = here.values[place], self._growth(here)
        if growth > LIMITS.reached * self.rise:
            value += (value - self.best.values[place]) * (np.sqrt(self.rise / growth) - 1)
        return float(min(value, bound) if way > 0 else max(value, bound))

    def _followed(
        self, here: Explanation, place: int, bound: float, slopes: Array, step: float
    ) -> Explanation:
        """Return the last point of a profile at which the sum of squares has not grown too much.

        Where orbits vanish, as at a fold, steps are halved. At the last step orbits are assigned to
        the rows again; the profile continues if other orbits are near enough.
        """
        middle, least = self.best.values[place], LIMITS.profile * step
        over: tuple[float, float] | None = None  # a value, and the growth there, beyond the end
        for _ in range(LIMITS.iterations):
            value = float(here.values[place])
            limit = bound if over is None else over[0]
            room = abs(limit - value)
            if room == 0 or self._growth(here) > LIMITS.reached * self.rise:
                break
            if over is not None and room <= max(LIMITS.profile * abs(limit - middle), least):
                break
            length = min(step, room if over is None else self._between(here, over[1], room))
            target = limit if length == room else value + np.sign(bound - middle) * length
            there = self._held(here, place, target, slopes)
            if there is None and length > max(LIMITS.profile * abs(target - middle), least):
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

    def _growth(self, found: Explanation) -> float:
        """Return by how much the sum of squares is above that of the fit."""
        growth = found.cost(self.scale) - self.best.cost(self.scale)
        if growth < -LIMITS.profile * self.rise:
            raise BetterFit(found)
        return growth

    def _between(self, here: Explanation, growth: float, room: float) -> float:
        """Return the step to where a parabola through two points has grown by `rise`."""
        middle = (1 + LIMITS.reached) / 2 * self.rise
        grown = np.clip([self._growth(here), middle, growth], 0, 9 * self.rise)
        inner, middle, outer = np.sqrt(grown)
        return float(np.clip((middle - inner) / (outer - inner), 0.05, 0.95) * room)

    def _held(
        self, here: Explanation, place: int, target: float, slopes: Array
    ) -> Explanation | None:
        """Return the best explanation by the same orbits with a parameter held; None if lost."""
        names, rows = here.measured.names, here.used(self.scale)
        for rates in (slopes, np.zeros_like(slopes)):
            values = np.clip(
                here.values + rates * (target - here.values[place]), *here.measured.ends
            )
            values[place] = target
            there = here.moved(names, values, rows)
            if there is not None:
                return closest(there, names[:place] + names[place + 1 :], self.scale)
        return None

    def _assigned_again(self, here: Explanation, place: int, target: float) -> Explanation:
        """Return the best explanation with a parameter held, after orbits are assigned again."""
        names = here.measured.names
        start = here.measured.explained(here.model.replace(**{names[place]: target}))
        return best_of_rounds(start, names[:place] + names[place + 1 :])[0]


# -- the fit ---------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Estimate(Documented):
    """A fitted parameter."""

    name: Annotated[str, "Its name and unit."]
    unit: Annotated[str, ""]
    value: Annotated[float, "Its fitted value."]
    error: Annotated[
        float,
        "Its standard error, of the model linearized about the result; infinite if the "
        "measurements do not determine it.",
    ]
    low: Annotated[
        float,
        "Ends of the interval of 95 % confidence, from the profile of the sum of squares; a "
        "bound where it is open there.",
    ]
    high: Annotated[float, ""]
    lower_bound: Annotated[float, "Bounds that were given."]
    upper_bound: Annotated[float, ""]
    correlation: Annotated[Array, "With each of the fitted parameters, shape (p,)."]


@dataclass(frozen=True, eq=False)
class Fitted:
    """The parameters with the smallest sum of squares."""

    best: Explanation
    scale: float  # typical distance of a row
    estimates: tuple[Estimate, ...]
    residual_std: float  # root mean square of the weighted residuals, by degrees of freedom
    converged: bool
    interrupted: bool  # so that these are the best values so far, without intervals
    message: str


def find_fit(
    model: Model,
    measurement: Measurement,
    bounds: Mapping[str, tuple[float, float]],
    observer: Observer | None = None,
) -> Fitted:
    """Find parameters within bounds with which stable responses are nearest to a measurement.

    An interruption keeps the best values so far.
    """
    if not bounds:
        raise InputError("no parameter is fitted; give at least one with its bounds")
    if measurement.vary in bounds:
        raise InputError(
            f"{measurement.vary} was varied in the measurement, so it cannot be fitted; fit others"
        )
    measured = Weighted.from_measurement(measurement, bounds)
    known: list[Explanation] = []

    def report(found: Explanation) -> None:
        known.append(found)
        if observer is not None:
            values = {name: found.model.values[name] for name in bounds}
            away = found.residuals(found.used(found.scale))
            distance = float(np.sqrt(np.mean(away**2))) if len(away) else np.inf
            named = "  ".join(f"{name} = {value:.6g}" for name, value in values.items())
            text = f"{named}  distance {distance:.3g}"
            observer(Progress("rounds", len(known), None, text, {**values, "distance": distance}))

    interrupted = converged = False
    try:
        near, scale = _best_start(measured, model, report)
        for _ in range(LIMITS.rounds):
            near, scale, converged = best_of_rounds(
                near, measured.names, report, scale, LIMITS.close
            )
            fit = _Fit(near, scale)
            try:
                ends = fit.intervals(known, report)
                break
            except BetterFit as better:
                near = better.found
        else:
            ends, converged = measured.ends.T, False
    except KeyboardInterrupt:
        if not known:
            raise
        interrupted, converged, scale = True, False, min(item.scale for item in known)
        fit = _Fit(min(known, key=lambda item: item.cost(scale)), scale)
        ends = np.full_like(measured.ends.T, np.nan)
    estimates = fit.estimates(ends)
    message = fit.message(estimates, converged, interrupted)
    std = fit.residual_std
    return Fitted(fit.best, scale, estimates, std, converged, interrupted, message)


def _best_start(measured: Weighted, model: Model, report: Report) -> tuple[Explanation, float]:
    """Return the best of several fits: from the given values, and from others in the bounds."""
    from scipy.stats import qmc

    low, high = measured.ends
    starts = [measured.explained(model)]
    for fraction in qmc.Sobol(len(low), seed=0).random(LIMITS.starts):
        values = (low + fraction * (high - low)).tolist()
        try:
            changed = model.replace(**dict(zip(measured.names, values, strict=True)))
            starts.append(measured.explained(changed))
        except BREAKDOWNS:  # the model has no response there
            continue
    starts[1:] = sorted(starts[1:], key=lambda item: item.cost(item.scale))
    best, scale, again = starts[0], starts[0].scale, 0
    for number, start in enumerate(starts, 1):
        found, size, _ = best_of_rounds(start, measured.names, report)
        gain = best.cost(scale) - found.cost(size)
        same = LIMITS.same * best.cost(scale)
        again = 1 if gain > same else again + (gain > -same)
        if gain > 0:
            best, scale = found, size
        explained = number >= LIMITS.agreeing and _likelihood(best, scale) > LIMITS.unlikely
        if again >= LIMITS.agreeing or explained:
            break
    return best, scale


def _likelihood(best: Explanation, scale: float) -> float:
    """Return the probability of a larger sum of squares; 0 if rows are excluded.

    If errors are not known, any sum is equally likely.
    """
    from scipy.special import chdtrc

    measured, rows = best.measured, best.used(scale)
    freedom = int(measured.counts[rows].sum()) - len(measured.bounds)
    if freedom < 1 or not rows[measured.counts > 0].all():
        return 0.0
    return float(chdtrc(freedom, best.cost(scale))) if measured.known else 1.0


class _Fit:
    """Covariance, intervals and message of the best explanation of a measurement."""

    def __init__(self, best: Explanation, scale: float) -> None:
        self.best, self.scale = best, scale
        self.measured, self.rows = best.measured, best.used(scale)
        self.names, counts = self.measured.names, self.measured.counts
        count = int(counts[self.rows].sum())
        self.freedom = count - len(self.names)
        if self.freedom < 1:
            raise InputError(
                f"stable responses explain {count} of {counts.sum()} measurements, too few for "
                f"{len(self.names)} parameters; begin nearer to what was measured, or fit fewer "
                "parameters"
            )
        self.residual_std = float(np.linalg.norm(best.residuals(self.rows)) / np.sqrt(self.freedom))

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the parameters as the linearized model has it, shape (p, p)."""
        low, high = self.measured.ends
        slopes = self.best.slopes(self.names, self.rows)
        return covariance_of(slopes, high - low) * self._typical**2

    @property
    def _typical(self) -> float:
        """Typical error of a weighted measurement; residuals that are smaller are rounding."""
        return 1.0 if self.measured.known else max(self.residual_std, LIMITS.exact)

    @property
    def reach(self) -> float:
        """Half of an interval over the standard error, where a profile is a parabola."""
        from scipy.special import ndtri, stdtrit

        fraction = 0.5 + LIMITS.confidence / 2
        return float(ndtri(fraction) if self.measured.known else stdtrit(self.freedom, fraction))

    @property
    def _explains_nothing(self) -> bool:
        """Whether the means of the quantities explain what was measured better than the model."""
        weights, measurements = self.measured.weights[self.rows], self.measured.measurement.measured
        spread = (measurements[self.rows] - np.nanmean(measurements[self.rows], axis=0)) * weights
        total = float(np.sum(spread[weights > 0] ** 2))
        return 0 < total < float(np.sum(self.best.residuals(self.rows) ** 2))

    def intervals(self, known: list[Explanation], report: Report) -> Array:
        """Return the ends of the intervals of confidence, shape (p, 2). Raises `BetterFit`."""
        rise = (self.reach * self._typical) ** 2
        profile = Profile(self.best, self.scale, rise, [*known], report)
        ends = np.empty((len(self.names), 2))
        for place, width in enumerate(np.diff(self.measured.ends, axis=0)[0]):
            variance = self.covariance[place, place]
            with np.errstate(invalid="ignore"):  # infinite where measurements say nothing
                slopes = np.nan_to_num(self.covariance[place] / variance)
            step = min(self.reach * float(np.sqrt(variance)), width) or width
            ends[place] = [profile.end(place, way, slopes, step) for way in (-1, 1)]
        return ends

    def estimates(self, ends: Array) -> tuple[Estimate, ...]:
        """Return the estimate of each parameter. Shapes: ends (p, 2)."""
        errors = np.sqrt(np.diag(self.covariance))
        with np.errstate(invalid="ignore"):
            correlations = self.covariance / np.outer(errors, errors)
        np.fill_diagonal(correlations, 1.0)
        model, result = self.best.model, []
        for row, (name, (lower_bound, upper_bound)) in enumerate(self.measured.bounds.items()):
            unit, value = model.parameter(name).unit, model.values[name]
            low, high = ends[row].tolist()
            error = float(errors[row])
            correlation = correlations[row]
            result.append(
                Estimate(name, unit, value, error, low, high, lower_bound, upper_bound, correlation)
            )
        return tuple(result)

    def message(self, estimates: Sequence[Estimate], converged: bool, interrupted: bool) -> str:
        """Return warnings about a fit, empty if there are none."""
        said = []
        if interrupted:
            said.append("interrupted: these are the best values so far, without intervals")
        elif not converged:
            said.append("the fit has not converged; begin nearer, or fit fewer parameters")
        if self.measured.known and _likelihood(self.best, self.scale) < LIMITS.unlikely:
            said.append("the measurements lie farther from the model than their errors explain")
        uncertain = self._typical > LIMITS.exact
        if not self.measured.known and uncertain and self._explains_nothing:
            said.append(
                "the measurements lie farther from the model than from their own means; check "
                "their units"
            )
        for item in estimates:
            width, linear = item.high - item.low, 2 * self.reach * item.error
            if not np.isfinite(item.error):
                said.append(
                    f"the measurements say nothing about {item.name}" if len(self.names) == 1 else
                    f"the measurements cannot distinguish {item.name} from the others"
                )  # fmt: skip
            elif uncertain and width > LIMITS.wider * linear:
                said.append(
                    f"the sum of squares is not a parabola over {item.name}, so that its error "
                    "says little: use its interval"
                )
            bounds = {"lower": (item.low, item.lower_bound), "upper": (item.high, item.upper_bound)}
            met = [side for side, (end, bound) in bounds.items() if end == bound]
            if met:
                said.append(f"the interval of {item.name} is open at its {' and '.join(met)} bound")
        rows, count = self.best.excluded(self.scale), len(self.rows)
        if rows:
            more = len(rows) - LIMITS.listed
            named = ", ".join(rows[: LIMITS.listed]) + (f" and {more} more" if more > 0 else "")
            said.append(f"{len(rows)} of {count} rows are left out: {named}")
        return "; ".join(said)
