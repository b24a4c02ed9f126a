"""The nearest known name, for messages about unknown ones."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

__all__ = ["suggest"]


def suggest(name: str, known: Iterable[str]) -> str:
    """Return ``"did you mean ...? "`` for the known name nearest to `name`, or nothing.

    >>> suggest("VD", ["Vd", "Nd"])
    'did you mean Vd? '
    >>> suggest("pressure", ["Vd", "Nd"])
    ''
    """
    lowered = {item.lower(): item for item in known}
    near = difflib.get_close_matches(name.lower(), lowered, n=1, cutoff=0.5)
    return f"did you mean {lowered[near[0]]}? " if near else ""
