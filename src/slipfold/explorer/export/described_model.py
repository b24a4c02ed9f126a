"""What a text has to say to make a model."""

from __future__ import annotations

from slipfold.models.model import Model
from slipfold.models.registry import built_in_models

__all__ = ["changed_values", "is_built_in"]


def changed_values(model: Model) -> dict[str, float]:
    """Return the parameter values that differ from the defaults.

    Parameters
    ----------
    model
        The model.
    """
    return {
        item.name: model.values[item.name]
        for item in model.parameters
        if model.values[item.name] != item.default
    }


def is_built_in(model: Model) -> bool:
    """Whether a model of this kind comes with the package under its name.

    Parameters
    ----------
    model
        The model.

    Examples
    --------
    >>> from slipfold.models import System
    >>> is_built_in(System(name="duffing", parameters={"k": 1}, states={"q": "-k*q"}))
    False
    """
    make = built_in_models().get(model.name)
    return make is not None and make().kind == model.kind
