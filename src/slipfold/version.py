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


def versions() -> dict[str, str]:
    """Return the versions of the programs that last digits depend on."""
    import heyoka
    import numpy
    import scipy

    return {
        "slipfold": package_version(),
        "heyoka": heyoka.__version__,
        "numpy": numpy.__version__,
        "scipy": scipy.__version__,
        "python": platform.python_version(),
    }
