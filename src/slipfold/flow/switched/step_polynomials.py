"""Taylor polynomials of a motion, step by step.

What heyoka offers for this compiles code for each piece of motion, which takes longer than most
pieces.
"""

from __future__ import annotations

from typing import Any

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

__all__ = ["StepPolynomials", "step_to"]

Array = NDArray[np.float64]

SUCCESS, STEP_LIMIT = int(hy.taylor_outcome.success), int(hy.taylor_outcome.step_limit)


class StepPolynomials:
    """What lies between the ends of steps."""

    def __init__(self, times: list[float], coefficients: list[Array]) -> None:
        self.times = np.array(times)  # ends of the steps, shape (m + 1,)
        self.tcs = np.array(coefficients)  # of powers of the time in a step, shape (m, n, order)

    def __call__(self, times: Array) -> Array:
        """Return states at some times, shape (p, n). Shapes: times (p,)."""
        place = np.searchsorted(self.times, times, side="right") - 1
        place = np.clip(place, 0, len(self.tcs) - 1)
        passed = (times - self.times[place])[:, None]
        coefficients = self.tcs[place]
        values = coefficients[:, :, -1]
        for power in range(coefficients.shape[2] - 2, -1, -1):
            values = values * passed + coefficients[:, :, power]
        return np.asarray(values)


def step_to(integrator: Any, end: float, steps: int) -> tuple[int, StepPolynomials]:
    """Integrate step by step; return the outcome of the last one, and what lies between."""
    times, coefficients = [float(integrator.time)], []
    for _ in range(steps):
        found, _ = integrator.step(end - integrator.time, write_tc=True)
        outcome = int(found)
        coefficients.append(np.array(integrator.tc))
        times.append(float(integrator.time))
        # Outcomes from zero on are events at which the integrator goes on.
        if outcome != SUCCESS and outcome < 0:
            return outcome, StepPolynomials(times, coefficients)
    return STEP_LIMIT, StepPolynomials(times, coefficients)
