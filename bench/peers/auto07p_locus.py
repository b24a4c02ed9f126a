"""AUTO-07p on the locus of period doubling in f and Nd, through bifpy's compiled path.

    python bench/peers/auto07p_locus.py --repeat 5 [--settings largest|reliable|fine]

The PD of the force response at 12.5 Hz, as in `auto07p.py`, then its locus down to 11.5 and up to
13.5 Hz. Time stays in periods of 12.5 Hz and f sets the pace of the unit circle, so the period,
PAR(11), is 12.5/f. AUTO needs four runs, and so four compilations: `period1` to the PD; `start`,
its own five steps to the eigenfunction ("Generating starting data", ISW=2); `locus`, from there
down and up, both directions added. `points` counts the point where they meet once.

On the way AUTO looks for folds in f, BP and R2 (`specials`), in less than a tenth of the time; it
finds none. It does not look for GPD, and there is one at 12.4362 Hz, 0.042015 N (where slipfold's
normal form coefficient changes sign).

`landed` is a run apart, not timed, with the mesh and tolerances of the preset but short steps and
EPSS=1e-12, that lands on the frequencies of the reference. The timed run lands on its ends to EPSS.

How far can the steps be stretched? Tried, though not in every combination: NTST 4 to 40; NCOL 3 to
6; DS 0.001 to 4; DSMAX 0.02 to 10; EPSL=EPSU 1e-5 to 1e-9; ITNW 4 to 20 and NWTN 1 to 5 (AUTO's
own: 5 and 3); IAD 0 to 10; DS of the start run, which sets the size of the eigenfunction, 0.0001
to 10.

* Every setting reaches both ends, if it need not land on the way. AUTO shortens the steps it
  cannot take, so the longest are not the fastest; with AUTO's own ITNW and NWTN, DS=0.25 is.
* ITNW=15 lets the steps grow and NWTN=1 keeps the Jacobian after one iteration: together three
  times faster.
* Fewer intervals cost accuracy only. The largest error is 4e-6 N at NTST=4, 6e-7 at 5, 1e-7 at 6,
  1.5e-8 at 8, 3e-9 at 10, 1e-10 at 15 (NCOL=4).
* If two frequencies to land on fall in one step, one is lost, and AUTO may land on a wrong one
  besides, invent a fold in f, or run past the end. With NTST=8 and 15 and up to twelve DS each,
  DSMAX from 0.02 to 0.07 loses none; 0.075 loses two (DS=0.075), 0.085 one (four DS).
* JAC=0 is a quarter slower; -O3 is at most a tenth faster.

`largest` (the default) is the fastest that is right to 2e-8 N; `reliable` has the longest steps for
which no smaller step tried, nor another first step, lost a frequency, as one who does not know the
answer would need; `fine` tightens mesh and tolerances to compare accuracy.

The locus is one curve without folds in f: from 0.587240 N at 11.5 Hz down to 0.040084 N, its least,
at 12.4629 Hz, and up to 0.290928 N at 13.5 Hz. Further on, Nd reaches Ns at 10.975 and 15.105 Hz.
"""

import math
import shutil
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from statistics import median
from types import ModuleType
from typing import Any

import auto07p
import oscillator
import record

ENDS = {"down": 11.5, "up": 13.5}
LANDINGS = (12.0, 12.2, 12.4, 12.6, 12.8)

LOAD, PACE = 1, 2
"""AUTO's numbers of the parameters Nd and f."""

LANDING = {"ds": 0.05, "dsmax": 0.05, "epss": 1e-12, "itnw": 5, "nwtn": 3}

PRESETS: dict[str, dict[str, dict[str, float]]] = {
    "largest": {
        "period1": auto07p.PRESETS["largest"]["period1"],
        "locus": {**auto07p.USUAL, "ntst": 8, "ds": 0.2, "dsmax": 0.5, "itnw": 15, "nwtn": 1},
    },
    "reliable": {
        "period1": auto07p.PRESETS["reliable"]["period1"],
        "locus": {**auto07p.USUAL, "ds": 0.07, "dsmax": 0.07},
    },
    "fine": {
        "period1": auto07p.PRESETS["fine"]["period1"],
        "locus": {**auto07p.TIGHT, "ds": 0.05, "dsmax": 0.05},
    },
}

START = {"ds": 0.01, "dsmax": 0.1}


def equations(state: Any, parameters: Any) -> list[Any]:
    """The six rates AUTO integrates: the oscillator's four, and the unit circle's two."""
    x, y, vx, vy, c, s = (state[i] for i in range(6))
    inward = 1 - c * c - s * s
    turn = oscillator.TAU / oscillator.FREQUENCY * parameters[PACE - 1]
    return [
        *oscillator.rates(x, y, vx, vy, c, parameters[LOAD - 1]),
        inward * c - turn * s,
        inward * s + turn * c,
    ]


def start(state: Any, parameters: Any, phase: float) -> None:
    """The orbit at Nd = 0 and 12.5 Hz."""
    auto07p.start(state, parameters, phase)
    parameters[PACE - 1] = oscillator.FREQUENCY


MODEL = (equations, start)


def to_doubling(auto: ModuleType, steps: dict[str, float]) -> Any:
    """Period 1 from Nd = 0 to its PD."""
    return auto07p.build(
        auto,
        MODEL,
        {"rl1": auto07p.ENDS["period1"], **steps},
        icu=[LOAD, auto.PERIOD_INDEX],
        stop=["PD1"],
    )


def eigenfunction(auto: ModuleType, steps: dict[str, float], doubling: Any) -> Any:
    """The point where the locus starts, its eigenfunction computed."""
    return auto07p.build(
        auto, MODEL, {**steps, **START}, doubling, 2, icu=[LOAD, PACE, auto.PERIOD_INDEX]
    )


def along(
    auto: ModuleType,
    direction: str,
    steps: dict[str, float],
    parent: Any,
    landings: Iterable[float] = (),
) -> Any:
    """The locus from its starting point to one end, landing on frequencies on the way."""
    end = ENDS[direction]
    return auto07p.build(
        auto,
        MODEL,
        {**steps, "ds": math.copysign(steps["ds"], end - oscillator.FREQUENCY), "rl1": 2 * end},
        parent,
        2,
        icu=[PACE, LOAD, auto.PERIOD_INDEX],
        uzstop={PACE: end},
        uzr={PACE: list(landings)},
    )


def joined(down: Any, up: Any, special: bool = False) -> list[tuple[float, float]]:
    """Points (f, Nd) of both directions in order of f, the common one once; or the landings."""
    sides = []
    for result in (down, up):
        points = [point for part in result.branches for point in part.points]
        sides.append(
            [
                (float(point.parameters[0]), float(point.parameters[1]))
                for number, point in enumerate(points)
                if not special or number == 0 or point.point_type.name == "USER_SPECIFIED_VALUE"
            ]
        )
    return [*sides[0][:0:-1], *sides[1]]


def check(points: list[tuple[float, float]], expected: Iterable[float]) -> None:
    """Leave unless every frequency expected was landed on."""
    for f in expected:
        if not any(math.isclose(f, reached, abs_tol=1e-3) for reached, _ in points):
            record.leave(record.FAILED, f"AUTO-07p's locus of period doubling missed f = {f} Hz.")


def summed(pairs: Iterable[tuple[float, float]]) -> tuple[float, float]:
    """Both clocks, added up over the runs of one task."""
    walls, solvers = zip(*pairs, strict=True)
    return sum(walls), sum(solvers)


def main() -> None:
    """Build the runs, time them, print the record."""
    options = record.arguments("AUTO-07p on the locus of period doubling", PRESETS)
    auto = auto07p.engine()
    preset = PRESETS[options.settings]
    steps = preset["locus"]
    single, single_built = auto07p.timed(lambda: to_doubling(auto, preset["period1"]))
    doubling = auto07p.doubling(single)
    if doubling is None:
        shutil.rmtree(single.output_directory)
        record.leave(record.FAILED, "AUTO-07p found no period doubling to follow.")
    begin, begin_built = auto07p.timed(lambda: eigenfunction(auto, steps, doubling))
    parent = begin.branches[-1].points[-1]
    (down, up), built = auto07p.timed(
        lambda: [along(auto, direction, steps, parent) for direction in ENDS]
    )
    landed = [along(auto, direction, {**steps, **LANDING}, parent, LANDINGS) for direction in ENDS]
    tasks = {"period1": [single], "start": [begin], "locus": [down, up]}
    times = {
        task: [
            summed(auto07p.rerun(Path(result.output_directory)) for result in results)
            for _ in range(options.repeat)
        ]
        for task, results in tasks.items()
    }
    for result in (single, begin, down, up, *landed):
        shutil.rmtree(result.output_directory)
    locus, landings = joined(down, up), joined(*landed, special=True)
    check(locus, ENDS.values())
    check(landings, (*ENDS.values(), *LANDINGS))
    solver = {task: [seconds for _, seconds in pairs] for task, pairs in times.items()}
    record.Record(
        peer="AUTO-07p",
        version=f"bifpy {version('bifpy')}",
        settings={"name": options.settings, **preset},
        build_seconds=single_built + begin_built + built,
        seconds={task: [wall for wall, _ in pairs] for task, pairs in times.items()},
        solver_seconds=solver,
        seconds_per_point={"locus": median(solver["locus"]) / len(locus)},
        specials={
            "period1": auto07p.specials(single),
            "locus": [*auto07p.specials(down), *auto07p.specials(up)],
        },
        points={
            "period1": sum(len(part.points) for part in single.branches),
            "locus": len(locus),
        },
        reached={"down": locus[0][0], "up": locus[-1][0]},
        locus=locus,
        landed=landings,
    ).print()


if __name__ == "__main__":
    main()
