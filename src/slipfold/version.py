"""The versions of the installed package and of what it computes with."""

from __future__ import annotations

import platform
from functools import cache


@cache
def package_version() -> str:
    """Return the version of slipfold, ``"unknown"`` if it is not installed."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("slipfold")
    except PackageNotFoundError:
        return "unknown"


@cache
def versions() -> dict[str, str]:
    """Return the versions of the programs that last digits depend on."""
    from importlib.metadata import version

    known = {name: version(name) for name in ("heyoka", "numpy", "scipy")}
    return {"slipfold": package_version(), **known, "python": platform.python_version()}
