"""Messages about unknown names: the nearest known name, and all that are known."""

from __future__ import annotations

import difflib
import re
from collections.abc import Collection, Iterable

from slipfold.errors import InputError

_KINDS = {
    "maps, which are discrete in time,": re.compile(r"maps?|next|iterates?|difference_equations"),
    "delays": re.compile(r"delay(s|ed)?|lags?|history|dde"),
    "boundary-value problems": re.compile(r"(left_|right_)?boundar(y|ies)\w*|bcs?|bvp"),
}
"""Problems that models cannot state, with the names by which people try."""


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


def not_supported(name: str) -> str:
    """Return that a kind of problem is not supported, if an unknown name suggests it.

    >>> not_supported("maps")
    'maps, which are discrete in time, are not supported; '
    >>> not_supported("state")
    ''
    """
    for kind, names in _KINDS.items():
        if names.fullmatch(name.lower()):
            return f"{kind} are not supported; "
    return ""


def unknown(what: str, name: object, known: Collection[str]) -> InputError:
    """Return the error of a name that something has not, with those it has.

    >>> raise unknown("sliding has no parameter", "vd", ["Vd", "Nd"])
    Traceback (most recent call last):
    ...
    slipfold.errors.InputError: sliding has no parameter 'vd'; did you mean Vd? it has Vd, Nd
    """
    return InputError(f"{what} {name!r}; {suggest(str(name), known)}it has {', '.join(known)}")
