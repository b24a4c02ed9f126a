"""Where a result comes from: versions and time, and nothing of the machine or its user."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from dataclasses import dataclass, fields
from datetime import UTC, datetime
from typing import Any

from slipfold.version import package_version


@dataclass(frozen=True)
class Provenance:
    """What computed a result, and when.

    Parameters
    ----------
    slipfold, heyoka, numpy, python
        Versions.
    computed
        When the computation ended: UTC, ISO 8601; None of a study, which ends more than once.
    seconds
        How long it took; likewise.
    """

    slipfold: str
    heyoka: str
    numpy: str
    python: str
    computed: str | None = None
    seconds: float | None = None

    def attributes(self) -> dict[str, Any]:
        """Return it as attributes of a file."""
        known = {_attribute(each.name): getattr(self, each.name) for each in fields(self)}
        return {name: value for name, value in known.items() if value is not None}

    @classmethod
    def from_attributes(cls, attributes: Mapping[str, Any]) -> Provenance:
        """Make it again from the attributes of a file."""
        names = ("slipfold", "heyoka", "numpy", "python")
        versions: dict[str, Any] = {name: str(attributes[_attribute(name)]) for name in names}
        if "computed" not in attributes:
            return cls(**versions)
        return cls(
            **versions, computed=str(attributes["computed"]), seconds=float(attributes["seconds"])
        )


def _attribute(name: str) -> str:
    return name if name in ("computed", "seconds") else f"{name}_version"


def provenance(seconds: float | None = None) -> Provenance:
    """Describe a computation that has just ended after some seconds, or one without a time."""
    import heyoka
    import numpy

    return Provenance(
        slipfold=package_version(),
        heyoka=heyoka.__version__,
        numpy=numpy.__version__,
        python=platform.python_version(),
        computed=None if seconds is None else datetime.now(UTC).isoformat(timespec="seconds"),
        seconds=seconds,
    )
