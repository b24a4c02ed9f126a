"""What a linearized orbit costs, and its compilation, by the number of degrees of freedom.

    OMP_NUM_THREADS=1 SLIPFOLD_CACHE_DIR=$(mktemp -d) python bench/size.py --repeat 5

A chain of 1 to 20 masses with a cubic spring and a friction contact at its end: the flow over one
forcing period with its derivatives with respect to the start and one parameter, eight segments
side by side. Then the whole branch of cycles of a beam on a belt from its Hopf point, by the number
of its elements: its highest modes are ever stiffer. Processor time, compiling apart.
"""

import argparse
import json
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import machine
import slipfold as sf
from ours_beam import structure
from slipfold.flow.flow import flow_of
from slipfold.version import package_version

SIZES = (1, 2, 3, 5, 7, 10, 15, 20)
SEGMENTS = 8

BEAMS = (3, 5, 8, 15)


def chain(size: int) -> sf.Structure:
    """Masses between springs, a cubic spring and a contact at one end, a force at the other."""
    stiffness = 100.0 * (2 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1))
    structure = sf.Structure(
        np.eye(size),
        sf.ProportionalDamping(0.1, 0.001),
        stiffness,
        elements=sf.CubicSpring(f"q{size}", k3=10.0),
        contacts=sf.FrictionContact(f"q{size}", sf.Stribeck(), load=2.0, Vd=1.0),
        forcing=sf.HarmonicForce("q1", F=2.0),
    )
    return structure.replace(f=0.6)


def used(work: Callable[[], Any]) -> float:
    """Processor seconds of a call."""
    begun = time.process_time()
    work()
    return time.process_time() - begun


def measure(size: int, repeat: int) -> dict[str, Any]:
    """Cost of one chain."""
    model = chain(size)
    flow = flow_of(model)
    constants = flow.constants(model.vector)
    edges = np.arange(SEGMENTS + 1) / SEGMENTS
    states = np.zeros((SEGMENTS, flow.dimension))
    along = constants.rates[:, [model.parameter_index("f")]]

    def orbit() -> None:
        flow.linearize(states, edges[:-1], edges[1:], constants, along)

    first = used(orbit)
    runs = [used(orbit) for _ in range(repeat)]
    return {
        "size": size,
        "states": flow.dimension,
        "compile_seconds": first - min(runs),
        "seconds": runs,
    }


def squeal(elements: int) -> dict[str, Any]:
    """Cost of a beam's branch."""
    model = structure(elements)
    found = [0]

    def branch() -> None:
        cycles = sf.response(model, "Vd", (1.25, 1.15), settings=sf.Settings(largest_period=1))
        found[0] = len(cycles.branches[1])

    first = used(branch)
    again = used(branch)
    return {
        "elements": elements,
        "points": found[0],
        "compile_seconds": first - again,
        "seconds": again,
    }


def main() -> None:
    """Measure, print the record."""
    parser = argparse.ArgumentParser(description="the cost of structures by their size")
    parser.add_argument("--repeat", type=int, default=5, help="timed repeats (default 5)")
    options = parser.parse_args()
    record = {
        "version": package_version(),
        "machine": machine.description(),
        "sizes": [measure(size, options.repeat) for size in SIZES],
        "beams": [squeal(elements) for elements in BEAMS],
    }
    print(json.dumps(record))


if __name__ == "__main__":
    main()
