"""Thresholds of stability over a grid of two parameters, in one call."""

from __future__ import annotations

from collections.abc import Mapping
from time import perf_counter

from slipfold.checks.curves import check_thresholds
from slipfold.computations.given import (
    Values,
    checked_model,
    parse_ends,
    parse_values,
    refuse_varied,
)
from slipfold.errors import InputError
from slipfold.models.followed import check_followed
from slipfold.models.model import Model
from slipfold.progress import Observer
from slipfold.results.records import provenance
from slipfold.results.thresholds import ThresholdMap
from slipfold.thresholds.threshold_map import find_threshold_map


def threshold_map(
    model: Model,
    threshold: str,
    type: str = "PD",
    *,
    over: Mapping[str, Values],
    span: tuple[float | str, float | str],
    observer: Observer | None = None,
    **parameters: float | str,
) -> ThresholdMap:
    """Find where the response of period 1 first loses its stability, over a grid of parameters.

    Parameters
    ----------
    model
        The model, e.g. ``SlidingOscillator()``.
    threshold
        Name of the parameter that is raised until stability is lost, e.g. ``"Nd"``.
    type
        Bifurcation by which it is lost: ``"PD"``.
    over
        Values of two other parameters by name, each of shape (n,), distinct: numbers in SI units,
        or text with a unit.
    span
        First and last value of the threshold: numbers in SI units, or text with a unit. A
        descending span is fine.
    observer
        Called after every few lines of the grid with a `slipfold.Progress`. If it raises
        `KeyboardInterrupt`, or the user does, the points not reached say so.
    **parameters
        Parameters of the model to change first: numbers in SI units, or text with a unit.

    Returns
    -------
    ThresholdMap
        Thresholds, and why some points have none.

    Raises
    ------
    InputError
        For an unknown parameter, a wrong unit, a value outside its bounds, an empty span or grid,
        or another type.

    Examples
    --------
    >>> import slipfold as sf
    >>> over = {"Vd": [0.4, 0.6, 1.0], "alpha": ["30deg", "60deg"]}
    >>> found = sf.threshold_map(sf.SlidingOscillator(), "Nd", over=over, span=(0, 0.9))
    >>> print(found.values[1, 1].round(9))
    0.043578911
    """
    model = checked_model(model)
    if not isinstance(over, Mapping):
        raise InputError(
            f"over = {over!r} does not give values by name; give e.g. "
            f"{{'{model.parameters[0].name}': [...], '{model.parameters[1].name}': [...]}}"
        )
    refuse_varied((threshold, *over), parameters, "over or in the span")
    changed = model.replace(**parameters)
    check_followed(changed)
    started = perf_counter()
    found = find_threshold_map(
        changed,
        threshold,
        type,
        over={
            name: parse_values(model.variable_parameter(name), values)
            for name, values in over.items()
        },
        span=parse_ends(model.variable_parameter(threshold), span),
        observer=observer,
    )
    checked = check_thresholds(found)
    origin = provenance(perf_counter() - started)
    return ThresholdMap(**vars(found), provenance=origin, checked=checked)
