"""The version of the package that is running."""

from __future__ import annotations

from functools import cache


@cache
def package_version() -> str:
    """Return the version of slipfold; ``"unknown"`` if it runs from a folder, not installed."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("slipfold")
    except PackageNotFoundError:
        return "unknown"
