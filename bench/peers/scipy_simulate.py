"""SciPy's integrators on the sliding oscillator: 1000 forcing periods from rest.

    python bench/peers/scipy_simulate.py --repeat 3

Base case at f = 12.5 Hz and Nd = 0.1 N, zero initial conditions, DOP853 and LSODA at rtol 1e-10 and
atol 1e-12. The right-hand side is plain Python on floats, the usual way to call `solve_ivp`. The
final state is (x/L, y/L, and their rates in 1/s) at an instant when N(t) is largest; `points`
counts evaluations of the right-hand side. The state depends on the tolerance: DOP853 at rtol 1e-12,
atol 1e-14 ends at (0.1031168, -0.0678557, 1.13755, 11.7717), so these runs are right to about 1e-4
in x/L.
"""

import math
import time
from typing import Any

import oscillator
import record

METHODS = ("DOP853", "LSODA")
SETTINGS = {"periods": 1000, "f": oscillator.FREQUENCY, "Nd": 0.1, "rtol": 1e-10, "atol": 1e-12}


def forced(phase: float, state: Any) -> tuple[float, float, float, float]:
    """Scaled rates at a time counted in forcing periods."""
    x, y, vx, vy = state.tolist()
    return oscillator.rates(x, y, vx, vy, math.cos(oscillator.TAU * phase), SETTINGS["Nd"])


def main() -> None:
    """Integrate with each method, print the record."""
    options = record.arguments("SciPy's solve_ivp on the sliding oscillator")
    try:
        import scipy
        from scipy.integrate import solve_ivp
    except ImportError:
        record.leave(record.MISSING, "SciPy is not installed: pip install scipy.")
    seconds: dict[str, list[float]] = {method: [] for method in METHODS}
    final: dict[str, list[float]] = {}
    points: dict[str, int] = {}
    for method in METHODS:
        for _ in range(options.repeat):
            begun = time.perf_counter()
            solution = solve_ivp(
                forced,
                (0.0, SETTINGS["periods"]),
                [0.0] * 4,
                method=method,
                t_eval=[SETTINGS["periods"]],
                rtol=SETTINGS["rtol"],
                atol=SETTINGS["atol"],
            )
            seconds[method].append(time.perf_counter() - begun)
        if not solution.success:
            record.leave(record.FAILED, f"SciPy's {method} stopped early: {solution.message}")
        x, y, vx, vy = solution.y[:, -1].tolist()
        unit = oscillator.TAU * oscillator.FREQUENCY
        final[method] = [x, y, unit * vx, unit * vy]
        points[method] = solution.nfev
    record.Record(
        peer="SciPy",
        version=scipy.__version__,
        settings=SETTINGS,
        build_seconds=0.0,
        seconds=seconds,
        points=points,
        final_state=final,
    ).print()


if __name__ == "__main__":
    main()
