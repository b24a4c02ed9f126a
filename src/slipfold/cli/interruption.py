"""Ctrl-C while branches or loci are being followed: stop at the next point, keep what there is."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

__all__ = ["deferred_interrupts"]


@contextmanager
def deferred_interrupts() -> Iterator[Callable[[], None]]:
    """Note Ctrl-C instead of raising `KeyboardInterrupt` at once; a second one does raise it.

    An interrupt in the middle of a point would lose the branch that the point belongs to.

    Yields
    ------
    callable
        To be called where it is safe to stop: raises `KeyboardInterrupt` if there was a Ctrl-C.
    """
    pressed = False

    def remember(number: int, frame: FrameType | None) -> None:
        nonlocal pressed
        if pressed:
            signal.default_int_handler(number, frame)
        pressed = True
        if sys.stderr.isatty():
            print("\nslipfold: stopping at the next point", file=sys.stderr)

    def check() -> None:
        if pressed:
            raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():  # signals go there
        yield check
        return
    before = signal.signal(signal.SIGINT, remember)
    try:
        yield check
    finally:
        signal.signal(signal.SIGINT, before)
