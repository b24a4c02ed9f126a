"""What a test stand would measure, in one call."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from slipfold.computations.given import Values, checked_model, parse_values
from slipfold.errors import InputError
from slipfold.measured.measurement import Measurement
from slipfold.measured.quantity import parse_measured
from slipfold.measured.stand import swept
from slipfold.models.model import Model
from slipfold.models.parameter import Parameter
from slipfold.progress import Observer

DIRECTIONS = ("up", "down", "both")


def measure(
    model: Model,
    vary: str,
    values: Values,
    quantities: Sequence[str],
    *,
    sweep: str = "up",
    errors: float | Sequence[float] = 0.0,
    seed: int = 0,
    observer: Observer | None = None,
    **parameters: float | str,
) -> Measurement:
    """Measure the response of a model as a test stand would: by sweeping a parameter in steps.

    At each value the motion goes on from where it was at the one before, until it has settled or
    8000 forcing periods are over, and is read: so jumps and hysteresis show as they do in a test.

    Parameters
    ----------
    model
        The model, e.g. ``SlidingOscillator()``.
    vary
        Name of the parameter that is swept.
    values
        Its values: numbers in SI units or text with units, in any order.
    quantities
        What is measured, e.g. ``["max y", "peak_to_peak x"]``: max, min, peak_to_peak or modulus
        of an output, of a motion that does not settle over its last 256 periods.
    sweep
        ``"up"``, ``"down"``, or ``"both"``: up and then down.
    errors
        Standard deviation of the noise that is added to the readings, one for all quantities or
        one for each, in their units.
    seed
        Seed of the noise.
    observer
        Called before each reading with a `slipfold.Progress`. If it raises
        `KeyboardInterrupt`, or the user does, what was read by then is returned.
    **parameters
        Parameters of the model to change first: numbers in SI units, or text with a unit.

    Returns
    -------
    Measurement
        The readings in the order in which they were taken; where the motion ends at a limit, those
        before, and in `stopped` why.

    Raises
    ------
    InputError
        If something given cannot be used, the model has no forcing, or its motion ends at a limit
        before anything is read.

    Examples
    --------
    >>> import slipfold as sf
    >>> seen = sf.measure(sf.SlidingOscillator(Nd=0.1), "f", [12.1, 12.2], ["max y"], errors=1e-5)
    >>> len(seen), seen.errors.tolist()
    (2, [[1e-05], [1e-05]])
    """
    changed = checked_model(model).replace(**parameters)
    if not changed.forced:
        raise InputError(
            f"{changed.name} has no forcing, so that no response is measured over a parameter; "
            "simulate it instead"
        )
    parameter = changed.variable_parameter(vary)
    rising = np.unique(checked_values(parameter, values)).tolist()
    if sweep not in DIRECTIONS:
        raise InputError(f"sweep = {sweep!r} is no direction; give {', '.join(DIRECTIONS)}")
    ways = ["up", "down"] if sweep == "both" else [sweep]
    order = [value for way in ways for value in (rising if way == "up" else rising[::-1])]
    each = [way for way in ways for _ in rising]
    measured = tuple(parse_measured(text, changed) for text in quantities)
    if not measured:
        raise InputError("no quantity is measured; give e.g. ['max y']")
    noise = checked_errors(errors, len(measured))
    return swept(changed, vary, order, each, measured, noise, seed, observer)


def checked_values(parameter: Parameter, values: Values) -> np.ndarray:
    """Return values of a parameter that can all be used, shape (m,)."""
    given = np.atleast_1d(np.asarray(parse_values(parameter, values), dtype=float))
    if given.ndim != 1 or not given.size:
        raise InputError(f"the values of {parameter.name} are no row of numbers; give at least one")
    for value in given.tolist():
        parameter.check(value)
    return given


def checked_errors(errors: ArrayLike, count: int) -> np.ndarray:
    """Return a standard deviation for each quantity, shape (q,)."""
    given = np.asarray(errors, dtype=float)
    if given.ndim > 1 or (given.ndim == 1 and len(given) != count):
        raise InputError(f"errors = {errors!r} are not {count} numbers; give one, or one for each")
    if not (np.isfinite(given) & (given >= 0)).all():
        raise InputError(f"errors = {errors!r} are no standard deviations; give 0 or more")
    return np.broadcast_to(given, count).copy()
