"""SciPy's `solve_ivp` with events on Den Hartog's oscillator.

    python bench/peers/scipy_stick.py --repeat 2

Slip forwards, slip backwards and stick are integrated one after the other; what ends each is a
terminal event, and plain Python decides what follows. DOP853 and LSODA at rtol 1e-10, atol 1e-12.
"""

import math
import time
from typing import Any

import record
from stick import FREQUENCY, FRICTION, PERIOD

PERIODS = 50
METHODS = ("DOP853", "LSODA")
TOLERANCES = {"rtol": 1e-10, "atol": 1e-12}
SPAN = PERIODS * PERIOD


def pull(t: float, x: float) -> float:
    """What friction has to hold."""
    return math.cos(FREQUENCY * t) - x


def slip(t: float, y: Any, sign: float) -> tuple[float, float]:
    """Rates in slip."""
    x, v = y.tolist()
    return v, pull(t, x) - sign * FRICTION


def stops(t: float, y: Any, sign: float) -> float:
    """Zero where slip ends, falling."""
    return sign * y[1]


stops.terminal, stops.direction = True, -1  # type: ignore[attr-defined]


def rest(t: float, y: Any) -> tuple[float, float]:
    """Rates in stick."""
    return 0.0, 0.0


def yields(t: float, y: Any) -> float:
    """Zero where friction cannot hold any more, falling."""
    return FRICTION - abs(pull(t, float(y[0])))


yields.terminal, yields.direction = True, -1  # type: ignore[attr-defined]


def simulate(solve: Any, method: str) -> list[float]:
    """Return the last state from rest at zero."""
    t, y, sign = 0.0, [0.0, 0.0], 1.0
    sticks = abs(pull(t, y[0])) <= FRICTION
    while t < SPAN:
        if sticks:
            found = solve(
                rest, (t, SPAN), y, method=method, events=yields, max_step=1.0, **TOLERANCES
            )
        else:
            found = solve(
                slip, (t, SPAN), y, method=method, events=stops, args=(sign,), **TOLERANCES
            )
        if not found.success:
            record.leave(record.FAILED, f"SciPy's {method} stopped early: {found.message}")
        t, y = float(found.t[-1]), [float(found.y[0, -1]), float(found.y[1, -1])]
        if found.status == 1:
            y[1] = 0.0
            force = pull(t, y[0])
            sticks = not sticks and abs(force) <= FRICTION
            sign = math.copysign(1.0, force)
    return y


def main() -> None:
    """Integrate with each method, print the record."""
    options = record.arguments("SciPy's solve_ivp with events on Den Hartog's oscillator")
    try:
        import scipy
        from scipy.integrate import solve_ivp
    except ImportError:
        record.leave(record.MISSING, "SciPy is not installed: pip install scipy.")
    seconds: dict[str, list[float]] = {method: [] for method in METHODS}
    used: dict[str, list[float]] = {method: [] for method in METHODS}
    final: dict[str, list[float]] = {}
    for method in METHODS:
        for _ in range(options.repeat):
            begun, clock = time.perf_counter(), time.process_time()
            final[method] = simulate(solve_ivp, method)
            seconds[method].append(time.perf_counter() - begun)
            used[method].append(time.process_time() - clock)
    record.Record(
        peer="SciPy",
        version=scipy.__version__,
        settings={"periods": PERIODS, **TOLERANCES},
        build_seconds=0.0,
        seconds=seconds,
        processor_seconds=used,
        final_state=final,
    ).print()


if __name__ == "__main__":
    main()
