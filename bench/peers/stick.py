"""Den Hartog's oscillator with two stops a period, and its motion in closed form, for all programs.

    x'' + x = cos(W t) - S sgn x',   |friction| <= S at rest

Between its events the motion is a sum of sines; the events are roots of such sums.
"""

import math
from collections.abc import Callable

FREQUENCY, FRICTION = 0.35, 0.6
"""W and S. Static friction is equal to kinetic friction, which solve-nivp asks for."""

PERIOD = 2 * math.pi / FREQUENCY

SCAN = 0.01
"""Time in which slip has no two zeros."""


def state_after(periods: int) -> tuple[float, float]:
    """Displacement and velocity after some periods from rest at zero, to rounding."""
    time, x, v, end = 0.0, 0.0, 0.0, periods * PERIOD
    gain = 1 / (1 - FREQUENCY**2)
    while time < end:
        pull = math.cos(FREQUENCY * time) - x
        if v == 0 and abs(pull) <= FRICTION * (1 + 1e-12) and not _yields(time, x):
            time = _release(time, x)
            if time >= end:
                return x, 0.0
            pull = math.cos(FREQUENCY * time) - x
        sign = math.copysign(1.0, v or pull)
        # x = a cos s + b sin s + particular, s the time since here
        a = x - gain * math.cos(FREQUENCY * time) + sign * FRICTION
        b = v + gain * FREQUENCY * math.sin(FREQUENCY * time)

        def speed(
            s: float, a: float = a, b: float = b, begun: float = time, sign: float = sign
        ) -> float:
            forced = -gain * FREQUENCY * math.sin(FREQUENCY * (begun + s))
            return sign * (b * math.cos(s) - a * math.sin(s) + forced)

        low = SCAN
        while speed(low + SCAN) > 0 and time + low < end:
            low += SCAN
        s = end - time if time + low >= end else _root(speed, low, low + SCAN)
        s = min(s, end - time)
        x = a * math.cos(s) + b * math.sin(s) + gain * math.cos(FREQUENCY * (time + s))
        x -= sign * FRICTION
        v = sign * speed(s) if time + s >= end else 0.0
        time += s
    return x, v


def _yields(time: float, x: float) -> bool:
    """Whether the pull at the limit of friction grows."""
    pull = math.cos(FREQUENCY * time) - x
    grows = -math.sin(FREQUENCY * time) * pull > 0
    return abs(pull) >= FRICTION * (1 - 1e-12) and grows


def _release(time: float, x: float) -> float:
    """The next time at which the pull is as large as friction and grows."""
    found = []
    for sign in (1, -1):
        level = x + sign * FRICTION
        if abs(level) < 1:
            phase = math.copysign(math.acos(level), -sign)
            turns = math.ceil((FREQUENCY * time - phase) / (2 * math.pi) - 1e-12)
            found.append((phase + 2 * math.pi * turns) / FREQUENCY)
    return min(found, default=math.inf)


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    for _ in range(200):
        middle = (low + high) / 2
        if middle in (low, high):
            break
        low, high = (middle, high) if function(middle) > 0 else (low, middle)
    return high
