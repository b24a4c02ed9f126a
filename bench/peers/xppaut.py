"""XPPAUT's AUTO on the sliding oscillator, through xpplab.

    python bench/peers/xppaut.py --repeat 5 [--settings largest|reliable|fine]

The period-1 force response from Nd = 0 to 0.375 N with its PD, and from that PD the period-2 branch
to 0.98 N with its two NS (XPPAUT's TR). XPPAUT wants autonomous equations, so two states c, s with
a stable unit circle give cos(2 pi f t). One period is integrated from the static point at Nd = 0
and handed to AUTO as the starting orbit.

`seconds` is the call that continues, fetching its points into Python included (XPPAUT prints no
time of its own); loading the model and the starting run are `build_seconds`. The limits in Nd are
not hit exactly: the last step goes beyond, as `reached` says. The starting run uses Runge-Kutta
with fixed steps, because the adaptive `meth=qualrk` sometimes never returned.

How far can the steps be stretched? The same AUTO strategy as AUTO-07p's, so the same answer: the PD
is seen only if two successive points lie near it. Tried on period 1: NTST 10, 15, 20; DS 0.001 to
0.02; DSMAX 0.0025 to 1; EPSL=EPSU=1e-7 with EPSS=1e-5, and XPPAUT's own 1e-4.

* EPSL=1e-7, DS=0.01: found at DSMAX 0.1 to 1, by the luck of where the steps fall; missed by all
  from 0.015 to 0.07. With DS=0.001, 0.005 or 0.02: missed by all tried from 0.1 up (NTST 10 with
  DS=0.02 even turns back to Nd < 0).
* Seven DS from 0.001 to 0.02 with NTST 15 and 20: each misses it at two to four of the DSMAX from
  0.007 to 0.012 (the smallest that missed: 0.007 with DS=0.001, NTST=20); all nine DSMAX from
  0.0025 to 0.0065 find it, always.
* EPSL=1e-4 (NTST 15, 20): found at 0.05, 0.03, 0.02, missed at 0.07, 0.1, 0.2, 0.015; the PD is off
  by up to 2e-5.

Period 2 (NTST 10, 15, 20; DS 0.005 to 0.1; DSMAX 0.05, 0.2, 0.5): both NS are found by every
setting with DS up to 0.05; DS=0.1 steps over the first.

`largest` (the default) has the longest steps that find every point, which on period 1 is luck;
`reliable` the longest for which no smaller step tried, nor another first step, missed one, as one
who does not know the answer would need; `fine` tightens mesh and tolerances to compare accuracy.
"""

import tempfile
import time
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import oscillator
import record

NAMES = {"PD": "PD", "TR": "NS", "LP": "LP", "BP": "BP"}

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

LIMITS = {"parmin": -0.01, "normmin": 0, "normmax": 1e6, "nmax": 1000, "npr": 100000, "iad": 3}


def model_text() -> str:
    """The oscillator in XPPAUT's language; it must say what `oscillator.rates` says."""
    horizontal, vertical = oscillator.HORIZONTAL, oscillator.VERTICAL
    rate, length, tau = oscillator.RATE, oscillator.LENGTH, oscillator.TAU
    return f"""
par nd=0
slipx={oscillator.PLATE[0]!r}-{rate!r}*vx
slipy={oscillator.PLATE[1]!r}-{rate!r}*vy
grip={oscillator.FRICTION!r}*({oscillator.STEADY_LOAD!r}+nd*c)/sqrt(slipx*slipx+slipy*slipy)
pull={oscillator.SPRING * length!r}*(1-1/sqrt((1+y)*(1+y)+x*x))
inward=1-c*c-s*s
x'={tau!r}*vx
y'={tau!r}*vy
vx'=(grip*slipx-{horizontal.damping * rate!r}*vx\
-{horizontal.stiffness * length!r}*x-pull*x)/{horizontal.inertia!r}
vy'=(grip*slipy-{vertical.damping * rate!r}*vy\
-{vertical.stiffness * length!r}*y-pull*(1+y))/{vertical.inertia!r}
c'=inward*c-{tau!r}*s
s'=inward*s+{tau!r}*c
init x={oscillator.REST[0]!r},y={oscillator.REST[1]!r},vx=0,vy=0,c=1,s=0
@ total=1,dt=0.005,meth=rungekutta,bounds=1000
done
"""


def engine() -> ModuleType:
    """xpplab, or leave with the sentence that says what is missing."""
    try:
        import xpplab
    except ImportError:
        record.leave(record.MISSING, "XPPAUT is not installed: pip install xpplab.")
    module: ModuleType = xpplab
    return module


class Run(NamedTuple):
    """Both branches, computed once."""

    loading: float
    seconds: dict[str, float]
    diagrams: dict[str, Any]


def run(xpplab: ModuleType, preset: dict[str, dict[str, float]]) -> Run:
    """Load the model afresh, then follow and time both branches."""
    begun = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "sliding.ode")
        path.write_text(model_text())
        model = xpplab.load(str(path))
        model.run(total=1)
        loaded = time.perf_counter()
        single = model.auto.start("periodic", "nd", parmax=0.375, **LIMITS, **preset["period1"])
        followed = time.perf_counter()
        doublings = single.special("PD")
        if not doublings:
            record.leave(
                record.FAILED,
                "XPPAUT found no period doubling, so there is no period-2 branch to follow.",
            )
        switching = time.perf_counter()
        double = model.auto.continue_from(
            doublings[0], "doubling", parmax=0.98, **LIMITS, **preset["period2"]
        )
        done = time.perf_counter()
    return Run(
        loading=loaded - begun,
        seconds={"period1": followed - loaded, "period2": done - switching},
        diagrams={"period1": single, "period2": double},
    )


def specials(diagram: Any) -> list[tuple[str, float]]:
    """The bifurcations of a branch, in the order they were met."""
    return [(NAMES[point.type], point.value) for point in diagram.special() if point.type in NAMES]


def main() -> None:
    """Time both branches, print the record."""
    options = record.arguments("XPPAUT's AUTO on the sliding oscillator", PRESETS)
    xpplab = engine()
    preset = PRESETS[options.settings]
    runs = [run(xpplab, preset) for _ in range(options.repeat)]
    diagrams = runs[0].diagrams
    record.Record(
        peer="XPPAUT",
        version=f"xpplab {version('xpplab')} (XPPAUT 8.0)",
        settings={"name": options.settings, **preset},
        build_seconds=runs[0].loading,
        seconds={task: [run.seconds[task] for run in runs] for task in diagrams},
        specials={task: specials(diagram) for task, diagram in diagrams.items()},
        points={task: len(diagram) for task, diagram in diagrams.items()},
        reached={task: diagram[len(diagram) - 1].value for task, diagram in diagrams.items()},
    ).print()


if __name__ == "__main__":
    main()
