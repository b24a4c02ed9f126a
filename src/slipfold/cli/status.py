"""Exit statuses, and how things are said: results on standard output, all else beside it."""

from __future__ import annotations

import os
import sys

from slipfold.errors import InputError

DONE = 0
BAD_INPUT = 2
FAILED = 3
"""A branch, locus or motion stopped early, as it could not be followed; results are written."""

INTERRUPTED = 130


def note(sentence: str) -> None:
    """Say something that is no result."""
    first, *excerpt = sentence.split("\n")
    print("slipfold:", "\n".join([" ".join(first.split()), *excerpt]), file=sys.stderr)


def say(text: str) -> None:
    """Print a result on standard output."""
    try:
        print(text)
        sys.stdout.flush()
    except BrokenPipeError:
        # The reader has seen enough, which is no failure.
        _discard()
    except OSError as error:
        _discard()
        why = (error.strerror or str(error)).lower()
        raise InputError(
            f"standard output cannot be written ({why}); free some space or send it elsewhere"
        ) from error


def _discard() -> None:
    """Let what is still to be printed vanish: Python tries again when it exits."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
