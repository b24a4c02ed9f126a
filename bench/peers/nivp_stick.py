"""solve-nivp on Den Hartog's oscillator.

    python bench/peers/nivp_stick.py --repeat 1

Its composite method, of second order, with adaptive steps and a semismooth Newton method, Coulomb's
friction as a projection. At rtol 1e-6 two periods take ten times as long and are right to 4e-6.
"""

import math
import time

import record
from stick import FREQUENCY, FRICTION, PERIOD

PERIODS = 1
"""It takes most of a minute for each."""
TOLERANCES = {"rtol": 1e-4, "atol": 1e-6}
SPAN = PERIODS * PERIOD


def main() -> None:
    """Integrate, print the record."""
    options = record.arguments("solve-nivp on Den Hartog's oscillator")
    try:
        import numpy as np
        from solve_nivp import solve_ivp_ns
    except ImportError:
        record.leave(record.MISSING, "solve-nivp is not installed: pip install solve-nivp.")
    from importlib.metadata import version

    def rates(t, y):  # type: ignore[no-untyped-def]
        v, x = y
        return np.array([math.cos(FREQUENCY * t) - x, v])

    def limits(y, t=None, Fk_val=None):  # type: ignore[no-untyped-def]
        return np.array([FRICTION, 0.0])

    seconds, used = [], []
    for _ in range(options.repeat):
        begun, clock = time.perf_counter(), time.process_time()
        _, states, *_ = solve_ivp_ns(
            fun=rates,
            t_span=(0.0, SPAN),
            y0=np.zeros(2),
            method="composite",
            projection="coulomb",
            solver="semismooth_newton",
            projection_opts={
                "con_force_func": limits,
                "rhok": np.array([1.0, 1.0]),
                "constraint_indices": [0],
                "jac_func": lambda y, t=None, Fk_val=None: np.zeros((2, 2)),
            },
            solver_opts={"tol": 1e-10, "max_iter": 50},
            adaptive=True,
            h0=1e-3,
            **TOLERANCES,
        )
        seconds.append(time.perf_counter() - begun)
        used.append(time.process_time() - clock)
    v, x = states[-1].tolist()
    record.Record(
        peer="solve-nivp",
        version=version("solve-nivp"),
        settings={"periods": PERIODS, **TOLERANCES},
        build_seconds=0.0,
        seconds={"composite": seconds},
        processor_seconds={"composite": used},
        final_state={"composite": [x, v]},
    ).print()


if __name__ == "__main__":
    main()
