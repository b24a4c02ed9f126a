"""What `plot` of a result or a law calls; the layer of plots says from above how each is drawn."""

from __future__ import annotations

from collections.abc import Callable
from functools import singledispatch
from typing import Any


def _nothing() -> None:
    """Register nothing."""


register: Callable[[], None] = _nothing
"""Registers for each class how it is drawn, when something is: the top of the package sets it."""


@singledispatch
def draw(thing: object, **options: Any) -> Any:
    """Draw something and return its axes; `slipfold.figures` registers for each class how."""
    register()
    way = draw.dispatch(type(thing))
    if way is draw.dispatch(object):
        raise TypeError(f"nothing says how to draw a {type(thing).__name__}")
    return way(thing, **options)
