"""AUTO-07p on one of the systems that nothing forces, through bifpy's compiled path.

    python bench/peers/auto07p_cycles.py --repeat 3 --system canards [--settings NAME]

As in `auto07p.py`: the executables that bifpy leaves behind are run again for each timing, and
`solver_seconds` is AUTO's own clock. From a Hopf point that is the equilibrium and the cycles.

Tried through the canards (ratio of times 0.04, one fold): NTST 50, 100 and 200, tolerances 1e-7 and
1e-9, DSMAX 0.1 and 0.5 have three to six folds each, since the sign of the parameter's tangent is
rounding there; at 0.02 there are nine and more, and branch points. At 0.08 NTST 50 has the one.
"""

import math
import shutil
import sys
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import auto07p
import record

sys.path.insert(0, str(Path(__file__).parents[1]))

from cycles import HARMONICS, OSCILLATORS, Oscillator, first_cycle

COMMON = {"ncol": 4, "dsmin": 1e-9, "nmx": 20000}
USUAL = {**COMMON, "epsl": 1e-7, "epsu": 1e-7, "epss": 1e-5}

PRESETS: dict[str, dict[str, float]] = {
    "usual": {**USUAL, "ntst": 50, "ds": 1e-3, "dsmax": 0.5},
    "large": {**USUAL, "ntst": 100, "ds": 1e-3, "dsmax": 5.0},
    "fine": {
        **COMMON, "epsl": 1e-9, "epsu": 1e-9, "epss": 1e-7, "ntst": 200, "ds": 1e-3, "dsmax": 0.5
    },
}  # fmt: skip


def runs(oscillator: Oscillator, name: str, preset: dict[str, float]) -> list[Any]:
    """Build the runs that lead to the cycles: one, or two from a Hopf point."""
    auto = auto07p.engine()
    first, last = oscillator.span

    def rates(state: Any, parameters: Any) -> list[Any]:
        return oscillator.rates(state, parameters[0])

    def rest(state: Any, parameters: Any, phase: Any) -> None:
        for i, value in enumerate(oscillator.start):
            state[i] = value
        parameters[0] = first

    def begin(state: Any, parameters: Any, phase: Any) -> None:
        coefficients, duration = first_cycle(name)
        for i in range(len(oscillator.start)):
            value = float(coefficients[i, 0].real)
            for h in range(1, HARMONICS + 1):
                part = 2 * complex(coefficients[i, h])
                angle = 2 * math.pi * h * phase
                value = value + part.real * math.cos(angle) - part.imag * math.sin(angle)
            state[i] = value
        parameters[0] = first
        parameters[10] = duration

    settings = {"ndim": len(oscillator.start), "rl0": first - 0.5, "rl1": 1.1 * last, **preset}
    free = {"icu": [1, auto.PERIOD_INDEX], "uzstop": {1: last}}
    if oscillator.settled:
        return [auto07p.build(auto, (rates, begin), settings, **free)]
    standing = {**settings, "ips": auto.IPS_EQUILIBRIUM, "ds": 0.01, "dsmax": 0.02}
    still = auto07p.build(auto, (rates, rest), standing, icu=[1], uzstop={1: last})
    hopf = next(point for point in points(still) if point.point_type.name == "HOPF_BIFURCATION")
    free["source_ips"] = auto.IPS_EQUILIBRIUM
    return [still, auto07p.build(auto, (rates, rest), settings, hopf, **free)]


def points(result: Any) -> list[Any]:
    """All points of a run."""
    return [point for part in result.branches for point in part.points]


def rerun(results: Sequence[Any]) -> tuple[float, float]:
    """Wall seconds and AUTO's own, of all runs."""
    walls, solvers = zip(
        *(auto07p.rerun(Path(item.output_directory)) for item in results), strict=True
    )
    return sum(walls), sum(solvers)


def main() -> None:
    """Build the branch, time it, print the record."""
    options = record.arguments("AUTO-07p on one oscillator", PRESETS, OSCILLATORS)
    preset = PRESETS[options.settings]
    oscillator = OSCILLATORS[options.system]
    results, built = auto07p.timed(lambda: runs(oscillator, options.system, preset))
    times = [rerun(results) for _ in range(options.repeat)]
    for result in results:
        shutil.rmtree(result.output_directory)
    last = points(results[-1])[-1]
    record.Record(
        peer="AUTO-07p",
        version=f"bifpy {version('bifpy')}",
        settings={"name": options.settings, **preset},
        build_seconds=built,
        seconds={"branch": [wall for wall, _ in times]},
        solver_seconds={"branch": [solver for _, solver in times]},
        specials={"branch": auto07p.specials(results[-1])},
        points={"branch": len(points(results[-1]))},
        reached={"branch": last.parameters[0], "duration": last.parameters[1]},
    ).print()


if __name__ == "__main__":
    main()
