"""AUTO-07p on the sliding oscillator, through bifpy's compiled path.

    python bench/peers/auto07p.py --repeat 5 [--settings largest|reliable|fine]

The period-1 force response from Nd = 0 to 0.375 N with its PD, and from that PD the period-2 branch
to 0.98 N with its two NS (AUTO's TR). AUTO wants autonomous equations, so two states c, s with a
stable unit circle give cos(2 pi f t). The Jacobian is exact, derived by bifpy.

bifpy compiles on every call, so it is called once and the executable it leaves behind is run again
in a fresh directory for each timing: `seconds` is that process, its start and files included,
`solver_seconds` the "Total Time" AUTO prints. bifpy compiles the equations without optimization;
with -O3 the times did not change measurably, nor with a differenced Jacobian, nor without the
diagnostics file (IID=0, used here).

How far can the steps be stretched? AUTO watches only the multiplier nearest the unit circle, so the
PD is seen only if two successive points lie where the crossing one is nearer than the lightly
damped pair at 0.957. Tried on period 1: NTST 10 to 40; NCOL 3 to 6; DS 0.001 to 0.02; DSMAX 0.0025
to 1; EPSL=EPSU 1e-6, 1e-7, 1e-8 (EPSS 100 times that); IAD 0 to 5. At EPSL=1e-7:

* DS=0.01, DSMAX 0.08 to 1: found, by the luck of where the steps fall; from 0.015 to 0.07: missed
  by all 11; from 0.0085 to 0.0125: found by all but 0.012 and (NTST 15 and more) 0.0085.
* DS=0.001: missed by every DSMAX from 0.025 up (NTST 10, 15) or 0.0175 up (NTST 20, 30), and by
  some below.
* Seven DS from 0.001 to 0.02 with NTST 15 and 20: each misses it at two to four of the DSMAX from
  0.007 to 0.012 (the smallest that missed: 0.007 with DS=0.003, NTST=20); all nine DSMAX from
  0.0025 to 0.0065 find it, always.
* EPSL=1e-6 misses it at DSMAX=0.1 with every NTST, and with NTST 12 and 20 invents BPs near the
  end.
* NTST 10 with NCOL 4 often gives up (MX) before 0.375, as does NCOL 3 with NTST 15 and 20; NTST 15,
  NCOL 4 arrives with the presets below. Whether 0.376 is reached depends on mesh and tolerance; at
  0.37606 AUTO gives up (the spring collapses). So the run ends at 0.375.

Period 2 (NTST 10 to 40, DS 0.001 to 0.1, DSMAX 0.005 to 1): both NS are found by every setting with
DS up to 0.05; DS=0.1 steps over the first. NTST 10 puts the second NS off by 2e-5.

`largest` (the default) has the longest steps that find every point, which on period 1 is luck, and
the fastest; `reliable` the longest for which no smaller step tried, nor another first step, missed
one, as one who does not know the answer would need; `fine` tightens mesh and tolerances to compare
accuracy.
"""

import math
import re
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import Any

import oscillator
import record

NAMES = {
    "PERIOD_DOUBLING": "PD",
    "TORUS": "NS",
    "FOLD": "LP",
    "BRANCH_POINT": "BP",
    "RESONANCE_1_2": "R2",
}

ENDS = {"period1": 0.375, "period2": 0.98}

UNKNOWNS = {"ndim": 6, "npar": 11, "jac": 1}
EFFORT = {"nmx": 1000, "npr": 0, "iad": 3, "mxbf": 0, "ilp": 1, "isp": 2, "iid": 0, "rl0": -0.01}

USUAL = {"ntst": 15, "ncol": 4, "epsl": 1e-7, "epsu": 1e-7, "epss": 1e-5, "dsmin": 1e-6}
TIGHT = {"ntst": 40, "ncol": 4, "epsl": 1e-9, "epsu": 1e-9, "epss": 1e-9, "dsmin": 1e-8}

PRESETS: dict[str, dict[str, dict[str, float]]] = {
    "largest": {
        "period1": {**USUAL, "ds": 0.01, "dsmax": 0.5},
        "period2": {**USUAL, "ds": 0.05, "dsmax": 0.5},
    },
    "reliable": {
        "period1": {**USUAL, "ds": 0.0065, "dsmax": 0.0065},
        "period2": {**USUAL, "ds": 0.05, "dsmax": 0.5},
    },
    "fine": {
        "period1": {**TIGHT, "ds": 0.0065, "dsmax": 0.0065},
        "period2": {**TIGHT, "ds": 0.01, "dsmax": 0.05},
    },
}


def equations(state: Any, parameters: Any) -> list[Any]:
    """The six rates AUTO integrates."""
    return rates_on(oscillator.PLATE, state, parameters[0])


def rates_on(plate: tuple[float, float], state: Any, load: Any) -> list[Any]:
    """The oscillator's four rates on a plate of a velocity, and the unit circle's two."""
    x, y, vx, vy, c, s = (state[i] for i in range(6))
    inward = 1 - c * c - s * s
    return [
        *oscillator.rates(x, y, vx, vy, c, load, plate),
        inward * c - oscillator.TAU * s,
        inward * s + oscillator.TAU * c,
    ]


def start(state: Any, parameters: Any, phase: float) -> None:
    """The orbit at Nd = 0: the static point, and the unit circle."""
    state[0], state[1] = oscillator.REST
    state[2] = state[3] = 0.0
    state[4] = math.cos(oscillator.TAU * phase)
    state[5] = math.sin(oscillator.TAU * phase)
    parameters[0] = 0.0
    parameters[10] = 1.0


def engine() -> ModuleType:
    """bifpy's AUTO, or leave with the sentence that says what is missing."""
    try:
        from bifpy import auto
    except ImportError:
        record.leave(
            record.MISSING,
            "AUTO-07p is not installed: pip install bifpy (it needs gfortran and make).",
        )
    if shutil.which("gfortran") is None:
        record.leave(
            record.MISSING, "gfortran is not installed: AUTO-07p needs it to compile the equations."
        )
    module: ModuleType = auto
    return module


def build(
    auto: ModuleType,
    model: tuple[Callable[..., Any], Callable[..., Any]],
    settings: dict[str, Any],
    parent: Any = None,
    isw: int = 1,
    **limits: Any,
) -> Any:
    """Build and run one branch with bifpy, keeping its executable and input files.

    `model` is the equations and the start. From `parent`, a point of another branch, `isw` says how
    to go on.
    """
    rates, starts = model
    settings = {**UNKNOWNS, **EFFORT, "ips": auto.IPS_PERIODIC_ORBIT, **settings}
    limits |= {"keep_output": True, "transpile": True, "jac": auto.AUTO_JACOBIAN}
    if parent is None:
        return auto.run(rates, starts, settings, **limits)
    return auto.restart(rates, settings, parent, isw=isw, stpnt=starts, **limits)


def branch(auto: ModuleType, task: str, steps: dict[str, float], parent: Any = None) -> Any:
    """Build and run one branch of the force response."""
    return build(
        auto,
        (equations, start),
        {"rl1": 1.1 * ENDS[task], **steps},
        parent,
        isw=-1,
        icu=[1, auto.PERIOD_INDEX],
        uzstop={1: ENDS[task]},
    )


def doubling(result: Any) -> Any:
    """The first period doubling of a branch, None if AUTO reported none."""
    points = [point for part in result.branches for point in part.points]
    return next((p for p in points if p.point_type.name == "PERIOD_DOUBLING"), None)


def specials(result: Any) -> list[tuple[str, float]]:
    """The bifurcations of a branch, in the order they were met."""
    return [
        (NAMES[point.point_type.name], point.parameters[0])
        for part in result.branches
        for point in part.points
        if point.point_type.name in NAMES
    ]


def rerun(built: Path) -> tuple[float, float]:
    """Run a built branch again in a fresh directory: wall seconds, and those AUTO prints."""
    with tempfile.TemporaryDirectory() as folder:
        for name in ("fort.2", "fort.3", "bifpy.dat", "model_exe"):
            if (built / name).exists():
                shutil.copy(built / name, folder)
        begun = time.perf_counter()
        done = subprocess.run(
            [str(Path(folder, "model_exe"))], cwd=folder, capture_output=True, text=True, check=True
        )
        wall = time.perf_counter() - begun
    return wall, sum(float(figure) for figure in re.findall(r"Total Time\s+(\S+)", done.stdout))


def timed(work: Callable[[], Any]) -> tuple[Any, float]:
    """The result of a call and the seconds it took."""
    begun = time.perf_counter()
    result = work()
    return result, time.perf_counter() - begun


def main() -> None:
    """Build both branches, time them, print the record."""
    options = record.arguments("AUTO-07p on the sliding oscillator", PRESETS)
    auto = engine()
    preset = PRESETS[options.settings]
    first, first_built = timed(lambda: branch(auto, "period1", preset["period1"]))
    parent = doubling(first)
    if parent is None:
        shutil.rmtree(first.output_directory)
        record.leave(
            record.FAILED,
            "AUTO-07p found no period doubling, so there is no period-2 branch to follow.",
        )
    second, second_built = timed(lambda: branch(auto, "period2", preset["period2"], parent))
    results = {"period1": first, "period2": second}
    times = {
        task: [rerun(Path(result.output_directory)) for _ in range(options.repeat)]
        for task, result in results.items()
    }
    for result in results.values():
        shutil.rmtree(result.output_directory)
    record.Record(
        peer="AUTO-07p",
        version=f"bifpy {version('bifpy')}",
        settings={"name": options.settings, **preset},
        build_seconds=first_built + second_built,
        seconds={task: [wall for wall, _ in pairs] for task, pairs in times.items()},
        solver_seconds={task: [solver for _, solver in pairs] for task, pairs in times.items()},
        specials={task: specials(result) for task, result in results.items()},
        points={
            task: sum(len(part.points) for part in result.branches)
            for task, result in results.items()
        },
        reached={
            task: result.branches[-1].points[-1].parameters[0] for task, result in results.items()
        },
    ).print()


if __name__ == "__main__":
    main()
