"""Names, units and meanings of what stands on an axis."""

from __future__ import annotations

from typing import Any

from slipfold.errors import InputError
from slipfold.explorer.plain_text import plain_text
from slipfold.models.model import Model
from slipfold.models.output import Output
from slipfold.models.parameter import State
from slipfold.models.suggestion import suggest

__all__ = ["axis_of"]


def axis_of(model: Model, name: str) -> dict[str, Any]:
    """Describe a parameter, state or output for an axis.

    Parameters
    ----------
    model
        The model.
    name
        Name of a parameter, state or output.

    Returns
    -------
    dict
        ``name``, ``label`` in plain text without its unit, ``unit`` and ``doc``.

    Raises
    ------
    InputError
        If there is none of that name.

    Examples
    --------
    >>> from slipfold.models import SlidingOscillator
    >>> axis_of(SlidingOscillator(), "alpha")["label"]
    'α'
    """
    for parameter in model.parameters:
        if parameter.name == name:
            return _axis(name, parameter.symbol, parameter.unit, parameter.doc)
    shown: list[State | Output] = [*model.states, *model.outputs()]
    for item in shown:
        if item.name == name:
            return _axis(name, item.label, item.unit, item.doc)
    names = [item.name for item in shown]
    raise InputError(
        f"{model.name} has no output {name!r}; {suggest(name, names)}it has {', '.join(names)}"
    )


def _axis(name: str, label: str, unit: str, doc: str) -> dict[str, Any]:
    text = plain_text(label or name).removesuffix(f" ({unit})")
    return {"name": name, "label": text, "unit": unit, "doc": doc}
