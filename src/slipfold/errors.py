"""The one error a user meets, its suggestions, and what is raised where numbers break down."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager

from numpy.linalg import LinAlgError


def breakdown(error: Exception) -> str:
    """Say as a clause what broke down; of a refusal what it says.

    >>> breakdown(ZeroDivisionError("division by zero"))
    'the computation broke down (division by zero)'
    """
    if isinstance(error, InputError):
        return str(error)
    return f"the computation broke down ({str(error) or type(error).__name__})"


class InputError(ValueError):
    """Input that cannot be used; the message says what was given, what is allowed, what to do.

    All functions raise it for arguments that they cannot use; their docstrings name other reasons.
    The command line prints the message alone and exits with status 2.

    Parameters
    ----------
    message
        The sentence.
    *entry
        Keys that lead to the entry of a file that it is about, if it is known.

    Examples
    --------
    >>> raise InputError("mu = -1 is below its bound 0; give mu >= 0")
    Traceback (most recent call last):
    ...
    slipfold.errors.InputError: mu = -1 is below its bound 0; give mu >= 0
    """

    def __init__(self, message: str, *entry: str) -> None:
        super().__init__(message)
        self.entry = entry


NUMERICAL = (ArithmeticError, LinAlgError, RuntimeError)
"""What linear algebra, SciPy and heyoka raise where numbers are beyond them."""

BREAKDOWNS = (*NUMERICAL, InputError)
"""What computations may raise; any other error is one of the program."""


@contextmanager
def about(*entry: str) -> Iterator[None]:
    """Say of errors which entry they are about.

    >>> try:
    ...     with about("structure", "M"):
    ...         raise InputError("M is singular")
    ... except InputError as error:
    ...     print(error.entry)
    ('structure', 'M')
    """
    try:
        yield
    except InputError as error:
        error.entry = (*entry, *error.entry)
        raise


def refusal(attempt: Callable[..., object], /, *given: object, **named: object) -> str:
    """Return why something is refused; empty if it is not."""
    try:
        attempt(*given, **named)
    except InputError as error:
        return str(error)
    return ""


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


def index_of(name: str, names: Sequence[str], kind: str) -> int:
    """Return the place of a name, or say which there are of its kind.

    >>> index_of("y", ("x", "y"), "output")
    1
    """
    if name not in names:
        raise InputError(f"no {kind} {name!r}; {suggest(name, names)}there are {', '.join(names)}")
    return names.index(name)


def unknown(what: str, name: object, known: Collection[str]) -> InputError:
    """Return the error of a name that something has not, with those it has.

    >>> raise unknown("sliding has no parameter", "vd", ["Vd", "Nd"])
    Traceback (most recent call last):
    ...
    slipfold.errors.InputError: sliding has no parameter 'vd'; did you mean Vd? it has Vd, Nd
    """
    return InputError(f"{what} {name!r}; {suggest(str(name), known)}it has {', '.join(known)}")
