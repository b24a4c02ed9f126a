"""pyHarm, harmonic balance, on Duffing's oscillator.

    python bench/peers/pyharm_systems.py --repeat 3 --system duffing [--settings usual|large|fine]

pyHarm follows the frequency response but knows no stability and locates no bifurcation: its folds
are where the frequency turns, here the top of the parabola through three points. It has no element
for the damping of van der Pol's oscillator, nor for friction on a moving belt.

`usual` has 7 harmonics and steps that show the fold to a few digits; `large` fewer harmonics and
longer steps; `fine` more and shorter ones. Compiling (numba) is `build_seconds`.
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

from systems import SYSTEMS

PRESETS: dict[str, dict[str, float]] = {
    "usual": {"nh": 7, "nti": 64, "ds": 0.1},
    "large": {"nh": 3, "nti": 32, "ds": 0.5},
    "fine": {"nh": 11, "nti": 128, "ds": 0.02},
}


def given(preset: dict[str, float]) -> dict[str, Any]:
    """pyHarm's input for Duffing's oscillator."""
    first, last = SYSTEMS["duffing"].span
    return {
        "analysis": {
            "response": {
                "study": "frf",
                "puls_inf": first,
                "puls_sup": last,
                "ds0": preset["ds"],
                "ds_max": preset["ds"],
                "ds_min": 1e-8,
                "solver": "NewtonRaphson",
                "corrector": "pseudo_arc_length",
                "verbose": False,
            }
        },
        "system": {"type": "Base", "nh": preset["nh"], "nti": preset["nti"]},
        "substructures": {
            "mass": {
                "ndofs": 1,
                "matrix": {
                    "M": np.eye(1),
                    "C": 0.05 * np.eye(1),
                    "K": np.eye(1),
                    "G": np.zeros((1, 1)),
                },
            }
        },
        "connectors": {
            "cubic": {"type": "CubicSpring", "connect": {"mass": [0]}, "dirs": [0], "k": 0.1},
            "force": {"type": "CosinusForcing", "connect": {"mass": [0]}, "dirs": [0], "amp": 0.18},
        },
    }


def turns(frequencies: list[float]) -> list[tuple[str, float]]:
    """Where the frequency turns along the branch: the top of a parabola through three points."""
    found = []
    for before, here, after in zip(frequencies, frequencies[1:], frequencies[2:], strict=False):
        if (here - before) * (after - here) < 0:
            bend, slope = after - 2 * here + before, (after - before) / 2
            found.append(("LP", here - slope * slope / (2 * bend)))
    return found


def main() -> None:
    """Time the branch, print the record."""
    options = record.arguments("pyHarm on one system", PRESETS, SYSTEMS)
    if options.system != "duffing":
        record.leave(record.MISSING, "pyHarm has no element for this system.")
    # pyHarm leaves a folder where it is imported.
    folder = tempfile.mkdtemp()
    os.chdir(folder)
    try:
        from pyHarm.Maestro import Maestro
    except ImportError:
        record.leave(record.MISSING, "pyHarm is not installed: pip install pyharm-os.")
    logging.disable(logging.CRITICAL)
    warnings.simplefilter("ignore")
    preset = PRESETS[options.settings]

    def follow() -> tuple[list[float], float, float]:
        task = Maestro(given(preset))
        begun, used = time.perf_counter(), time.process_time()
        task.operate()
        took = time.perf_counter() - begun, time.process_time() - used
        solutions = task.nls["response"].SolList
        return [float(item.x[-1]) for item in solutions if item.flag_accepted], *took

    frequencies, built, _ = follow()
    times = [follow()[1:] for _ in range(options.repeat)]
    record.Record(
        peer="pyHarm",
        version=f"pyharm-os {version('pyharm-os')}",
        settings={"name": options.settings, **preset},
        build_seconds=built,
        seconds={"branch": [wall for wall, _ in times]},
        processor_seconds={"branch": [used for _, used in times]},
        specials={"branch": turns(frequencies)},
        points={"branch": len(frequencies)},
        reached={"branch": frequencies[-1]},
    ).print()
    shutil.rmtree(folder)


if __name__ == "__main__":
    main()
