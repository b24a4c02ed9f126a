"""Cosine and sine of numbers and of symbols alike."""

from __future__ import annotations

import math

import heyoka as hy

from slipfold.models.friction.functions import is_symbolic
from slipfold.models.output import Expression


def cos_sin(angle: Expression) -> tuple[Expression, Expression]:
    """Return the cosine and the sine."""
    if is_symbolic(angle):
        return hy.cos(angle), hy.sin(angle)
    return math.cos(angle), math.sin(angle)


def wave(harmonic: int, phase: Expression) -> tuple[Expression, Expression]:
    """Return the cosine and the sine of a harmonic of the forcing."""
    return cos_sin(2 * math.pi * harmonic * phase)
