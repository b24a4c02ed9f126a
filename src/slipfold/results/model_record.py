"""What a model's equations depend on besides parameter values, as plain data in saved files."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from slipfold.models.friction import law_from_record, law_record
from slipfold.models.model import Model
from slipfold.models.registry import model_named
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.models.system import System

__all__ = ["model_from_record", "structure_record"]


def structure_record(model: Model) -> dict[str, Any]:
    """Return what a model's equations depend on besides its class, as plain data for JSON.

    Parameters
    ----------
    model
        The model.

    Returns
    -------
    dict
        Empty where the class says it all; the TOML text of a system, the friction law of an
        oscillator.
    """
    if not model.structure:
        return {}
    if isinstance(model, System):
        return {"definition": model.to_toml()}
    if isinstance(model, SlidingOscillator):
        return {"friction": law_record(model.friction)}
    return {}


def model_from_record(name: str, structure: Mapping[str, Any], values: Mapping[str, Any]) -> Model:
    """Make a saved model again.

    Parameters
    ----------
    name
        Name of the model.
    structure
        What `structure_record` made of it.
    values
        Parameter values by name.

    Raises
    ------
    InputError
        If there is no such model, or a value does not fit it.
    """
    if "definition" in structure:
        return System(str(structure["definition"]), **values)
    if "friction" in structure:
        return SlidingOscillator(friction=law_from_record(structure["friction"]), **values)
    return model_named(name, **values)
