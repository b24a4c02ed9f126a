"""What a text has to say to make a model."""

from __future__ import annotations

from pathlib import Path

from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.models.registry import built_in_models
from slipfold.models.structures import Structure


def changed_values(model: Model, usual: Model | None = None) -> dict[str, float]:
    """Return the parameter values that differ from the defaults."""
    before = (
        {item.name: item.default for item in model.parameters} if usual is None else usual.values
    )
    return {name: value for name, value in model.values.items() if value != before[name]}


def filed_model(model: Model, file: Path | None) -> Structure:
    """Return the structure that a file holds, with the values that it has there."""
    if file is None:
        raise InputError(
            f"{model.name} was made in Python and not read from a file, so no text here can make "
            "it; save the result as netCDF"
        )
    found = Structure.from_toml(file)
    if found.kind != model.kind:
        raise InputError(
            f"{file} holds another structure than when the page was opened; open it again"
        )
    return found


def is_built_in(model: Model) -> bool:
    """Whether a model of this kind comes with the package under its name.

    >>> from slipfold.models import System
    >>> is_built_in(System(name="duffing", parameters={"k": 1}, states={"q": "-k*q"}))
    False
    """
    make = built_in_models().get(model.name)
    return make is not None and make().kind == model.kind
