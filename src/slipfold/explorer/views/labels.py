"""Names, units and meanings of what stands on an axis."""

from __future__ import annotations

import re
from typing import Any

from slipfold.explorer.plain_text import plain_text
from slipfold.models.model import Model
from slipfold.models.output import Output
from slipfold.models.parameter import State
from slipfold.models.suggestion import unknown

SYMBOL = re.compile(r"\$([^_$]+)(?:_\{*(\\?\w+)\}*)?\$")
"""A symbol in mathtext, and what stands below it."""

NUMBERED = re.compile(r"([A-Za-z])([0-9]*)")
"""A name that reads as a symbol: one letter, and perhaps a number."""


def axis_of(model: Model, name: str) -> dict[str, Any]:
    """Describe a parameter, state or output for an axis.

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
    raise unknown(f"{model.name} has no output", name, names)


def _axis(name: str, label: str, unit: str, doc: str) -> dict[str, Any]:
    """Describe a quantity by its label, or by its name where it has none of its own."""
    formula = label.removesuffix(f" ({unit})") or name
    parts = (SYMBOL if label else NUMBERED).fullmatch(formula)
    return {
        "name": name,
        "label": plain_text(formula) if label else name,
        "symbol": [plain_text(part or "") for part in parts.groups()] if parts else None,
        "unit": unit,
        "doc": doc,
    }
