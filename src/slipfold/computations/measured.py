"""Measured responses: a simulated test stand, a fit, and a plan of measurements."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from slipfold import options
from slipfold.arrays import as_numbers
from slipfold.computations.arguments import checked_forced, checked_model, checked_values
from slipfold.declarations import documented
from slipfold.errors import InputError, suggest
from slipfold.models.model import Model
from slipfold.models.units import interval
from slipfold.parameter_space.measurement import Measurement, parse_measured
from slipfold.progress import Observer
from slipfold.results.records import provenance

if TYPE_CHECKING:
    from slipfold.results.measured import Fit, MeasurementPlan

DIRECTIONS = ("up", "down", "both")


@documented
def measure(
    model: Model,
    vary: options.Vary,
    values: options.MeasuredValues,
    quantities: options.Quantities,
    *,
    sweep: options.Sweeping = "up",
    errors: options.Errors = 0.0,
    seed: options.Seed = 0,
    on_progress: Observer | None = None,
    **parameters: float | str,
) -> Measurement:
    """Measure the response of a model as a test stand would: by sweeping a parameter in steps.

    At each value the solution continues from the last state of the value before, until it is steady
    or for 8000 forcing periods, and is measured: jumps and hysteresis appear as in a test.

    Returns
    -------
    Measurement
        The measurements in their order; if the solution ends at a limit, those before, with the
        reason in `stopped`.

    Raises
    ------
    InputError
        If something given cannot be used, the model has no forcing, or its solution ends at a
        limit before anything is measured.

    Examples
    --------
    >>> import slipfold as sf
    >>> seen = sf.measure(sf.SlidingOscillator(Nd=0.1), "f", [12.1, 12.2], ["max y"], errors=1e-5)
    >>> len(seen), seen.errors.tolist()
    (2, [[1e-05], [1e-05]])
    """
    from slipfold.parameter_space.simulated_measurement import swept

    changed = checked_forced(
        checked_model(model).replace(**parameters), "it has no response to measure; use simulate"
    )
    parameter = changed.variable_parameter(vary)
    rising = np.unique(checked_values(parameter, values)).tolist()
    if sweep not in DIRECTIONS:
        meant = suggest(str(sweep), DIRECTIONS)
        raise InputError(f"sweep = {sweep!r} is not a direction; {meant}give up, down or both")
    ways = ["up", "down"] if sweep == "both" else [sweep]
    order = [value for way in ways for value in (rising if way == "up" else rising[::-1])]
    each = [way for way in ways for _ in rising]
    measured = tuple(parse_measured(text, changed) for text in quantities)
    if not measured:
        raise InputError("no quantity is measured; give e.g. ['max y']")
    noise = checked_errors(errors, len(measured))
    return swept(changed, vary, order, each, measured, noise, seed, on_progress)


def checked_errors(errors: ArrayLike, count: int) -> np.ndarray:
    """Return a standard deviation for each quantity, shape (q,)."""
    given = as_numbers(errors)
    if given.shape not in ((), (count,)):
        raise InputError(
            f"errors = {errors!r} do not fit the quantities; give one standard deviation in SI "
            "units, or one for each"
        )
    if not (np.isfinite(given) & (given >= 0)).all():
        raise InputError(f"errors = {errors!r} are no standard deviations; give 0 or more")
    return np.broadcast_to(given, count).copy()


@documented
def fit(
    model: Model,
    measurement: options.Measured,
    bounds: options.Bounds,
    *,
    on_progress: Observer | None = None,
    **parameters: float | str,
) -> Fit:
    """Fit parameters so that the stable responses of a model are closest to measurements.

    The response is followed over the parameter that was varied in the measurement, from both ends
    of its span; each measurement is assigned to the nearest stable orbit. For these orbits the
    weighted sum of squares is minimized. Measurements are assigned again as long as the sum
    decreases.
    Searches start from the values of the model and from other points within the bounds; the
    smallest sum counts. A measurement beyond six typical distances from every stable orbit is left
    out and counts as one at that distance; the result lists these measurements with the reason.

    Returns
    -------
    Fit
        The parameters with intervals of 95 % confidence from the profile of the sum of squares,
        inside the bounds; standard errors and correlations of the linearized model; the predicted
        values; the rows used.

    Raises
    ------
    InputError
        If a parameter or bound cannot be used, the model has no forcing, or stable responses
        explain too few measurements.

    Examples
    --------
    >>> import slipfold as sf
    >>> truth = sf.SlidingOscillator(f=12.5, mu=0.46)
    >>> seen = sf.measure(truth, "Nd", [0.01, 0.02, 0.03, 0.04], ["max y"])
    >>> sf.fit(truth.replace(mu=0.5), seen, {"mu": (0.3, 0.7)})["mu"].value.__round__(6)
    0.46
    """
    from slipfold.parameter_space.least_squares import find_fit
    from slipfold.results.measured import Fit

    changed = checked_model(model).replace(**parameters)
    if not isinstance(measurement, Measurement):
        raise InputError(
            f"measurement = {measurement!r} is not a measurement; give what "
            "read_measurement returns"
        )
    started = perf_counter()
    checked = {name: _bounds(changed, name, ends) for name, ends in bounds.items()}
    result = find_fit(changed, measurement, checked, on_progress)
    used = result.best.used(result.scale)
    prediction = result.best.prediction(used)
    predicted = np.full(measurement.measured.shape, np.nan)
    predicted[used] = prediction.predicted
    period = np.zeros(len(measurement), dtype=np.int64)
    period[used] = [orbit.period for orbit in prediction.orbits]
    return Fit(
        model=result.best.model,
        measurement=measurement,
        estimates=result.estimates,
        predicted=predicted,
        period=period,
        used=used,
        residual_std=result.residual_std,
        converged=result.converged,
        interrupted=result.interrupted,
        message=result.message,
        provenance=provenance(perf_counter() - started),
    )


def _bounds(model: Model, name: str, ends: tuple[float | str, float | str]) -> tuple[float, float]:
    """Return the bounds of a parameter, between which its value must lie."""
    low, high = interval(model.variable_parameter(name), ends, "range", rising=True)
    value = model.values[name]
    if not low <= value <= high:
        raise InputError(
            f"{name} = {value:g} is outside the range from {low:g} to {high:g} in which it is "
            "fitted; set it to a value inside, where the fit starts"
        )
    return low, high


@documented
def plan_measurement(
    model: Model,
    vary: options.Vary,
    values: options.MeasuredValues,
    quantities: options.Quantities,
    fitted: options.Fitted,
    *,
    errors: options.Errors,
    **parameters: float | str,
) -> MeasurementPlan:
    """Compute how accurately planned measurements determine parameters, and the best points.

    The information matrix of a fit: the derivatives of the measured quantities with respect to the
    parameters, over the errors of the measurements, at the stable response that a sweep through the
    values in their order follows.

    Returns
    -------
    MeasurementPlan
        Expected standard errors and correlations of the parameters; derivatives of each
        measurement; ``best(count)`` chooses points.

    Raises
    ------
    InputError
        If something given cannot be used, or no response is stable at any of the values.

    Examples
    --------
    >>> import slipfold as sf
    >>> frequencies = [11.9 + 0.1 * step for step in range(8)]
    >>> planned = sf.plan_measurement(
    ...     sf.SlidingOscillator(Nd=0.04), "f", frequencies, ["max y"], ["mu", "zeta1"], errors=1e-4
    ... )
    >>> planned.errors_expected.shape
    (2,)
    """
    from slipfold.parameter_space.stable_orbits import plan
    from slipfold.results.measured import MeasurementPlan

    changed = checked_model(model).replace(**parameters)
    measured = tuple(parse_measured(text, changed) for text in quantities)
    if not measured or not fitted:
        raise InputError("nothing is planned; give at least one quantity and one parameter to fit")
    for name in fitted:
        changed.variable_parameter(name)
    if vary in fitted:
        raise InputError(f"{vary} is varied, so it cannot be fitted; fit others")
    if len(set(fitted)) < len(fitted):
        raise InputError(f"a parameter is named twice in {', '.join(fitted)}; name each once")
    noise = checked_errors(errors, len(measured))
    if not (noise > 0).all():
        raise InputError(
            "errors = 0 leave nothing uncertain; give standard deviations of the measurements"
        )
    started = perf_counter()
    chosen = checked_values(changed.variable_parameter(vary), values)
    predicted, slopes = plan(changed, vary, chosen, measured, fitted, noise)
    return MeasurementPlan(
        model=changed,
        vary=vary,
        quantities=measured,
        fitted=tuple(fitted),
        values=chosen,
        predicted=predicted,
        slopes=slopes,
        errors=noise,
        provenance=provenance(perf_counter() - started),
    )
