"""slipfold on many motions at once, beside its peers.

    python bench/peers/slipfold_batch.py --repeat 3

One thread. `build_seconds` is the first call, in which steps are compiled or loaded. `reference` is
what Taylor's method ends at with errors of 1e-15 a step.
"""

import time

import numpy as np
import record
from batch import AMPLITUDE, COMPARED, COUNT, PERIODS, compared, starts

import slipfold as sf
from slipfold.flow.ensembles import stroboscopic_samples
from slipfold.flow.equations import build_equations
from slipfold.flow.flow import Flow
from slipfold.version import package_version


def main() -> None:
    """Follow all motions, print the record."""
    options = record.arguments("slipfold on many motions at once")
    model = sf.SlidingOscillator(f=12.5, Nd=AMPLITUDE)
    begun = time.perf_counter()
    stroboscopic_samples(model, starts(), None, 1, threads=1)
    built = time.perf_counter() - begun
    times = []
    for _ in range(options.repeat):
        begun, used = time.perf_counter(), time.process_time()
        points = stroboscopic_samples(model, starts(), None, PERIODS, threads=1)
        times.append((time.perf_counter() - begun, time.process_time() - used))
    exact, few = Flow(build_equations(model), tolerance=1e-15), starts(COMPARED)
    constants, zero = exact.constants_of(model), np.zeros(COMPARED)
    for _ in range(PERIODS):
        few = exact.advance(few, zero, zero + 1, constants)
    record.Record(
        peer="slipfold",
        version=package_version(),
        settings={"motions": COUNT, "periods": PERIODS},
        build_seconds=built,
        seconds={"sample": [wall for wall, _ in times]},
        processor_seconds={"sample": [used for _, used in times]},
        points={"sample": COUNT * PERIODS},
        final_state={
            "sample": compared(points.states[:, -1, :2]),
            "reference": compared(few[:, :2]),
        },
    ).print()


if __name__ == "__main__":
    main()
