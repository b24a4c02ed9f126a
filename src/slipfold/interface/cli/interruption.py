"""Ctrl-C or SIGTERM while something is computed: stop at the next point, keep what there is."""

from __future__ import annotations

import _thread
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM)

GRACE = 0.4
"""Maximum seconds of the next point after a signal."""

TOGETHER = 0.2
"""Seconds in which signals are one: `timeout` sends it to the command and to its group."""

INTERRUPTIBLE = frozenset(
    {
        "slipfold.bifurcations.branches.known_curves.passing",
        "slipfold.bifurcations.branches.make_branch.complete_branches",
        "slipfold.bifurcations.branches.make_branch.describe_in_turn",
        "slipfold.results.checks.curves.check_some",
        "slipfold.results.checks.trajectories.check_trajectory",
        "slipfold.bifurcations.branches.response.BranchTree.children",
        "slipfold.bifurcations.loci.follow._Loci.children",
        "slipfold.continuation.follow.follow",
        "slipfold.flow.simulate.Integration.run",
        "slipfold.bifurcations.loci.bifurcation_set.until_interrupted",
        "slipfold.bifurcations.loci.make_locus.as_loci",
        "slipfold.bifurcations.loci.regions.map_regions",
        "slipfold.long_term.exponents.follow_exponents",
        "slipfold.long_term.search.search",
        "slipfold.parameter_space.least_squares.find_fit",
        "slipfold.studies.run.first_finished",
        "slipfold.studies.run.compute",
    }
)
"""Functions that may be interrupted anywhere and keep their finished results. They are named, so
that a command imports none that it does not call."""


@contextmanager
def deferred_interrupts() -> Iterator[Callable[[], None]]:
    """Note Ctrl-C or SIGTERM instead of raising `KeyboardInterrupt`; a second one does.

    An interrupt while a branch is assembled would lose it. Functions that keep finished results are
    interrupted if the next point takes too long.
    """
    if threading.current_thread() is not threading.main_thread():  # signals go there
        yield lambda: None
        return
    deferred = _DeferredInterrupt()
    before = {number: signal.signal(number, deferred.receive) for number in SIGNALS}
    try:
        yield deferred.check
    finally:
        deferred.timer.cancel()
        for number, handler in before.items():
            signal.signal(number, handler)


class _DeferredInterrupt:
    """A signal that waits until it is safe to stop."""

    def __init__(self) -> None:
        self.overdue = self.started = False
        self.pressed: float | None = None  # when
        self.timer = threading.Timer(GRACE, self._is_overdue)

    def check(self) -> None:
        """Stop here if there was a signal."""
        self.started = True
        if self.pressed is not None:
            raise KeyboardInterrupt

    def receive(self, number: int, frame: FrameType | None) -> None:
        """Take a signal: from the keyboard, or that the next point takes too long."""
        if self.overdue:
            self.overdue = False
            self._wait()  # the next stage may take as long
            # Before the first point there is nothing to lose.
            if not self.started or _keeps_results(frame):
                raise KeyboardInterrupt
        elif self.pressed is None:
            self.pressed = time.monotonic()
            self._wait()
            if sys.stderr.isatty():
                print("\nslipfold: stopping at the next point", file=sys.stderr)
        elif time.monotonic() - self.pressed >= TOGETHER:
            signal.default_int_handler(number, frame)

    def _wait(self) -> None:
        self.timer.cancel()
        self.timer = threading.Timer(GRACE, self._is_overdue)
        self.timer.daemon = True
        self.timer.start()

    def _is_overdue(self) -> None:
        self.overdue = True
        _thread.interrupt_main()


def _keeps_results(frame: FrameType | None) -> bool:
    """Whether a running function keeps its finished results when it is interrupted."""
    if frame is not None and frame.f_globals.get("__name__") == "weakref":
        return False  # Python prints and ignores what a callback raises
    while frame is not None:
        if f"{frame.f_globals.get('__name__')}.{frame.f_code.co_qualname}" in INTERRUPTIBLE:
            return True
        frame = frame.f_back
    return False
