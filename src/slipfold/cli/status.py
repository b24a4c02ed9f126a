"""Exit statuses, and the one way in which things are said on standard error."""

from __future__ import annotations

import sys

__all__ = ["BAD_INPUT", "DONE", "FAILED", "INTERRUPTED", "note"]

DONE = 0
BAD_INPUT = 2
FAILED = 3
"""A branch or a motion stopped early because it could not be followed; results are written."""

INTERRUPTED = 130


def note(sentence: str) -> None:
    """Say something that is no result.

    Parameters
    ----------
    sentence
        One line; line breaks in it become spaces.
    """
    print("slipfold:", " ".join(sentence.split()), file=sys.stderr)
