"""Parameters from a measured response, in one call."""

from __future__ import annotations

from collections.abc import Mapping
from time import perf_counter

import numpy as np

from slipfold.computations.given import checked_model, parse_ends
from slipfold.errors import InputError
from slipfold.measured.least_squares import find_fit
from slipfold.measured.measurement import Measurement
from slipfold.models.model import Model
from slipfold.progress import Observer
from slipfold.results.measured import Fit
from slipfold.results.records import provenance


def fit(
    model: Model,
    measurement: Measurement,
    bounds: Mapping[str, tuple[float | str, float | str]],
    *,
    observer: Observer | None = None,
    **parameters: float | str,
) -> Fit:
    """Find the parameters with which the stable responses of a model come nearest to readings.

    The response is followed over the parameter that was varied in the measurement, from both ends
    of its span; each reading is explained by the stable orbit there that comes nearest. With these
    orbits held the weighted sum of squares is minimised, then readings are explained anew, as long
    as the sum decreases. This begins with the values of the model and at other places within the
    bounds, and the least sum counts. A reading beyond six typical distances from every stable orbit
    is left out and counts as one at that distance; which and why is said.

    Parameters
    ----------
    model
        The model, with the values to begin with.
    measurement
        What was measured, e.g. from `slipfold.read_measurement`. Where it has standard deviations
        they weigh the readings and give the errors of the parameters; where it has none, all
        readings have the same share of the range of their quantity, and what is left over tells it.
    bounds
        Least and greatest value of each parameter to be fitted, by name: numbers in SI units or
        text with a unit.
    observer
        Called at each round with a `slipfold.Progress`.
    **parameters
        Parameters of the model to change first: numbers in SI units, or text with a unit.

    Returns
    -------
    Fit
        The parameters with intervals of 95 % confidence from the profile of the sum of squares,
        inside the bounds; standard errors and correlations, as the model linearised about them
        tells; what is predicted; which rows were used.

    Raises
    ------
    InputError
        If a parameter or bound cannot be used, the model has no forcing, or stable responses
        explain too few readings.

    Examples
    --------
    >>> import slipfold as sf
    >>> truth = sf.SlidingOscillator(f=12.5, mu=0.46)
    >>> seen = sf.measure(truth, "Nd", [0.01, 0.02, 0.03, 0.04], ["max y"])
    >>> sf.fit(truth.replace(mu=0.5), seen, {"mu": (0.3, 0.7)})["mu"].value.__round__(6)
    0.46
    """
    changed = checked_model(model).replace(**parameters)
    if not isinstance(measurement, Measurement):
        raise InputError(
            f"measurement = {measurement!r} is not a measurement; give what "
            "read_measurement returns"
        )
    started = perf_counter()
    checked = {name: _bounds(changed, name, ends) for name, ends in bounds.items()}
    found = find_fit(changed, measurement, checked, observer)
    used = found.best.used(found.scale)
    prediction = found.best.prediction(used)
    predicted = np.full(measurement.readings.shape, np.nan)
    predicted[used] = prediction.read
    period = np.zeros(len(measurement), dtype=np.int64)
    period[used] = [orbit.period for orbit in prediction.orbits]
    return Fit(
        model=found.best.model,
        measurement=measurement,
        estimates=found.estimates,
        predicted=predicted,
        period=period,
        used=used,
        scatter=found.scatter,
        converged=found.converged,
        message=found.message,
        provenance=provenance(perf_counter() - started),
    )


def _bounds(model: Model, name: str, ends: tuple[float | str, float | str]) -> tuple[float, float]:
    """Return the bounds of a parameter, between which its value must lie."""
    parameter = model.variable_parameter(name)
    low, high = (parameter.check(end) for end in parse_ends(parameter, ends))
    if not low < high:
        raise InputError(
            f"the bounds of {name} from {low:g} to {high:g} leave nothing between them; give the "
            "least and the greatest value"
        )
    value = model.values[name]
    if not low <= value <= high:
        raise InputError(
            f"{name} = {value:g} lies outside its bounds {low:g} to {high:g}; set it to a value "
            "inside, with which to begin"
        )
    return low, high
