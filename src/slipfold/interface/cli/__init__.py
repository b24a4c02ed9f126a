"""The command line: ``slipfold response``, ``locus``, ``simulate``, ``paper`` and more."""

from __future__ import annotations

import gc
import signal
import sys

from slipfold.threads import take_one_thread

__all__ = ["main"]


def main() -> None:
    """Run the command line with the arguments of this process, and exit with its status."""
    # A shell makes a command in the background ignore SIGINT. Somebody who sends it anyway wants
    # the command to stop. Schedulers of clusters stop a command by SIGTERM.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    take_one_thread()
    gc.disable()  # imports leave no garbage; looking for it takes a twelfth of a short command
    try:
        from slipfold.interface.cli.app import app
    except KeyboardInterrupt:  # while it starts
        sys.exit(130)
    app(prog_name="slipfold")
