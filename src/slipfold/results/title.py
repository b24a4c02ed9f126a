"""What the titles of results share: which parameters were set."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

from slipfold.text.printed_table import with_unit

if TYPE_CHECKING:
    from slipfold.models.model import Model

__all__ = ["without_defaults"]


def without_defaults(model: Model, varied: Collection[str]) -> str:
    """Return the parameters that were set, as the end of a title: nothing if none was."""
    values = ", ".join(
        with_unit(f"{item.name} = {model.values[item.name]:.6g}", item.unit)
        for item in model.parameters
        if item.name not in varied and model.values[item.name] != item.default
    )
    return f"; {values}" if values else ""
