"""What the contacts of a model do at a time."""

from __future__ import annotations

from enum import IntEnum

__all__ = ["Mode", "Status", "status_name"]


class Status(IntEnum):
    """What one contact does."""

    BACK = -1  # along a line: slips backwards
    STICK = 0
    FORTH = 1  # slips: along a line forwards, in the plane in any direction
    OPEN = 2  # touches nothing


Mode = tuple[Status, ...]
"""What each contact does."""


def status_name(status: Status) -> str:
    """Return what histories say of it."""
    return {Status.STICK: "stick", Status.OPEN: "free"}.get(status, "slip")
