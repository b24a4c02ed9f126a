"""Integrators of which every thread has copies of its own: they hold work space."""

from __future__ import annotations

import copy
import threading
from collections.abc import Callable
from typing import Any


class OwnCopies:
    """Integrators by name, one of each a thread.

    They release Python's lock while they run, so threads run side by side; a copy takes a
    millisecond. The originals are never run: what runs cannot be copied.
    """

    def __init__(self) -> None:
        self._originals: dict[str, Any] = {}
        self._building = threading.Lock()
        self._own = threading.local()

    def get(self, name: str, build: Callable[[], Any]) -> Any:
        """Return this thread's copy."""
        own = self._own.__dict__
        if name not in own:
            with self._building:
                if name not in self._originals:
                    self._originals[name] = build()
            own[name] = copy.copy(self._originals[name])
        return own[name]
