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

    Examples
    --------
    >>> from slipfold.models import SlidingOscillator
    >>> axis_of(SlidingOscillator(), "alpha")["label"]
    'α'
    """
    for parameter in model.parameters:
        if parameter.name == name:
            same = [item.symbol for item in model.parameters].count(parameter.symbol) > 1
            return _axis(name, "" if same else parameter.symbol, parameter.unit, parameter.doc)
    shown: list[State | Output] = [*model.states, *model.outputs()]
    for item in shown:
        if item.name == name:
            same = [other.label for other in shown].count(item.label) > 1
            return _axis(name, "" if same else item.label, item.unit, item.doc)
    names = [item.name for item in shown]
    raise InputError(
        f"{model.name} has no output {name!r}; {suggest(name, names)}it has {', '.join(names)}"
    )


def _axis(name: str, label: str, unit: str, doc: str) -> dict[str, Any]:
    """Describe a quantity by its label, or by its name where it has none of its own."""
    text = plain_text(label).removesuffix(f" ({unit})") if label else name
    return {"name": name, "label": text, "unit": unit, "doc": doc}
