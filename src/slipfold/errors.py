"""The one error a user meets: a sentence that names the value, the bound and the way out."""

from __future__ import annotations

__all__ = ["InputError"]


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
