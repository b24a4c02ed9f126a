"""Three systems that nothing forces: canards of a neuron, van der Pol's relaxation, a beam.

Only arithmetic is used, so the arguments may be floats or the symbols of a tracer.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import beam

HARMONICS = 20
"""Of the first cycle: enough for the Newton iteration of any program."""


class Oscillator(NamedTuple):
    """One system.

    Its branch of cycles begins at a Hopf point on the way through `span`, or, `settled`, at the
    cycle there is at the beginning of it. What has no `formulas` is a
    structure. `specials` are the bifurcations of the cycles, `last` is
    the duration of the cycle at the end.
    """

    title: str
    parameter: str
    span: tuple[float, float]
    settled: bool
    start: tuple[float, ...]
    rates: Callable[[Sequence[Any], Any], list[Any]]
    formulas: dict[str, str]
    specials: tuple[tuple[str, float], ...]
    last: float


def fitzhugh_nagumo(q: Sequence[Any], current: Any) -> list[Any]:
    """The neuron at a ratio of times of 0.04."""
    return [
        q[0] - q[0] * q[0] * q[0] / 3 - q[1] + current,
        0.04 * (q[0] + 0.7 - 0.8 * q[1]),
    ]


def van_der_pol(q: Sequence[Any], mu: Any) -> list[Any]:
    """The oscillator without forcing."""
    return [q[1], mu * (1 - q[0] * q[0]) * q[1] - q[0]]


OSCILLATORS = {
    "canards": Oscillator(
        title="FitzHugh and Nagumo's neuron through its canards",
        parameter="I",
        span=(0.28, 0.4),
        settled=False,
        start=(-1.009264457, -0.3865805714),
        rates=fitzhugh_nagumo,
        formulas={"v": "v - v^3/3 - w + I", "w": "0.04*(v + 0.7 - 0.8*w)"},
        specials=(("LP", 0.307916307909525),),
        last=72.5812341,
    ),
    "relaxation": Oscillator(
        title="van der Pol's oscillator to mu = 100",
        parameter="mu",
        span=(1.0, 100.0),
        settled=True,
        start=(2.0, 0.0),
        rates=van_der_pol,
        formulas={"x": "v", "v": "mu*(1 - x^2)*v - x"},
        specials=(),
        last=162.837071092,
    ),
    "beam": Oscillator(
        title="a beam of fifteen elements on a belt",
        parameter="Vd",
        span=(1.15, 1.25),
        settled=False,
        start=beam.rest(1.15),
        rates=beam.rates,
        formulas={},
        specials=(),
        last=0.0538589895863,
    ),
}
"""The fold is where shooting and collocation agree, 2e-14 apart; durations are Radau's method's,
and of the beam those of a balance of 24 harmonics with the answer of its tip."""


@lru_cache
def first_cycle(name: str) -> tuple[NDArray[np.complex128], float]:
    """Fourier coefficients of the cycle where the span begins, and its duration, by SciPy."""
    from scipy.integrate import solve_ivp

    oscillator = OSCILLATORS[name]

    def rhs(_: float, q: NDArray[np.float64]) -> list[Any]:
        return oscillator.rates(q, oscillator.span[0])

    def rises(_: float, q: NDArray[np.float64]) -> float:
        return float(q[0])

    rises.direction = 1.0  # type: ignore[attr-defined]
    accuracy = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-12}
    run = solve_ivp(rhs, (0, 200), oscillator.start, events=rises, **accuracy)
    before, last = run.t_events[0][-2:]
    grid = (last - before) * np.arange(128) / 128
    samples = solve_ivp(rhs, (0, grid[-1]), run.y_events[0][-1], t_eval=grid, **accuracy).y
    return np.fft.rfft(samples)[:, : HARMONICS + 1] / 128, float(last - before)


def errors(name: str, found: Sequence[tuple[str, float]]) -> list[float] | None:
    """Distances from the reference; None if a point is missing or invented."""
    expected = OSCILLATORS[name].specials
    if [kind for kind, _ in found] != [kind for kind, _ in expected]:
        return None
    return [abs(ours[1] - exact[1]) for ours, exact in zip(found, expected, strict=True)]
