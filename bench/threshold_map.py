"""Ten thousand thresholds on a grid of speed and direction, and how far they can be trusted.

    OMP_NUM_THREADS=1 python bench/threshold_map.py --size 100

For every plate speed from 0.3 to 1.2 m/s and direction from 20 to 80 degrees: the amplitude Nd of
the normal force at which the response of period 1 loses its stability by period doubling, f = 12.5
Hz. ``cold`` is the first map of this process, loading or compiling flows included; ``warm`` are
further maps. Points picked at random are compared with the response of each alone, and the time
that takes is given as well.
"""

import argparse
import json
import os
import time

import numpy as np

import grid
import machine
from slipfold import SlidingOscillator, ThresholdMap, threshold_map
from slipfold.bifurcations.branches.response import trace_response
from slipfold.bifurcations.branches.settings import Settings
from slipfold.version import package_version

SPAN = (0.0, grid.LAST)
MODEL = SlidingOscillator(f=12.5)
ALONE = Settings(largest_period=1)


def compute(size: int) -> tuple[ThresholdMap, float, float]:
    """The map, its wall time and its processor time in seconds."""
    over = dict(zip(("Vd", "alpha"), grid.places(size), strict=True))
    begun, used = time.perf_counter(), time.process_time()
    found = threshold_map(MODEL, "Nd", over=over, span=SPAN)
    return found, time.perf_counter() - begun, time.process_time() - used


def apart(value: float, expected: float) -> float:
    """Distance of two thresholds; none if both are missing, infinite if one is."""
    missing = np.isnan([value, expected])
    if missing.any():
        return 0.0 if missing.all() else np.inf
    return float(abs(value - expected))


def compare(found: ThresholdMap, count: int) -> tuple[float, float]:
    """Largest distance from responses followed one by one, and seconds that each of them takes."""
    begun, distances = time.perf_counter(), []
    for i, j in grid.picked(count, len(found.values)):
        model = found.model_at(i, j)
        (branch,) = trace_response(model, "Nd", SPAN, settings=ALONE)
        doublings = [point.value for point in branch.special if point.type == "PD"]
        expected = doublings[0] if doublings else np.nan
        distances.append(apart(found.values[i, j], expected))
    return max(distances), (time.perf_counter() - begun) / count


def main() -> None:
    """Compute, compare, print the record."""
    parser = argparse.ArgumentParser(description="a map of thresholds of the sliding oscillator")
    parser.add_argument("--size", type=int, default=grid.SIZE, help="points of an axis")
    parser.add_argument("--repeat", type=int, default=3, help="timed repeats (default 3)")
    parser.add_argument("--sample", type=int, default=20, help="points compared (default 20)")
    options = parser.parse_args()
    found, cold, cold_used = compute(options.size)
    runs = [compute(options.size)[1:] for _ in range(options.repeat)]
    difference, each = compare(found, options.sample)
    record = {
        "version": package_version(),
        "machine": machine.description(),
        "size": options.size,
        "thresholds": int(np.isfinite(found.values).sum()),
        "failures": found.failures,
        "followed": int(found.followed.sum()),
        "threads": os.environ.get("OMP_NUM_THREADS", "as many as there are cores"),
        "seconds": {"cold": [cold], "warm": [wall for wall, _ in runs]},
        "processor_seconds": {"cold": [cold_used], "warm": [used for _, used in runs]},
        "largest_residual": float(np.nanmax(found.residuals)),
        "sample": options.sample,
        "largest_difference": difference,
        "picked": [float(found.values[at]) for at in grid.picked(options.sample, options.size)],
        "response_ms_each": 1e3 * each,
    }
    print(json.dumps(record))


if __name__ == "__main__":
    main()
