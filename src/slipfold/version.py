"""The version of the installed package."""

from __future__ import annotations

from functools import cache


@cache
def package_version() -> str:
    """Return the version of slipfold, ``"unknown"`` if it is not installed."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("slipfold")
    except PackageNotFoundError:
        return "unknown"
