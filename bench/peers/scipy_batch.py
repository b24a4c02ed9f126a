"""SciPy on many motions, one after the other: eight of the starts.

    python bench/peers/scipy_batch.py --repeat 1

DOP853 at rtol 1e-9 and atol 1e-9, its right-hand side in plain Python.
"""

import math
import time

import numpy as np
import oscillator
import record
from batch import AMPLITUDE, COMPARED, PERIODS, compared, starts


def forced(phase, state):
    """Scaled rates."""
    return oscillator.rates(*state.tolist(), math.cos(oscillator.TAU * phase), AMPLITUDE)


def main() -> None:
    """Follow some of the motions, print the record."""
    options = record.arguments("SciPy on many motions")
    try:
        import scipy
        from scipy.integrate import solve_ivp
    except ImportError:
        record.leave(record.MISSING, "SciPy is not installed: pip install scipy.")
    seconds, used = [], []
    for _ in range(options.repeat):
        begun, before = time.perf_counter(), time.process_time()
        ends = [
            solve_ivp(
                forced, (0.0, PERIODS), start, method="DOP853", t_eval=np.arange(1.0, PERIODS + 1),
                rtol=1e-9, atol=1e-9,
            ).y[:2, -1]
            for start in starts(COMPARED)
        ]  # fmt: skip
        seconds.append(time.perf_counter() - begun)
        used.append(time.process_time() - before)
    record.Record(
        peer="SciPy",
        version=scipy.__version__,
        settings={"motions": COMPARED, "periods": PERIODS},
        build_seconds=0.0,
        seconds={"DOP853": seconds},
        processor_seconds={"DOP853": used},
        points={"DOP853": COMPARED * PERIODS},
        final_state={"DOP853": compared(np.array(ends))},
    ).print()


if __name__ == "__main__":
    main()
