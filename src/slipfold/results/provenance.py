"""Where a result comes from: versions and time, and nothing of the machine or its user."""

from __future__ import annotations

import platform
from dataclasses import dataclass
from datetime import UTC, datetime

from slipfold.version import package_version

__all__ = ["Provenance", "provenance"]


@dataclass(frozen=True)
class Provenance:
    """What computed a result, and when.

    Parameters
    ----------
    slipfold, heyoka, numpy, python
        Versions.
    computed
        When the computation ended: UTC, ISO 8601.
    seconds
        How long it took.
    """

    slipfold: str
    heyoka: str
    numpy: str
    python: str
    computed: str
    seconds: float


def provenance(seconds: float) -> Provenance:
    """Describe a computation that has just ended."""
    import heyoka
    import numpy

    return Provenance(
        slipfold=package_version(),
        heyoka=heyoka.__version__,
        numpy=numpy.__version__,
        python=platform.python_version(),
        computed=datetime.now(UTC).isoformat(timespec="seconds"),
        seconds=seconds,
    )
