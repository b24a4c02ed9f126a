"""Options of continuation as people give them."""

from __future__ import annotations

from slipfold.branches.settings import Settings
from slipfold.errors import InputError

__all__ = ["checked_settings"]


def checked_settings(given: Settings | None) -> Settings:
    """Return the options given, the defaults if there are none, or raise.

    Examples
    --------
    >>> checked_settings(None).newton.tolerance
    1e-10
    """
    if given is None:
        return Settings()
    if not isinstance(given, Settings):
        raise InputError(
            f"settings = {given!r} are not options of continuation; give e.g. "
            "Settings(steps=Steps(largest=0.1))"
        )
    return given
