"""Thresholds of stability over a grid of two parameters, as a labelled result."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.models.parameter import Parameter
from slipfold.models.quantity import parse_quantity
from slipfold.results.attributes import result_attributes
from slipfold.results.columns import quantity_labels
from slipfold.results.labelled_table import LabelledTable, Variable
from slipfold.results.provenance import Provenance, provenance
from slipfold.thresholds.threshold_map import MapObserver, ThresholdMap, find_threshold_map

if TYPE_CHECKING:
    import xarray

__all__ = ["SCHEMA", "LabelledThresholdMap", "threshold_map", "threshold_table"]

SCHEMA = "slipfold.threshold_map/1"

Values = ArrayLike | Sequence[float | str]


@dataclass(frozen=True, eq=False, repr=False)
class LabelledThresholdMap(ThresholdMap):
    """A map of thresholds with what computed it; frozen.

    Made by `slipfold.threshold_map`.

    Parameters
    ----------
    model
        The model; its values of `threshold` and of the grid's parameters play no part.
    threshold
        Name of the parameter that is raised until stability is lost.
    type
        ``"PD"``: the bifurcation by which it is lost.
    over
        Values of the grid's two parameters by name, shapes (n1,) and (n2,).
    span
        First and last value of the threshold.
    values
        Thresholds, shape (n1, n2), in the unit of the parameter; NaN where there is none.
    states
        States of the orbits there at phase zero, shape (n1, n2, n_states).
    multipliers
        Their Floquet multipliers, complex, shape (n1, n2, n_states), largest modulus first.
    residuals
        How far each orbit fails to close, in scaled states, shape (n1, n2).
    kinds
        Why there is no threshold, in a few words, shape (n1, n2); empty where there is one.
    reasons
        The same as sentences.
    followed
        Whether the whole response was followed at this point, shape (n1, n2).
    provenance
        Versions and time.
    """

    provenance: Provenance

    def to_xarray(self) -> xarray.Dataset:
        """Return all numbers as one labelled dataset.

        Returns
        -------
        xarray.Dataset
            Along the two parameters of the grid. Complex numbers are two variables, ``..._real``
            and ``..._imag``; units and meanings are in the attributes, as are the full input and
            the count of failures.
        """
        return threshold_table(self).to_xarray()

    def save(self, path: str | Path) -> None:
        """Write the dataset to a netCDF-4 file, which `xarray.open_dataset` reads.

        Parameters
        ----------
        path
            The file, by custom ``....nc``. It is written whole or not at all.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        from slipfold.results.writing import write_file

        write_file(path, threshold_table(self).to_netcdf())


def threshold_map(
    model: Model,
    threshold: str,
    type: str = "PD",
    *,
    over: Mapping[str, Values],
    span: tuple[float | str, float | str],
    observer: MapObserver | None = None,
    **parameters: float | str,
) -> LabelledThresholdMap:
    """Find where the response of period 1 first loses its stability, over a grid of parameters.

    **Main arguments**

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
        Called after every line of the grid with a
        `slipfold.thresholds.threshold_map.MapProgress`. If it raises `KeyboardInterrupt`, or the
        user does, the points not reached say so.
    **parameters
        Parameters of the model to change first: numbers in SI units, or text with a unit.

    Returns
    -------
    LabelledThresholdMap
        Thresholds, and why some points have none.

    Raises
    ------
    InputError
        For an unknown parameter, a wrong unit, a value outside its bounds, an empty span or grid,
        or another type.

    Examples
    --------
    >>> import slipfold as sf
    >>> from slipfold.results.threshold_map import threshold_map
    >>> over = {"Vd": [0.4, 0.6, 1.0], "alpha": ["30deg", "60deg"]}
    >>> found = threshold_map(sf.SlidingOscillator(), "Nd", over=over, span=(0, 0.9))
    >>> print(found.values[1, 1].round(9))
    0.043578911
    """
    if not isinstance(model, Model):
        raise InputError(f"model = {model!r} is not a model; give e.g. SlidingOscillator()")
    if not isinstance(over, Mapping):
        raise InputError(
            f"over = {over!r} does not give values by name; give e.g. "
            f"{{'{model.parameters[0].name}': [...], '{model.parameters[1].name}': [...]}}"
        )
    for name in (threshold, *over):
        if name in parameters:
            raise InputError(
                f"{name} is varied, so it cannot be set to {parameters[name]} as well; "
                "give it once, in over or in the span"
            )
    changed = model.replace(**parameters)
    started = perf_counter()
    found = find_threshold_map(
        changed,
        threshold,
        type,
        over={name: _numbers(model.parameter(name), values) for name, values in over.items()},
        span=_ends(model.parameter(threshold), span),
        observer=observer,
    )
    return LabelledThresholdMap(**vars(found), provenance=provenance(perf_counter() - started))


def _ends(parameter: Parameter, span: tuple[float | str, float | str]) -> tuple[float, float]:
    try:
        first, last = span
    except (TypeError, ValueError):
        raise InputError(
            f"span = {span!r} is not a pair of numbers; give the first and the last value of "
            f"{parameter.name}"
        ) from None
    unit, name = parameter.unit, parameter.name
    return parse_quantity(first, unit, name), parse_quantity(last, unit, name)


def _numbers(parameter: Parameter, values: Values) -> ArrayLike:
    """Convert text with units; leave the rest to be checked with the grid."""
    if isinstance(values, list | tuple):
        return [parse_quantity(value, parameter.unit, parameter.name) for value in values]
    return values


def threshold_table(found: LabelledThresholdMap) -> LabelledTable:
    """Return all numbers of a map with their names, units and meanings.

    Parameters
    ----------
    found
        The map.

    Returns
    -------
    LabelledTable
        What `LabelledThresholdMap.to_xarray` describes.
    """
    model = found.model
    labels = {
        name: item for name, item in quantity_labels(model).items() if item.dimensions == ("state",)
    }
    for name, values in found.over.items():
        labels[name] = Variable((name,), values, _attributes(model.parameter(name)))
    first, second = found.axes
    title = f"{found.threshold} of {model.name} at its first {found.type} over {first} and {second}"
    attributes = {
        "threshold": found.threshold,
        "type": found.type,
        "span": np.array(found.span, dtype=float),
        "failures": json.dumps(found.failures),
        **result_attributes(SCHEMA, title, model, _input(found), found.provenance),
    }
    return LabelledTable(labels | _results(found), tuple(labels), attributes)


def _results(found: LabelledThresholdMap) -> dict[str, Variable]:
    parameter = found.model.parameter(found.threshold)
    multipliers, axes = found.multipliers, found.axes
    rows = (
        (found.threshold, found.values, _attributes(parameter), ()),
        ("kind", found.kinds, _about("why there is no threshold, in a few words"), ()),
        ("reason", found.reasons.astype(str), _about("why there is no threshold"), ()),
        ("followed", found.followed, _about("whether the whole response was followed here"), ()),
        (
            "residual",
            found.residuals,
            _about("how far the orbit fails to close, in scaled states", "1"),
            (),
        ),
        ("states", found.states, _about("state at phase zero"), ("state",)),
        (
            "multipliers_real",
            multipliers.real.copy(),
            _about("Floquet multipliers, real part", "1"),
            ("multiplier",),
        ),
        (
            "multipliers_imag",
            multipliers.imag.copy(),
            _about("Floquet multipliers, imaginary part", "1"),
            ("multiplier",),
        ),
    )
    return {
        name: Variable((*axes, *more), values, attributes)
        for name, values, attributes, more in rows
    }


def _about(long_name: str, units: str | None = None) -> dict[str, str]:
    return {"long_name": long_name} | ({} if units is None else {"units": units})


def _attributes(parameter: Parameter) -> dict[str, str]:
    return _about(parameter.doc or parameter.name, parameter.unit or "1")


def _input(found: LabelledThresholdMap) -> dict[str, Any]:
    return {
        "threshold": found.threshold,
        "type": found.type,
        "over": {name: values.tolist() for name, values in found.over.items()},
        "span": list(found.span),
    }
