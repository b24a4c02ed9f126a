"""What a user gave, as a message shows it."""

from __future__ import annotations

from typing import Any

LONGEST_LINE = 60


def shown(value: Any) -> str:
    """Return a value as it would be typed, on one line and not too long.

    >>> shown("tip")
    "'tip'"
    """
    try:
        text = " ".join(repr(value).split())
    except ValueError:  # a whole number of more digits than Python prints
        text = f"a {type(value).__name__}"
    return text if len(text) <= LONGEST_LINE else f"{text[: LONGEST_LINE - 3]}..."
