"""pyHarm on the strip of 20 degrees of freedom.

    python bench/peers/pyharm_structures.py --repeat 1

It has no friction that rises smoothly with velocity, so its elastic Coulomb element takes that
place, as stiff as the force would rise: its error against the other law is no error of pyHarm. Its
unknowns are condensed to the contact by a dense factorization of all harmonics together, which for
100 degrees of freedom takes seconds an iteration, and with 25 harmonics minutes a response. It
knows no stability.
"""

import logging
import os
import shutil
import sys
import tempfile
import time
import warnings
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import record

sys.path.insert(0, str(Path(__file__).parents[1]))

from strip import BAND, FORCE, FRICTION, strip

SIZE = 20

SETTINGS = {"name": "usual", "nh": 7, "nti": 128, "step": 0.005}
"""The step is that of 61 frequencies, over the lowest."""


def given() -> dict[str, Any]:
    """pyHarm's input, with time in units of the lowest mode: its arclength needs like unknowns."""
    made = strip(SIZE)
    unit = made.rise / made.lowest
    force = made.lowest**2 * unit
    stiffness = made.stiffness.toarray() / made.lowest**2
    mass = made.mass.toarray()
    return {
        "analysis": {
            "response": {
                "study": "frf",
                "puls_inf": BAND[0],
                "puls_sup": BAND[1],
                "ds0": SETTINGS["step"],
                "ds_max": SETTINGS["step"],
                "ds_min": 1e-8,
                "solver": "NewtonRaphson",
                "predictor": "previous",
                "corrector": "nocontinuation",
                "reductors": [{"type": "NLdofs"}],
                "verbose": False,
            }
        },
        "system": {"type": "Base", "nh": SETTINGS["nh"], "nti": SETTINGS["nti"]},
        "substructures": {
            "strip": {
                "ndofs": SIZE,
                "matrix": {
                    "M": mass,
                    "C": made.beta * made.lowest * stiffness,
                    "K": stiffness,
                    "G": np.zeros((SIZE, SIZE)),
                },
            }
        },
        "connectors": {
            "friction": {
                "type": "Jenkins",
                "connect": {"strip": [0]},
                "dirs": [made.tip],
                "mu": FRICTION,
                "N0": FORCE / force,
                "k": FRICTION * FORCE / force,
            },
            "force": {
                "type": "CosinusForcing",
                "connect": {"strip": [0]},
                "dirs": [made.tip],
                "amp": FORCE / force,
            },
        },
    }


def main() -> None:
    """Time the response, print the record."""
    options = record.arguments("pyHarm on the strip")
    folder = tempfile.mkdtemp()  # pyHarm leaves a folder where it is imported
    os.chdir(folder)
    try:
        from pyHarm.Maestro import Maestro
    except ImportError:
        record.leave(record.MISSING, "pyHarm is not installed: pip install pyharm-os.")
    logging.disable(logging.CRITICAL)
    warnings.simplefilter("ignore")

    def follow() -> tuple[int, float, float]:
        task = Maestro(given())
        begun, used = time.perf_counter(), time.process_time()
        task.operate()
        took = time.perf_counter() - begun, time.process_time() - used
        solutions = [item for item in task.nls["response"].SolList if item.flag_accepted]
        return len(solutions), *took

    points, built, _ = follow()
    times = [follow()[1:] for _ in range(options.repeat)]
    record.Record(
        peer="pyHarm",
        version=f"pyharm-os {version('pyharm-os')}",
        settings=SETTINGS,
        build_seconds=built,
        seconds={str(SIZE): [wall for wall, _ in times]},
        processor_seconds={str(SIZE): [used for _, used in times]},
        points={str(SIZE): points},
    ).print()
    shutil.rmtree(folder)


if __name__ == "__main__":
    main()
