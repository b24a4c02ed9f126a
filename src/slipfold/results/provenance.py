"""Where a result comes from: versions and time, and nothing of the machine or its user."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from dataclasses import dataclass, fields
from datetime import UTC, datetime
from typing import Any

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

    def attributes(self) -> dict[str, Any]:
        """Return it as attributes of a file."""
        return {_attribute(each.name): getattr(self, each.name) for each in fields(self)}

    @classmethod
    def from_attributes(cls, attributes: Mapping[str, Any]) -> Provenance:
        """Make it again from the attributes of a file."""
        found = {each.name: attributes[_attribute(each.name)] for each in fields(cls)}
        seconds = float(found.pop("seconds"))
        return cls(**{name: str(value) for name, value in found.items()}, seconds=seconds)


def _attribute(name: str) -> str:
    return name if name in ("computed", "seconds") else f"{name}_version"


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
