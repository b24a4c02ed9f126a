"""slipfold on the locus of period doubling in f and Nd, printed as the peers print theirs.

    OMP_NUM_THREADS=1 python bench/ours_locus.py --repeat 5

The PD of the force response at 12.5 Hz, then its locus down to 11.5 and up to 13.5 Hz, both in one
call, warm. The response that gives the PD is not timed, nor is AUTO-07p's run to its
eigenfunction; what slipfold needs to start the locus is part of the call, as are the normal form at
every point and the points of codimension two (`named`).

`solver_seconds` is processor time, which is what AUTO-07p's own clock counts. `landed` is not
timed: the locus corrected onto the frequencies of the reference. `build_seconds` is the first call
in this process: loading compiled flows from the cache, or compiling them.
"""

import time
from statistics import median

import numpy as np

import reference
import slipfold as sf
from peers import record
from slipfold.bifurcations.loci.follow import follow_loci
from slipfold.bifurcations.loci.locus_equations import LocusEquations
from slipfold.continuation.newton import correct
from slipfold.orbits.kinds import ForcedOrbits
from slipfold.version import package_version

FREQUENCY = 12.5
PLANE = ("f", "Nd")
WINDOW = ((11.5, 13.5), (0.0, 0.98))
WIDTHS = (2.0, 0.98)


def doubling() -> sf.SpecialPoint:
    """The PD of the force response."""
    alone = sf.Settings(largest_period=1)
    diagram = sf.response(
        sf.SlidingOscillator(), vary="Nd", span=(0, 0.98), f=FREQUENCY, settings=alone
    )
    (point,) = (point for point in diagram.branches[0].special if point.type == "PD")
    return point


def follow(point: sf.SpecialPoint) -> sf.Locus:
    """The locus in both directions, without those that start on it."""
    (locus,) = follow_loci([point], PLANE, WINDOW, switch=False)
    return locus


def timed(point: sf.SpecialPoint) -> tuple[sf.Locus, float, float]:
    """The locus, and the wall and processor time in seconds it took."""
    begun, used = time.perf_counter(), time.process_time()
    locus = follow(point)
    return locus, time.perf_counter() - begun, time.process_time() - used


def land(locus: sf.Locus, frequency: float) -> tuple[float, float]:
    """The point (f, Nd) of the locus at a frequency, corrected from the nearest one computed."""
    vary = dict(zip(locus.vary, WIDTHS, strict=True))
    orbits = ForcedOrbits(locus.model, vary, locus.period)
    problem = LocusEquations(orbits, locus.type)
    nearest = int(np.abs(locus.values[:, 0] - frequency).argmin())
    values = np.array([frequency, float(locus.values[nearest, 1])])
    guess = orbits.join(locus.nodes[nearest], values)
    row = np.zeros_like(guess)
    row[-2] = 1.0
    corrected = correct(problem, guess, row)
    if not corrected.converged:
        record.leave(record.FAILED, f"the locus at f = {frequency} Hz: {corrected.failure}.")
    first, second = problem.place(corrected.z)
    return first, second


def main() -> None:
    """Warm up, time, land, print the record."""
    options = record.arguments("slipfold on the locus of period doubling")
    point = doubling()
    locus, build, _ = timed(point)
    clocks = [timed(point)[1:] for _ in range(options.repeat)]
    used = [processor for _, processor in clocks]
    record.Record(
        peer="slipfold",
        version=package_version(),
        settings={"name": "defaults"},
        build_seconds=build,
        seconds={"locus": [wall for wall, _ in clocks]},
        solver_seconds={"locus": used},
        seconds_per_point={"locus": median(used) / len(locus)},
        points={"locus": len(locus)},
        reached={"down": float(locus.values[0, 0]), "up": float(locus.values[-1, 0])},
        locus=locus.values.tolist(),
        landed=[land(locus, frequency) for frequency in reference.LOCUS],
        named=[(found.name, *found.values) for found in locus.special],
    ).print()


if __name__ == "__main__":
    main()
