"""What the contacts of a model do at a time."""

from __future__ import annotations

from enum import IntEnum
from functools import cache


class Status(IntEnum):
    """What one contact does."""

    BACK = -1  # along a line: slips backwards
    STICK = 0
    FORTH = 1  # slips: along a line forwards, in the plane in any direction
    OPEN = 2  # touches nothing
    SLOW = 3  # slips slowly in the plane; only how that is integrated differs

    __hash__ = int.__hash__  # that of names is slow, and modes are looked up all the time


Mode = tuple[Status, ...]
"""What each contact does."""

STUCK: Mode = (Status.STICK,)
"""That of a contact that is the only one."""


@cache
def shown(mode: Mode) -> Mode:
    """Return a mode as contacts know it, whatever it is integrated in."""
    return tuple(Status.FORTH if status is Status.SLOW else status for status in mode)


def status_name(status: int) -> str:
    """Return what histories say of it."""
    return _NAMES.get(status, "slip")


_NAMES: dict[int, str] = {Status.STICK: "stick", Status.OPEN: "free"}
