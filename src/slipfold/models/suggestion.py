"""What is said of unknown names: the nearest known one, and which there are."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable

from slipfold.errors import InputError

__all__ = ["suggest", "unknown"]


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


def unknown(what: str, name: object, known: Collection[str]) -> InputError:
    """Return the error of a name that something has not, with those it has.

    >>> raise unknown("sliding has no parameter", "vd", ["Vd", "Nd"])
    Traceback (most recent call last):
    ...
    slipfold.errors.InputError: sliding has no parameter 'vd'; did you mean Vd? it has Vd, Nd
    """
    return InputError(f"{what} {name!r}; {suggest(str(name), known)}it has {', '.join(known)}")
