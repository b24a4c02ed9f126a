"""Averages along a trajectory, and the rotation numbers of a torus."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from slipfold.arrays import Array


class Average(NamedTuple):
    """Averages of some values along a trajectory, and how much they may be off."""

    values: Array  # shape (k,)
    errors: Array  # shape (k,)


def average(values: Array) -> Average:
    """Average values along a trajectory with smooth weights that vanish at both of its ends.

    Along a periodic or quasi-periodic trajectory errors fall faster than any power of the length
    (Das, Saiki, Sander and Yorke, Nonlinearity 30 (2017) 4111); along a chaotic one they fall with
    its square root, as those of the mean do. The error is the largest difference from the same
    averages over each half and over the middle.

    What is minus infinity at once is so on average, for certain. Shapes: values (m, k).

    >>> import numpy as np
    >>> turns = np.arange(1000) * 0.381966
    >>> found = average(np.cos(2 * np.pi * turns)[:, None] + 3)
    >>> bool(abs(found.values[0] - 3) < 1e-12), bool(found.errors[0] < 1e-9)
    (True, True)
    """
    count = len(values)
    lost = np.isneginf(values).any(axis=0)
    kept = np.where(lost, 0.0, values)
    whole = bump(count) @ kept
    half, quarter = count // 2, count // 4
    parts = (kept[:half], kept[half:], kept[quarter : quarter + half])
    apart = [np.abs(bump(len(part)) @ part - whole) for part in parts]
    return Average(np.where(lost, -np.inf, whole), np.max(apart, axis=0))


def bump(count: int) -> Array:
    """Return weights that add up to one, with all derivatives zero at the ends, shape (m,)."""
    place = (np.arange(count) + 0.5) / count
    weights = np.exp(-1 / (place * (1 - place)))
    return np.asarray(weights / weights.sum())


LINES = 6
"""Strongest lines of the spectrum, which have to be multiples of one of them."""

MULTIPLES = 32
"""Largest of these multiples."""

MATCH = 1e-6
"""Distance of a line from a multiple, in turns."""


@dataclass(frozen=True)
class Rotation:
    """How the closed curve on which a trajectory passes phase zero is turned; frozen.

    Parameters
    ----------
    number
        The rotation number, from 0 to 1/2: turns of the curve over `period`.
    period
        Forcing periods after which the curve is mapped onto itself.
    error
        Estimated error of the number: the difference from that of its second half.
    resonance
        A fraction p/q near the number, None if there is none: the curve nearly closes after q
        returns.
    beat
        Forcing periods after which it has closed once more or less than at the resonance, else NaN:
        what is averaged along the trajectory converges only beyond several of them.
    """

    number: float
    period: int
    error: float
    resonance: Fraction | None
    beat: float

    @property
    def sentence(self) -> str:
        """The same in words."""
        over = "a forcing period" if self.period == 1 else f"{self.period} forcing periods"
        text = f"its rotation number is {self.number:.6g} +- {self.error:.0e} over {over}"
        if self.resonance is None:
            return text
        return f"{text}, near the resonance {self.resonance} (beats of {self.beat:.4g} periods)"


def rotation_of(states: Array, scales: Array, turns: Array) -> Rotation | None:
    """Return the rotation number of a torus from states at phase zero; None if it is unclear.

    On a torus of two frequencies all lines of the spectrum of states k periods apart are multiples
    of one line, the rotation number. Shapes: states (m, n); scales, turns (n,).
    """
    angles = turns > 0
    parts = [
        states[:, ~angles] / scales[~angles],
        np.cos(states[:, angles]),
        np.sin(states[:, angles]),
    ]
    signal = np.concatenate(parts, axis=1)
    # Lines near a resonance lie close together.
    signal = signal[-min(65536, (len(signal) + 1) // 2) :]
    lines = _lines(signal - bump(len(signal)) @ signal)
    for period in range(1, 9):  # periods after which the curve returns to itself
        numbers = _folded(period * lines)
        result = _generator(numbers[numbers > MATCH])
        if result is not None:
            half = signal[len(signal) // 2 :]
            others = _folded(period * _lines(half - bump(len(half)) @ half))
            return _rotation(result, period, float(np.abs(others - result).min()))
    return None


def _lines(signal: Array) -> Array:
    """Return the frequencies of the strongest lines in turns per period, LINES at most."""
    from scipy.optimize import minimize_scalar

    count = len(signal)
    weights, times = bump(count)[:, None], np.arange(count)
    rest, result, strongest = signal.copy(), list[float](), 0.0
    for _ in range(LINES):
        power = (np.abs(np.fft.rfft(weights * rest, axis=0)) ** 2).sum(axis=1)
        coarse = power[1:].argmax() + 1

        def missed(turns: float, rest: Array = rest) -> float:
            wave = np.exp(-2j * np.pi * turns * times)
            return -float((np.abs(wave @ (weights * rest)) ** 2).sum())

        ends = (coarse - 1) / count, min((coarse + 1) / count, 0.5)
        best = minimize_scalar(missed, bounds=ends, method="bounded", options={"xatol": 1e-12})
        wave = np.exp(2j * np.pi * best.x * times)
        amplitude = wave.conj() @ (weights * rest)
        factor = 1.0 if 0.5 - best.x < 1 / count else 2.0
        rest = rest - factor * np.real(wave[:, None] * amplitude)
        strongest = max(strongest, float(np.abs(amplitude).max()))
        if np.abs(amplitude).max() < 1e-4 * strongest:  # faint
            break
        result.append(best.x)
    return np.array(result)


def _generator(lines: Array) -> float | None:
    """Return the line of which all are multiples, the lowest ones if there are several."""
    best, order = None, MULTIPLES + 1
    for line in lines:
        multiples = _folded(np.arange(1, MULTIPLES + 1) * line)
        apart = np.abs(lines[:, None] - multiples)
        matches = apart <= MATCH * np.arange(1, MULTIPLES + 1)
        if matches.any(axis=1).all():
            needed = int(matches.argmax(axis=1).max()) + 1
            if needed < order:
                best, order = float(line), needed
    return best


def _folded(turns: Array) -> Array:
    """Return turns from 0 to 1/2: whole ones and the direction are not seen."""
    return np.asarray(np.abs(turns - np.round(turns)))


def _rotation(number: float, period: int, error: float) -> Rotation:
    """Return a rotation number with the resonance that it is near."""
    resonance, beat = None, float("nan")
    for q in range(1, 201):
        p = round(q * number)
        off = abs(q * number - p)
        # Hurwitz: infinitely many fractions come as near as 0.447 to any number.
        if p and 0 < off * q < 0.1 and not period / off <= beat:
            resonance, beat = Fraction(p, q), period / off
    return Rotation(number, period, error, resonance, beat)
