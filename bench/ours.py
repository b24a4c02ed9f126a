"""slipfold on the work that the peers get, printed as they print theirs.

    python bench/ours.py --repeat 5

The force response at 12.5 Hz in one call, warm: period 1 from Nd = 0 to its limit with its PD,
period 2 from that PD to 0.98 N with both NS. Uncertainties and normal forms are part of the call;
the peers compute neither. A second call follows period 1 alone to its limit, a third to 0.375 N,
where the peers stop; `period2` is the first call less the second. Then 1000 forcing periods from
rest. `build_seconds` is the first call of each in this process: loading compiled flows from the
cache, or compiling them.
"""

import time
from collections.abc import Callable
from typing import Any

import slipfold as sf
from peers import record
from slipfold.flow.simulate import simulate
from slipfold.version import package_version

FREQUENCY = 12.5
ALONE = sf.Settings(largest_period=1)


def timed(work: Callable[[], Any]) -> tuple[Any, float]:
    """The result of a call and the seconds it took."""
    begun = time.perf_counter()
    result = work()
    return result, time.perf_counter() - begun


def follow(last: float, settings: sf.Settings | None = None) -> sf.Diagram:
    """The force response from Nd = 0."""
    return sf.response(
        sf.SlidingOscillator(), vary="Nd", span=(0, last), f=FREQUENCY, settings=settings
    )


WORK: dict[str, Callable[[], Any]] = {
    "both": lambda: follow(0.98),
    "limit": lambda: follow(0.98, ALONE),
    "period1": lambda: follow(0.375, ALONE),
    "simulate": lambda: simulate(sf.SlidingOscillator(f=FREQUENCY, Nd=0.1), 1000),
}


def main() -> None:
    """Warm up, time, print the record."""
    options = record.arguments("slipfold on the sliding oscillator")
    first = {task: timed(work) for task, work in WORK.items()}
    seconds: dict[str, list[float]] = {task: [] for task in WORK}
    for _ in range(options.repeat):
        for task, work in WORK.items():
            seconds[task].append(timed(work)[1])
    pairs = zip(seconds["both"], seconds["limit"], strict=True)
    seconds["period2"] = [both - single for both, single in pairs]
    single, double = first["both"][0].branches
    record.Record(
        peer="slipfold",
        version=package_version(),
        settings={"name": "defaults"},
        build_seconds=sum(took for _, took in first.values()),
        seconds=seconds,
        specials={
            f"period{branch.period}": [(point.type, point.value) for point in branch.special]
            for branch in (single, double)
        },
        points={
            "limit": len(single),
            "period1": len(first["period1"][0].branches[0]),
            "period2": len(double),
        },
        reached={"limit": single.stopped.value, "period2": double.stopped.value},
        final_state={"simulate": first["simulate"][0].states[-1].tolist()},
    ).print()


if __name__ == "__main__":
    main()
