"""Tori of the base case, and which response wins at 12.2 Hz: seconds a torus, seconds a picture.

    python bench/many_cases/after_the_hopf.py --repeat 3 --points 200

Tori are those born at the Neimark-Sacker points of the force response at 12.5 Hz, one thread; each
is a circle invariant to 1e-8 with its rotation number, its stability and its surface. The picture
has points by points starts over x and y at Nd = 0.1 N, on all cores.
"""

import argparse
import json
import os
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

import slipfold as sf
from slipfold.bifurcations.tori.follow import tori_of

SPAN = (0.0, 0.2)
PLANE = {"x": (-0.5, 0.5), "y": (-0.5, 0.5)}


def timed(work, repeat):
    """Seconds of some repeats after a first one, in which code is compiled, and what was found."""
    found, times = work(), []
    for _ in range(repeat):
        begun = time.perf_counter()
        work()
        times.append(time.perf_counter() - begun)
    return times, found


def main() -> None:
    """Follow tori, draw basins, print the record."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=3, help="timed repeats (default 3)")
    parser.add_argument("--points", type=int, default=200, help="a side (default 200)")
    options = parser.parse_args()
    response = sf.response(sf.SlidingOscillator(f=12.5), vary="Nd", span=SPAN)
    tori_times, tori = timed(
        lambda: tori_of(response.branches, SPAN, sf.Settings()), options.repeat
    )
    oscillator = sf.SlidingOscillator(f=12.2, Nd=0.1)
    basin_times, basins = timed(
        lambda: sf.basins(oscillator, PLANE, points=options.points), options.repeat
    )
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    print(
        json.dumps(
            {
                "tori": {
                    "points": sum(len(branch.parameter) for branch in tori),
                    "branches": len(tori),
                },
                "basins": {
                    "points": options.points,
                    "cores": cores,
                    "periods": sorted(item.period for item in basins),
                },
                "seconds": {"tori": tori_times, "basins": basin_times},
            }
        )
    )


if __name__ == "__main__":
    main()
