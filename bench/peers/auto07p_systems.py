"""AUTO-07p on one of the three systems, through bifpy's compiled path.

    python bench/peers/auto07p_systems.py --repeat 3 --system chain [--settings usual|large|fine]

As in `auto07p.py`: two states c, s with a stable unit circle give the forcing, the executable that
bifpy leaves behind is run again for each timing, and `solver_seconds` is AUTO's own clock.

`usual` has AUTO's own defaults for mesh and largest step; `large` longer steps on a coarser mesh;
`fine` tightens mesh and tolerances to compare accuracy.
"""

import math
import shutil
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any

import auto07p
import record

sys.path.insert(0, str(Path(__file__).parents[1]))

from systems import HARMONICS, SYSTEMS, TAU, System, first_orbit

COMMON = {"ncol": 4, "epsl": 1e-7, "epsu": 1e-7, "epss": 1e-5, "dsmin": 1e-6}
TIGHT = {"ncol": 4, "epsl": 1e-9, "epsu": 1e-9, "epss": 1e-9, "dsmin": 1e-8}

PRESETS: dict[str, dict[str, float]] = {
    "usual": {**COMMON, "ntst": 20, "ds": 0.01, "dsmax": 0.1},
    "large": {**COMMON, "ntst": 10, "ds": 0.05, "dsmax": 0.5},
    "fine": {**TIGHT, "ntst": 40, "ds": 0.01, "dsmax": 0.1},
}


def equations(system: System, state: Any, parameters: Any) -> list[Any]:
    """The rates of the system and of the unit circle."""
    count = len(system.states)
    c, s = state[count], state[count + 1]
    inward = 1 - c * c - s * s
    own = [state[i] for i in range(count)]
    return [
        *system.per_period(own, c, parameters[0], math.exp),
        inward * c - TAU * s,
        inward * s + TAU * c,
    ]


def start(name: str, state: Any, parameters: Any, phase: Any) -> None:
    """The first orbit as a Fourier series, and the unit circle."""
    coefficients = first_orbit(name)[1]
    count = len(coefficients)
    for i in range(count):
        value = float(coefficients[i, 0].real)
        for h in range(1, HARMONICS + 1):
            part = 2 * complex(coefficients[i, h])
            angle = TAU * h * phase
            value = value + part.real * math.cos(angle) - part.imag * math.sin(angle)
        state[i] = value
    state[count] = math.cos(TAU * phase)
    state[count + 1] = math.sin(TAU * phase)
    parameters[0] = SYSTEMS[name].span[0]
    parameters[10] = 1.0


def main() -> None:
    """Build the branch, time it, print the record."""
    options = record.arguments("AUTO-07p on one system", PRESETS, SYSTEMS)
    auto = auto07p.engine()
    name = options.system
    system = SYSTEMS[name]
    first, last = system.span

    def rates(state: Any, parameters: Any) -> list[Any]:
        return equations(system, state, parameters)

    def begin(state: Any, parameters: Any, phase: float) -> None:
        start(name, state, parameters, phase)

    result, built = auto07p.timed(
        lambda: auto07p.build(
            auto,
            (rates, begin),
            {
                "ndim": len(system.states) + 2,
                "rl0": first - 0.01,
                "rl1": 1.1 * last,
                **PRESETS[options.settings],
            },
            icu=[1, auto.PERIOD_INDEX],
            uzstop={1: last},
        )
    )
    times = [auto07p.rerun(Path(result.output_directory)) for _ in range(options.repeat)]
    shutil.rmtree(result.output_directory)
    record.Record(
        peer="AUTO-07p",
        version=f"bifpy {version('bifpy')}",
        settings={"name": options.settings, **PRESETS[options.settings]},
        build_seconds=built,
        seconds={"branch": [wall for wall, _ in times]},
        solver_seconds={"branch": [solver for _, solver in times]},
        specials={"branch": auto07p.specials(result)},
        points={"branch": sum(len(part.points) for part in result.branches)},
        reached={"branch": result.branches[-1].points[-1].parameters[0]},
    ).print()


if __name__ == "__main__":
    main()
