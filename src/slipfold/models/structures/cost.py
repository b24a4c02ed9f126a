"""The cost of a structure's flow: an estimate before it is compiled."""

from __future__ import annotations

import math
from dataclasses import dataclass

from slipfold.models.model import COLUMNS, propagated_together

# Fitted to chains of 1 to 40 masses with a cubic spring and a friction contact, tridiagonal and
# full matrices, on a core of an AMD EPYC at about 3 GHz: seconds, and seconds a product of two
# series of order 16 in eight lanes; products of the formula of a component, by direction.
COMPILE_BASE, COMPILE_PRODUCT = 1.0, 6e-5
RUN_BASE, RUN_PRODUCT = 5e-5, 1e-7
COMPONENT = 50

STEPS_A_CYCLE = 7.0
"""Taylor steps of order 16 in an oscillation: the step of exp(i w t) at 1e-13 is 0.9/w."""

MANY_STEPS = 3000
"""Steps in a period beyond which the highest modes are what takes time: chains of eighty masses
take a tenth of them, a beam of three finite elements twice as many."""


@dataclass(frozen=True)
class Cost:
    """Estimated cost of the flow with its first derivatives, on one core.

    It is right to a factor of two or three: processors differ, and so do trajectories.

    Parameters
    ----------
    states
        Number of states n.
    equations
        Number of differential equations that are compiled: states, and their derivatives with
        respect to the start and one parameter; ``n (n + 2)`` up to 24 states, ``7 n`` of larger
        structures, whose derivatives are integrated a few at a time.
    products
        Number of products in them.
    runs
        How often the larger part of them is integrated for all derivatives.
    steps
        Steps of the integration in a period of the forcing, set by the highest frequency.
    compile_seconds
        Time to compile the flow, once: it is stored on disk.
    period_seconds
        Time to integrate eight segments or orbits over one period of the forcing.

    Examples
    --------
    >>> print(estimate_cost(states=20, linear=66, coupled=4, directions=2, cycles=3.2))
    20 states: 440 differential equations with 2.5e+03 products; compiled once in about 1.2 s,
    then about 5.9 ms a period
    """

    states: int
    equations: int
    products: int
    runs: int
    steps: int
    compile_seconds: float
    period_seconds: float

    def __str__(self) -> str:
        """Say it in a sentence."""
        apart = f", integrated in {self.runs} groups" if self.runs > 1 else ""
        text = (
            f"{self.states} states: {self.equations} differential equations with "
            f"{self.products:.2g} products{apart}; compiled once in about "
            f"{self.compile_seconds:.2g} s, then about {self.period_seconds * 1e3:.2g} ms a period"
        )
        if self.steps > MANY_STEPS:
            text += (
                f" of {self.steps} steps, so fast is the highest mode; "
                "reduction=CraigBampton(boundary, up_to=...) leaves such modes out, and "
                "reduction_report says at what price"
            )
        return text


def estimate_cost(states: int, linear: int, coupled: int, directions: int, cycles: float) -> Cost:
    """Estimate the cost of a flow from the size of its equations."""
    # Each product of a rate comes back in the derivative of that rate along each perturbation.
    each, fixed = states + 1.2 * linear + 3 * coupled, COMPONENT * directions
    if propagated_together(states):
        equations, runs = states * (states + 2), 1
        compiled = work = round((states + 2) * each) + fixed
    else:
        equations, runs = states * (COLUMNS + 3), math.ceil(states / COLUMNS)
        group = round((1 + COLUMNS) * each) + fixed
        # A change of the period comes into every rate: eight more products for each.
        change = round(2 * each + 8 * states) + fixed
        compiled, work = group + change, runs * group + change
    steps = 1 + round(STEPS_A_CYCLE * cycles)
    compile_seconds = COMPILE_BASE + COMPILE_PRODUCT * compiled
    period_seconds = RUN_BASE + RUN_PRODUCT * work * steps
    return Cost(states, equations, compiled, runs, steps, compile_seconds, period_seconds)
