"""How well a planned measurement would tell parameters, in one call."""

from __future__ import annotations

from collections.abc import Sequence
from time import perf_counter

from slipfold.computations.given import Values, checked_model
from slipfold.computations.measure import checked_errors, checked_values
from slipfold.errors import InputError
from slipfold.measured.information import plan
from slipfold.measured.quantity import parse_measured
from slipfold.models.model import Model
from slipfold.results.measured import MeasurementPlan
from slipfold.results.records import provenance


def plan_measurement(
    model: Model,
    vary: str,
    values: Values,
    quantities: Sequence[str],
    fitted: Sequence[str],
    *,
    errors: float | Sequence[float],
    **parameters: float | str,
) -> MeasurementPlan:
    """Tell how well readings at planned points would tell parameters, and which points tell most.

    The information matrix of a fit: the derivatives of what would be read with respect to the
    parameters, over the errors of the readings, at the stable response that a sweep through the
    values in their order meets.

    Parameters
    ----------
    model
        The model with the values of the parameters that are expected.
    vary
        Name of the parameter that would be swept.
    values
        Its values in the order of the sweep: numbers in SI units or text with units.
    quantities
        What would be measured, e.g. ``["max y"]``, as in `slipfold.measure`.
    fitted
        Names of the parameters that a fit is to tell.
    errors
        Standard deviation of readings, one for all quantities or one for each, in their units.
    **parameters
        Parameters of the model to change first: numbers in SI units, or text with a unit.

    Returns
    -------
    MeasurementPlan
        Expected standard errors and correlations of the parameters; derivatives of each reading;
        ``best(count)`` chooses points.

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
    changed = checked_model(model).replace(**parameters)
    measured = tuple(parse_measured(text, changed) for text in quantities)
    if not measured or not fitted:
        raise InputError("nothing is planned; give at least one quantity and one parameter to fit")
    for name in fitted:
        changed.variable_parameter(name)
    if vary in fitted:
        raise InputError(f"{vary} is varied, so it cannot be fitted; fit others")
    if len(set(fitted)) < len(fitted):
        raise InputError(f"a parameter stands twice among {', '.join(fitted)}; name each once")
    noise = checked_errors(errors, len(measured))
    if not (noise > 0).all():
        raise InputError("errors = 0 would tell everything exactly; give what readings scatter by")
    started = perf_counter()
    chosen = checked_values(changed.variable_parameter(vary), values)
    found = plan(changed, vary, chosen, measured, tuple(fitted), noise)
    return MeasurementPlan(
        model=changed,
        vary=vary,
        quantities=measured,
        fitted=tuple(fitted),
        values=chosen,
        read=found.read,
        slopes=found.slopes,
        errors=noise,
        provenance=provenance(perf_counter() - started),
    )
