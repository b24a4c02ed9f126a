"""What `plot` of a result or a law calls; the layer of plots says from above how each is drawn."""

from __future__ import annotations

from functools import singledispatch
from typing import Any

__all__ = ["draw"]


@singledispatch
def draw(thing: object, **options: Any) -> Any:
    """Draw something and return its axes; `slipfold.figures` registers for each class how."""
    raise TypeError(f"nothing says how to draw a {type(thing).__name__}")
