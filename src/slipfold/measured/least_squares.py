"""Parameters from measured responses, by least squares over the stable orbits that explain them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.measured.measurement import Measurement
from slipfold.measured.prediction import Prediction, sensitivities
from slipfold.measured.stable_orbits import StableOrbit, stable_orbits
from slipfold.models.model import Model

__all__ = ["Estimate", "Explained", "FitProgress", "covariance_of", "find_fit"]

Array = NDArray[np.float64]
Truth = NDArray[np.bool_]

ROUNDS = 12
"""Times that readings may be given to responses anew."""

FAR = 6.0
"""Distance, in typical ones, beyond which a reading is left out: it lies across a jump that the
model makes elsewhere, or is no reading of this response."""

TYPICAL = 1.4826
"""Standard deviation over the median of absolute values, of the normal distribution."""

LEAST = 1e-6
"""Typical distance in any case, in ranges of the readings: simulated ones agree to rounding."""

SETTLED = 1e-8
"""Change of what is predicted, over its size, that is none."""

CONFIDENCE = 0.95

BLIND = 1e-10
"""Singular value of the scaled derivatives, over the largest or the readings' error, below which
readings say nothing."""


@dataclass(frozen=True)
class FitProgress:
    """State of a fit.

    Parameters
    ----------
    round
        How often readings have been given to responses, from 1.
    values
        Parameters as they are by name.
    distance
        Root mean square of the weighted residuals.
    """

    round: int
    values: Mapping[str, float]
    distance: float


@dataclass(frozen=True, eq=False)
class Estimate:
    """A fitted parameter.

    Parameters
    ----------
    name, unit
        Which, and its unit.
    value
        Its fitted value.
    error
        Its standard error; infinite where readings say nothing about it.
    low, high
        Ends of the interval of 95 % confidence.
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
class Explained:
    """What a fit came to."""

    model: Model
    used: Truth  # which rows, shape (m,)
    prediction: Prediction  # of the rows used
    estimates: tuple[Estimate, ...]
    scatter: float  # root mean square of the weighted residuals, by degrees of freedom
    converged: bool
    message: str


def find_fit(
    model: Model,
    measurement: Measurement,
    bounds: Mapping[str, tuple[float, float]],
    observer: Callable[[FitProgress], None] | None = None,
) -> Explained:
    """Find the parameters within bounds with which stable responses come nearest to readings."""
    names = tuple(bounds)
    weights, known = _weights(measurement)
    _check(measurement, names)
    used, prediction = _explained(model, measurement, weights, known)
    for number in range(1, ROUNDS + 1):
        _check_enough(used, measurement, names)
        if observer is not None:
            values = {name: model.values[name] for name in names}
            rest = _residuals(prediction, measurement, used, weights)
            observer(FitProgress(number, values, float(np.sqrt(np.mean(rest**2)))))
        closest = _closest(prediction, measurement, used, weights, bounds)
        model = closest.model
        again, found = _explained(model, measurement, weights, known)
        settled = np.array_equal(used, again) and _same(closest, found)
        used, prediction = again, found
        if settled:
            break
    _check_enough(used, measurement, names)
    return _result(prediction, measurement, used, weights, known, bounds, settled)


def _check(measurement: Measurement, names: tuple[str, ...]) -> None:
    if not names:
        raise InputError("no parameter is fitted; give at least one with its bounds")
    if measurement.vary in names:
        raise InputError(
            f"{measurement.vary} was varied in the measurement, so it cannot be fitted; fit others"
        )


def _check_enough(used: Truth, measurement: Measurement, names: tuple[str, ...]) -> None:
    count = int(np.isfinite(measurement.readings[used]).sum())
    if count <= len(names):
        raise InputError(
            f"stable responses explain {count} of {np.isfinite(measurement.readings).sum()} "
            f"readings, too few for {len(names)} parameters; begin nearer to what was measured, or "
            "fit fewer parameters"
        )


def _weights(measurement: Measurement) -> tuple[Array, bool]:
    """Return one over the standard deviations, and whether these are known.

    Those that are not are taken to be the same share of the range of each quantity.
    """
    readings, errors = measurement.readings, measurement.errors
    there = np.isfinite(readings)
    given = np.isfinite(errors) & there
    if given.any():
        if not (given == there).all():
            raise InputError(
                f"{given.sum()} of {there.sum()} readings have an error; give one for each, or none"
            )
        return np.where(there, 1 / np.where(there, errors, 1.0), 0.0), True
    ranges = np.nanmax(readings, axis=0) - np.nanmin(readings, axis=0)
    ranges = np.where(ranges > 0, ranges, np.nanmax(np.abs(readings), axis=0))
    return np.where(there, 1 / np.where(ranges > 0, ranges, 1.0), 0.0), False


def _explained(
    model: Model, measurement: Measurement, weights: Array, known: bool
) -> tuple[Truth, Prediction]:
    """Return which readings a stable response explains, with the orbits that come nearest."""
    vary, quantities = measurement.vary, measurement.quantities
    candidates = stable_orbits(model, vary, measurement.values, quantities)
    chosen: list[StableOrbit | None] = []
    distances = np.full(len(measurement), np.inf)
    for row, orbits in enumerate(candidates):
        away = [_distance(orbit.read, measurement.readings[row], weights[row]) for orbit in orbits]
        best = int(np.argmin(away)) if away else None
        chosen.append(None if best is None else orbits[best])
        distances[row] = np.inf if best is None else away[best]
    there = np.isfinite(distances)
    typical = TYPICAL * float(np.median(distances[there])) if there.any() else 0.0
    used = distances <= FAR * max(typical, 1.0 if known else LEAST)
    nearest = tuple(item for item, uses in zip(chosen, used, strict=True) if uses and item)
    return used, Prediction(model, vary, quantities, nearest)


def _distance(read: Array, reading: Array, weights: Array) -> float:
    there = weights > 0
    if not there.any():
        return np.inf
    return float(np.sqrt(np.mean(((read - reading)[there] * weights[there]) ** 2)))


def _residuals(
    prediction: Prediction, measurement: Measurement, used: Truth, weights: Array
) -> Array:
    """Return the weighted residuals of the readings used that are there."""
    there = weights[used] > 0
    away = (prediction.read - measurement.readings[used])[there]
    return np.asarray(away * weights[used][there])


def _closest(
    prediction: Prediction,
    measurement: Measurement,
    used: Truth,
    weights: Array,
    bounds: Mapping[str, tuple[float, float]],
) -> Prediction:
    """Return the prediction nearest to readings, each by the orbit it was given to."""
    names, (low, high) = tuple(bounds), _ends(bounds)
    sizes = high - low
    there = weights[used] > 0
    known = {tuple(_values(prediction, names)): prediction}
    last = [prediction]

    def at(values: Array) -> Prediction | None:
        key = tuple(values.tolist())
        if key not in known:
            changes = dict(zip(names, key, strict=True))
            try:
                moved = last[0].moved(last[0].model.replace(**changes))
            except InputError:
                moved = None
            if moved is None:
                return None
            known[key] = moved
        return known[key]

    def away(values: Array) -> Array:
        found = at(values)
        if found is None:  # SciPy takes a shorter step then
            return np.full(int(there.sum()), np.inf)
        return _residuals(found, measurement, used, weights)

    def slopes(values: Array) -> Array:
        found = at(values)
        assert found is not None
        last[0] = found
        rows = sensitivities(found, names, sizes)[there] * weights[used][there][:, None]
        return np.nan_to_num(rows)

    start = np.clip(_values(prediction, names), low, high)
    from scipy.optimize import least_squares  # half a second to import, as below

    solved: Any = least_squares(
        away, start, slopes, bounds=(low, high), x_scale=sizes, xtol=1e-12, ftol=1e-14, gtol=1e-14,
        max_nfev=60,
    )  # fmt: skip
    best = at(solved.x)
    return last[0] if best is None else best


def _values(prediction: Prediction, names: tuple[str, ...]) -> Array:
    return np.array([prediction.model.values[name] for name in names])


def _ends(bounds: Mapping[str, tuple[float, float]]) -> tuple[Array, Array]:
    low, high = np.array(list(bounds.values()), dtype=float).T
    return low, high


def _same(one: Prediction, other: Prediction) -> bool:
    """Whether two predictions are of the same orbits."""
    if len(one.orbits) != len(other.orbits):
        return False
    apart = np.abs(one.read - other.read)
    return bool((apart <= SETTLED * (np.abs(one.read) + np.abs(other.read)) + 1e-300).all())


def _result(
    prediction: Prediction,
    measurement: Measurement,
    used: Truth,
    weights: Array,
    known: bool,
    bounds: Mapping[str, tuple[float, float]],
    settled: bool,
) -> Explained:
    names, (low, high) = tuple(bounds), _ends(bounds)
    there = weights[used] > 0
    rest = _residuals(prediction, measurement, used, weights)
    freedom = len(rest) - len(names)
    scatter = float(np.sqrt(rest @ rest / freedom))
    slopes = sensitivities(prediction, names, high - low)[there] * weights[used][there][:, None]
    covariance = covariance_of(slopes[np.isfinite(slopes).all(axis=1)], high - low)
    if not known:
        covariance = covariance * scatter**2
    values = _values(prediction, names)
    return Explained(
        prediction.model,
        used,
        prediction,
        _estimates(prediction.model, bounds, covariance, freedom, known),
        scatter,
        settled,
        _message(names, values, (low, high), covariance, settled, used),
    )


def _estimates(
    model: Model,
    bounds: Mapping[str, tuple[float, float]],
    covariance: Array,
    freedom: int,
    known: bool,
) -> tuple[Estimate, ...]:
    """Return what is known of each parameter, from errors that are known or estimated.

    Shapes: covariance (p, p).
    """
    from scipy.special import ndtri, stdtrit

    errors = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore"):
        correlations = covariance / np.outer(errors, errors)
    np.fill_diagonal(correlations, 1.0)
    share = 0.5 + CONFIDENCE / 2
    reach = float(ndtri(share) if known else stdtrit(freedom, share)) * errors
    values = [model.values[name] for name in bounds]
    found = []
    for row, (name, value) in enumerate(zip(bounds, values, strict=True)):
        least, most = bounds[name]
        ends = float(value - reach[row]), float(value + reach[row])
        unit = model.parameter(name).unit
        error = float(errors[row])
        found.append(Estimate(name, unit, value, error, *ends, least, most, correlations[row]))
    return tuple(found)


def covariance_of(slopes: Array, sizes: Array) -> Array:
    """Return the covariance of parameters from the derivatives of readings of unit error.

    Infinite where readings say nothing. Shapes: slopes (k, p), sizes (p,); returns (p, p).
    """
    _, singular, rows = np.linalg.svd(slopes * sizes, full_matrices=True)
    sharp = np.zeros(len(sizes))
    sharp[: len(singular)] = singular
    told = sharp > BLIND * max(sharp.max(), 1.0)
    covariance = (rows[told].T / sharp[told] ** 2) @ rows[told] * np.outer(sizes, sizes)
    blind = (np.abs(rows[~told]) > np.sqrt(BLIND)).any(axis=0)
    covariance[blind] = covariance[:, blind] = np.nan
    covariance[blind, blind] = np.inf
    return np.asarray(covariance)


def _message(
    names: tuple[str, ...],
    values: Array,
    ends: tuple[Array, Array],
    covariance: Array,
    settled: bool,
    used: Truth,
) -> str:
    """Return what a person has to know about a fit, empty if that is nothing."""
    said = []
    if not settled:
        said.append(f"after {ROUNDS} rounds readings still change from response to response")
    for name, value, low, high in zip(names, values, *ends, strict=True):
        near = 1e-6 * (high - low)
        if value - low < near or high - value < near:
            said.append(f"{name} lies at its bound {low if value - low < near else high:g}")
    said += [
        f"the readings say nothing about {name}" if len(names) == 1 else
        f"the readings cannot tell {name} from the others"
        for name, variance in zip(names, np.diag(covariance), strict=True)
        if not np.isfinite(variance)
    ]  # fmt: skip
    out = int((~used).sum())
    if out:
        said.append(f"{out} of {len(used)} rows are left out, which no stable response explains")
    return "; ".join(said)
