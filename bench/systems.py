"""Three systems that all programs get: Duffing, forced van der Pol, a chain with a belt.

Rates are per forcing period, so that every orbit has period 1. Only arithmetic and `exp` are used,
so the arguments may be floats or the symbols of a tracer.
"""

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

TAU = 2 * math.pi

HARMONICS = 12
"""Of the first orbit: enough for the Newton iteration of any program."""


class System(NamedTuple):
    """One system.

    `rates(state, cosine, parameter, exp)` are the rates of change per second with the forcing's
    cosine; `period(parameter)` is the forcing period in seconds. `specials` are the bifurcations
    within `span` in the order in which a branch meets them; `settled` is the number of periods
    after which the motion from rest has died down.
    """

    title: str
    model: str
    parameter: str
    unit: str
    span: tuple[float, float]
    specials: tuple[tuple[str, float], ...]
    states: tuple[str, ...]
    rates: Callable[[Sequence[Any], Any, Any, Callable[[Any], Any]], list[Any]]
    period: Callable[[Any], Any]
    settled: int

    def per_period(
        self, state: Sequence[Any], cosine: Any, parameter: Any, exp: Callable[[Any], Any]
    ) -> list[Any]:
        """Rates of change per forcing period."""
        duration = self.period(parameter)
        return [duration * rate for rate in self.rates(state, cosine, parameter, exp)]


def duffing(q: Sequence[Any], cosine: Any, parameter: Any, exp: Any) -> list[Any]:
    """NLvib's example 01."""
    return [q[1], 0.18 * cosine - 0.05 * q[1] - q[0] - 0.1 * q[0] * q[0] * q[0]]


def van_der_pol(q: Sequence[Any], cosine: Any, parameter: Any, exp: Any) -> list[Any]:
    """The forced oscillator with e = 0.2 and a force of 0.3."""
    return [q[1], 0.3 * cosine + 0.2 * (1 - q[0] * q[0]) * q[1] - q[0]]


MASSES = 10


def chain(q: Sequence[Any], cosine: Any, parameter: Any, exp: Any) -> list[Any]:
    """Built-in model `chain` of slipfold: `slipfold models --show chain`."""
    u, v = q[:MASSES], q[MASSES : 2 * MASSES]
    force = [-0.1 * v[i] for i in range(MASSES)]
    for i in range(MASSES):
        before = u[i] - u[i - 1] if i else u[0]
        speed = v[i] - v[i - 1] if i else v[0]
        pull = 100 * before + 0.2 * speed
        force[i] = force[i] - pull
        if i:
            force[i - 1] = force[i - 1] + pull
    last = MASSES - 1
    slip = 3 - v[last]
    friction = (10 + cosine) * (0.3 + 0.1 * exp(-slip / 0.5))
    force[last] = force[last] + friction - 20 * u[last] * u[last] * u[last] + 0.8 * cosine
    return [*v, *force]


SYSTEMS = {
    "duffing": System(
        title="Duffing's frequency response",
        model="duffing",
        parameter="W",
        unit="rad/s",
        span=(0.8, 1.6),
        specials=(("LP", 1.269601955546), ("LP", 1.115700251771)),
        states=("q", "v"),
        rates=duffing,
        period=lambda W: TAU / W,
        settled=200,
    ),
    "vanderpol": System(
        title="forced van der Pol oscillator",
        model="vanderpol",
        parameter="w",
        unit="rad/s",
        span=(1.0, 1.2),
        specials=(("NS", 1.086728948108),),
        states=("q", "v"),
        rates=van_der_pol,
        period=lambda w: TAU / w,
        settled=200,
    ),
    "chain": System(
        title="chain of ten masses, friction contact at its end",
        model="chain",
        parameter="f",
        unit="Hz",
        span=(0.2, 0.4),
        specials=(("LP", 0.3068294382), ("LP", 0.2938135047)),
        states=(*(f"q{i}" for i in range(1, 11)), *(f"v{i}" for i in range(1, 11))),
        rates=chain,
        period=lambda f: 1 / f,
        settled=100,
    ),
}
"""Duffing's and van der Pol's points are those of the textbook page; the chain's two programs agree
on to the digits given."""


@lru_cache
def first_orbit(name: str) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """State at phase 0 and Fourier coefficients of the orbit where the branch begins, by SciPy."""
    from scipy.integrate import solve_ivp

    system = SYSTEMS[name]
    value = system.span[0]

    def rhs(phase: float, state: NDArray[np.float64]) -> list[float]:
        return system.per_period(list(state), math.cos(TAU * phase), value, math.exp)

    def run(state: NDArray[np.float64], periods: int, **options: Any) -> Any:
        return solve_ivp(rhs, (0, periods), state, "DOP853", rtol=1e-10, atol=1e-12, **options)

    state = run(np.zeros(len(system.states)), system.settled).y[:, -1]
    samples = run(state, 1, t_eval=np.arange(64) / 64).y
    return state, np.fft.rfft(samples)[:, : HARMONICS + 1] / 64


def errors(name: str, found: Sequence[tuple[str, float]]) -> list[float] | None:
    """Distances from the reference; None if a point is missing or invented."""
    expected = SYSTEMS[name].specials
    if [kind for kind, _ in found] != [kind for kind, _ in expected]:
        return None
    return [abs(ours[1] - exact[1]) for ours, exact in zip(found, expected, strict=True)]
