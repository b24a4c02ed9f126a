"""The one error a user meets, and what is raised where numbers break down."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

BREAKDOWNS = (ArithmeticError, ValueError, RuntimeError)
"""What linear algebra, SciPy and heyoka raise where numbers are beyond them."""


def breakdown(error: Exception) -> str:
    """Say as a clause what broke down.

    >>> breakdown(ZeroDivisionError("division by zero"))
    'the computation broke down (division by zero)'
    """
    return f"the computation broke down ({str(error) or type(error).__name__})"


class InputError(ValueError):
    """Input that cannot be used; the message says what was given, what is allowed, what to do.

    The command line prints the message alone and exits with status 2.

    Examples
    --------
    >>> raise InputError("mu = -1 is below its bound 0; give mu >= 0")
    Traceback (most recent call last):
    ...
    slipfold.errors.InputError: mu = -1 is below its bound 0; give mu >= 0
    """

    entry: tuple[str, ...] = ()
    """Keys that lead to the entry of a file that it is about, if it is known."""


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
