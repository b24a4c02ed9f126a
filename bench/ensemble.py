"""Two hundred responses with random parameters in one call, and how far they can be trusted.

    OMP_NUM_THREADS=1 python bench/ensemble.py --cases 200

Plate speed from 0.4 to 1.2 m/s, friction coefficient from 0.2 to 0.6 and direction from 25 to 70
degrees, all special points over the amplitude Nd of the normal force, f = 12.5 Hz. The special
points are held against their own checks, by a method that shares nothing with continuation.
"""

import argparse
import json
import os
import time

import numpy as np

import machine
import slipfold as sf
from slipfold.version import package_version

SPAN = (0.0, 0.98)
MODEL = sf.SlidingOscillator(f=12.5)


def random_cases(count: int) -> dict[str, np.ndarray]:
    """Values of the parameters, the same every time."""
    random = np.random.default_rng(0)
    return {
        "Vd": random.uniform(0.4, 1.2, count),
        "mu": random.uniform(0.2, 0.6, count),
        "alpha": np.radians(random.uniform(25, 70, count)),
    }


def main() -> None:
    """Compute, compare, print the record."""
    parser = argparse.ArgumentParser(description="responses with random parameters")
    parser.add_argument("--cases", type=int, default=200, help="cases (default 200)")
    parser.add_argument("--repeat", type=int, default=3, help="timed repeats (default 3)")
    options = parser.parse_args()
    sf.response(MODEL, "Nd", SPAN)  # compiles, or loads what is compiled
    seconds, used = [], []
    for _ in range(options.repeat):
        begun, before = time.perf_counter(), time.process_time()
        found = sf.responses(MODEL, "Nd", SPAN, over=random_cases(options.cases))
        seconds.append(time.perf_counter() - begun)
        used.append(time.process_time() - before)
    diagrams = [diagram for diagram in found if diagram is not None]
    uncertain = [item.point.uncertainty for item in found.special]
    record = {
        "version": package_version(),
        "machine": machine.description(),
        "threads": os.environ.get("OMP_NUM_THREADS", "as many as there are cores"),
        "cases": options.cases,
        "failures": len(found.failures),
        "special": len(found.special),
        "agree": sum(diagram.checked.agree for diagram in diagrams),
        "largest_uncertainty": max(uncertain),
        "seconds": {"warm": seconds},
        "processor_seconds": {"warm": used},
    }
    print(json.dumps(record))


if __name__ == "__main__":
    main()
