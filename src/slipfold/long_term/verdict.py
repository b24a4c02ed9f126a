"""What kind of motion its Lyapunov exponents tell of."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.settlement import Settlement
from slipfold.long_term.rotation import Rotation

SURE = 3.0
"""Errors by which an exponent differs from zero if it is said to."""

ZERO = 2e-5
"""Largest error, a period, of an exponent that is said to be zero: those of chaos are larger."""

ROUNDING = 1e-10
"""Exponents, a period, that rounding may leave of zero."""


@dataclass(frozen=True)
class Verdict:
    """What a motion is, with the sentence that says so."""

    kind: str  # equilibrium, periodic, torus, chaos or undecided
    message: str
    period: int | None = None  # forcing periods
    duration: float | None = None  # s, of a cycle
    rotation: float | None = None  # of a torus, in turns over some forcing periods
    resonance: str | None = None  # p/q that this is near

    def with_rotation(self, rotation: Rotation | None) -> Verdict:
        """Return the verdict with the rotation number of a torus, if there is one."""
        if rotation is None:
            return self
        near = None if rotation.resonance is None else str(rotation.resonance)
        message = f"{self.message}; {rotation.sentence}"
        return replace(self, message=message, rotation=rotation.number, resonance=near)

    @property
    def known(self) -> bool:
        """Whether more periods would tell no more."""
        repeats = (self.period or self.duration) is not None
        return repeats if self.kind == "periodic" else self.kind != "undecided"


def verdict_of(
    exponents: Array, errors: Array, settlement: Settlement, seconds: float | None
) -> Verdict:
    """Tell from exponents a period, in descending order, and from what a motion settled on.

    `seconds` is the length of a period of a motion that nothing forces: one exponent is zero then,
    that along the motion. Shapes: exponents, errors (n,).
    """
    if settlement.settled:
        return _settled(settlement, exponents[0] > SURE * errors[0] + ROUNDING)
    slack = SURE * errors + ROUNDING
    if exponents[0] > slack[0]:
        return Verdict("chaos", f"chaotic: nearby motions part, {_doubling(exponents[0], seconds)}")
    zero = np.abs(exponents) <= slack
    doubtful = int(np.where(zero, errors, 0.0).argmax())
    if zero[doubtful] and errors[doubtful] > ZERO:
        return Verdict(
            "undecided",
            f"undecided: exponent {doubtful + 1}, {exponents[doubtful]:.2g} a period, is known to "
            f"{errors[doubtful]:.0e} only; give more periods",
        )
    free = int(zero.sum()) - (seconds is not None)
    if free < 0:
        return Verdict("equilibrium", "it approaches an equilibrium")
    if free == 0 or (len(exponents) == 2 and seconds is not None):
        return Verdict(
            "periodic", "periodic: nearby motions do not part; more periods show its period"
        )
    frequencies = free + 1
    return Verdict("torus", f"quasi-periodic, on a torus of {frequencies} frequencies")


def _settled(settlement: Settlement, grows: bool) -> Verdict:
    message = settlement.message + ("; what disturbs it grows" if grows else "")
    if settlement.kind == "equilibrium":
        return Verdict("equilibrium", message)
    period = None if settlement.kind == "cycle" else settlement.period
    return Verdict("periodic", message, period, settlement.duration)


def _doubling(exponent: float, seconds: float | None) -> str:
    doubles = math.log(2) / exponent
    if seconds is None:
        return f"twice as far after {doubles:.3g} forcing periods"
    return f"twice as far after {doubles * seconds:.3g} s"
