"""AUTO-07p in a loop over points of the map of thresholds, through bifpy's compiled path.

    python bench/peers/auto07p_thresholds.py --repeat 12 [--settings reliable|largest]

As in `auto07p.py`, period 1 from Nd = 0, but to its first PD alone, and for another speed and
direction of the plate each: as many points as repeats. Compiling is not timed: speed and direction
could be parameters of one executable. `specials` are the thresholds in the order of the points;
one that is missed is not a number.
"""

import math
import shutil
import sys
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import Any

import auto07p
import oscillator
import record

sys.path.insert(0, str(Path(__file__).parents[1]))

import grid

PRESETS = {name: auto07p.PRESETS[name]["period1"] for name in ("reliable", "largest")}


def rest(plate: tuple[float, float]) -> tuple[float, float]:
    """The static point (x/L, y/L) at Nd = 0."""
    from scipy.optimize import fsolve

    def pull(place: Any) -> tuple[float, float]:
        *_, along_x, along_y = oscillator.rates(*place.tolist(), 0.0, 0.0, 1.0, 0.0, plate)
        return along_x, along_y

    x, y = fsolve(pull, oscillator.REST, xtol=1e-13)
    return float(x), float(y)


def to_doubling(auto: ModuleType, speed: float, direction: float, steps: dict[str, float]) -> Any:
    """Period 1 from Nd = 0 to its first PD."""
    plate = speed * math.cos(direction), speed * math.sin(direction)
    begun = rest(plate)

    def rates(state: Any, parameters: Any) -> list[Any]:
        return auto07p.rates_on(plate, state, parameters[0])

    def start(state: Any, parameters: Any, phase: float) -> None:
        auto07p.start(state, parameters, phase)
        state[0], state[1] = begun

    return auto07p.build(
        auto,
        (rates, start),
        {"rl1": grid.LAST, **steps},
        icu=[1, auto.PERIOD_INDEX],
        stop=["PD1"],
    )


def main() -> None:
    """Build, run again and time each, print the record."""
    options = record.arguments("AUTO-07p on points of the map of thresholds", PRESETS)
    auto, steps = auto07p.engine(), PRESETS[options.settings]
    speeds, directions = grid.places(grid.SIZE)
    values, clocks, built = [], [], 0.0
    for i, j in grid.picked(options.repeat):
        result, took = auto07p.timed(lambda: to_doubling(auto, speeds[i], directions[j], steps))  # noqa: B023
        built += took
        clocks.append(auto07p.rerun(Path(result.output_directory)))
        doubling = auto07p.doubling(result)
        values.append(math.nan if doubling is None else float(doubling.parameters[0]))
        shutil.rmtree(result.output_directory)
    record.Record(
        peer="AUTO-07p",
        version=f"bifpy {version('bifpy')}",
        settings={"name": options.settings, **steps},
        build_seconds=built,
        seconds={"each": [wall for wall, _ in clocks]},
        solver_seconds={"each": [solver for _, solver in clocks]},
        specials={"each": [("PD", value) for value in values]},
    ).print()


if __name__ == "__main__":
    main()
