"""By the number of states: how derivatives of a motion are carried along with it."""

from __future__ import annotations

WHOLE = 24
"""Up to this many states all derivatives ride along with one motion, beyond it a few at a time.

Measured on chains of 2 to 30 masses with a cubic spring and a friction contact, their matrices
tridiagonal or full, both ways in turn. All at once takes half to nine tenths of the time at up to
16 states; at 20 to 30 both take as long; at 40 a few at a time are faster by 1.2 to 1.5, at 60 by
1.6. The equations of all at once grow with the square of the states, and their compile time with
them; a few at a time take little longer to compile at 80 states than at 10."""

COLUMNS = 4
"""Derivatives that ride along at a time: with two, the motion itself is half of the work; eight
gain nothing."""


def carried_whole(states: int) -> bool:
    """Return whether all derivatives of a motion ride along with it at once."""
    return states <= WHOLE
