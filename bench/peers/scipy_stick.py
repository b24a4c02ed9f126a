"""SciPy's `solve_ivp` with events on Den Hartog's oscillator.

    python bench/peers/scipy_stick.py --repeat 2

Slip forwards, slip backwards and stick are integrated one after the other; what ends each is a
terminal event, and plain Python decides what follows. Each method is run at the tolerances that it
needs for ten digits, and at those with which most people would leave it.
"""

import math
import time
from itertools import product
from typing import Any

import record
from stick import FREQUENCY, FRICTION, PERIOD

PERIODS = 5
METHODS = ("RK45", "DOP853", "Radau", "LSODA")
TOLERANCES = (1e-6, 1e-10)
"""rtol; atol is a hundredth of it."""
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


def simulate(solve: Any, method: str, rtol: float) -> list[float]:
    """Return the last state from rest at zero."""
    given = {"method": method, "rtol": rtol, "atol": rtol / 100}
    t, y, sign = 0.0, [0.0, 0.0], 1.0
    sticks = abs(pull(t, y[0])) <= FRICTION
    while t < SPAN:
        if sticks:
            found = solve(rest, (t, SPAN), y, events=yields, max_step=1.0, **given)
        else:
            found = solve(slip, (t, SPAN), y, events=stops, args=(sign,), **given)
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
    seconds: dict[str, list[float]] = {}
    used: dict[str, list[float]] = {}
    final: dict[str, list[float]] = {}
    for method, rtol in product(METHODS, TOLERANCES):
        task = f"{method} at {rtol:g}"
        seconds[task], used[task] = [], []
        for _ in range(options.repeat):
            begun, clock = time.perf_counter(), time.process_time()
            final[task] = simulate(solve_ivp, method, rtol)
            seconds[task].append(time.perf_counter() - begun)
            used[task].append(time.process_time() - clock)
    record.Record(
        peer="SciPy",
        version=scipy.__version__,
        settings={"periods": PERIODS, "rtol": TOLERANCES},
        build_seconds=0.0,
        seconds=seconds,
        processor_seconds=used,
        final_state=final,
    ).print()


if __name__ == "__main__":
    main()
