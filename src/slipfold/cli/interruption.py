"""Ctrl-C while branches or loci are being followed: stop at the next point, keep what there is."""

from __future__ import annotations

import _thread
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from slipfold.continuation.follow import follow

__all__ = ["deferred_interrupts"]

GRACE = 0.4
"""Seconds that the next point may take after Ctrl-C."""


@contextmanager
def deferred_interrupts() -> Iterator[Callable[[], None]]:
    """Note Ctrl-C instead of raising `KeyboardInterrupt` at once; a second one does raise it.

    An interrupt while a branch is put together would lose it. While one is followed, it is raised
    where the next point takes too long: what was followed before is kept.
    """
    if threading.current_thread() is not threading.main_thread():  # signals go there
        yield lambda: None
        return
    deferred = _Deferred()
    before = signal.signal(signal.SIGINT, deferred.heard)
    try:
        yield deferred.check
    finally:
        deferred.timer.cancel()
        signal.signal(signal.SIGINT, before)


class _Deferred:
    """A Ctrl-C that waits for a place where it is safe to stop."""

    def __init__(self) -> None:
        self.pressed = self.overdue = self.begun = False
        self.timer = threading.Timer(GRACE, self._is_overdue)
        self.timer.daemon = True

    def check(self) -> None:
        """Stop here if there was a Ctrl-C."""
        self.begun = True
        if self.pressed:
            raise KeyboardInterrupt

    def heard(self, number: int, frame: FrameType | None) -> None:
        """Take a signal: from the keyboard, or that the next point takes too long."""
        if self.overdue:
            self.overdue = False
            # Before the first point there is nothing to lose.
            if not self.begun or _is_followed(frame):
                raise KeyboardInterrupt
            self._wait()
        elif self.pressed:
            signal.default_int_handler(number, frame)
        else:
            self.pressed = True
            self._wait()
            if sys.stderr.isatty():
                print("\nslipfold: stopping at the next point", file=sys.stderr)

    def _wait(self) -> None:
        self.timer.cancel()
        self.timer = threading.Timer(GRACE, self._is_overdue)
        self.timer.daemon = True
        self.timer.start()

    def _is_overdue(self) -> None:
        self.overdue = True
        _thread.interrupt_main()


def _is_followed(frame: FrameType | None) -> bool:
    """Whether a curve is being followed, which keeps its points when it is interrupted."""
    while frame is not None:
        if frame.f_code is follow.__code__:
            return True
        frame = frame.f_back
    return False
