"""Data classes that nobody changes by way of their arrays."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np


class ReadOnly:
    """Base of frozen data classes: arrays among their fields, and in mappings there, are locked."""

    def __post_init__(self) -> None:
        """Lock the arrays."""
        for value in vars(self).values():
            for each in value.values() if isinstance(value, Mapping) else (value,):
                if isinstance(each, np.ndarray):
                    each.setflags(write=False)
