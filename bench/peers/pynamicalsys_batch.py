"""pynamicalsys (numba) on many motions at once.

    python bench/peers/pynamicalsys_batch.py --repeat 3

Its stroboscopic map of all starts in one call, one thread: the adaptive method of order 5 at
tolerances of 1e-9, and the one of order 4 with 200 steps a period. The right-hand side is compiled,
with constants folded by hand. `build_seconds` is the first call of the first. Between the step that
passes a sampling time and the sample before it (not the step before it) the map interpolates
linearly, which is nearly all of its error.
"""

import math
import os
import time

os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import numpy as np
import oscillator as o
import record
from batch import AMPLITUDE, COUNT, PERIODS, compared, starts

METHODS = {
    "rk45": {"atol": 1e-9, "rtol": 1e-9},
    "rk4": {"time_step": 1 / 200},
}

TURN, RATE = o.TAU, o.RATE
PLATE_X, PLATE_Y = o.PLATE
STEADY, PULSING = o.FRICTION * o.STEADY_LOAD, o.FRICTION * AMPLITUDE
PULL = o.SPRING * o.LENGTH
DAMPING_X, DAMPING_Y = o.HORIZONTAL.damping * RATE, o.VERTICAL.damping * RATE
STIFFNESS_X, STIFFNESS_Y = o.HORIZONTAL.stiffness * o.LENGTH, o.VERTICAL.stiffness * o.LENGTH
GAIN_X, GAIN_Y = 1 / o.HORIZONTAL.inertia, 1 / o.VERTICAL.inertia


def forced(phase, state, parameters):
    """Scaled rates, as numba compiles them.

    In functions of arrays: for its first step of many starts it is called with all of them.
    """
    rates = np.zeros_like(state)
    x, y, vx, vy = state[0], state[1], state[2], state[3]
    slip_x, slip_y = PLATE_X - RATE * vx, PLATE_Y - RATE * vy
    load = STEADY + PULSING * np.cos(TURN * phase)
    grip = load / np.sqrt(slip_x * slip_x + slip_y * slip_y)
    height = 1 + y
    pull = PULL * (1 - 1 / np.sqrt(height * height + x * x))
    rates[0], rates[1] = TURN * vx, TURN * vy
    rates[2] = GAIN_X * (grip * slip_x - DAMPING_X * vx - STIFFNESS_X * x - pull * x)
    rates[3] = GAIN_Y * (grip * slip_y - DAMPING_Y * vy - STIFFNESS_Y * y - pull * height)
    return rates


def main() -> None:
    """Follow all motions with each method, print the record."""
    options = record.arguments("pynamicalsys on many motions at once")
    try:
        from importlib.metadata import version

        from numba import njit
        from pynamicalsys import ContinuousDynamicalSystem
    except ImportError:
        record.leave(record.MISSING, "pynamicalsys is not installed: pip install pynamicalsys.")
    system = ContinuousDynamicalSystem(
        equations_of_motion=njit(forced), system_dimension=4, number_of_parameters=1
    )
    given = starts()
    seconds, used, final = {}, {}, {}
    built = math.nan
    for method, settings in METHODS.items():
        system.integrator(method, **settings)
        begun = time.perf_counter()
        system.stroboscopic_map(given[:4], 2, 1.0, parameters=[0.0])
        built = time.perf_counter() - begun if math.isnan(built) else built
        seconds[method], used[method] = [], []
        for _ in range(options.repeat):
            begun, before = time.perf_counter(), time.process_time()
            points = system.stroboscopic_map(given, PERIODS, 1.0, parameters=[0.0])
            seconds[method].append(time.perf_counter() - begun)
            used[method].append(time.process_time() - before)
        if round(float(points[0, -1, 0]), 6) != PERIODS:
            record.leave(record.FAILED, f"pynamicalsys ends at {points[0, -1, 0]}, not {PERIODS}")
        final[method] = compared(points[:, -1, 1:3])
    record.Record(
        peer="pynamicalsys",
        version=version("pynamicalsys"),
        settings={"motions": COUNT, "periods": PERIODS},
        build_seconds=built,
        seconds=seconds,
        processor_seconds=used,
        points=dict.fromkeys(METHODS, COUNT * PERIODS),
        final_state=final,
    ).print()


if __name__ == "__main__":
    main()
