"""slipfold on one of the two oscillators, printed as the peers print theirs.

    python bench/ours_cycles.py --repeat 3 --system canards

Warm, with default settings: the equilibrium too, normal forms, uncertainties and checks are part of
it. `build_seconds` is the first call: compiled flows are loaded, or compiled.
"""

import time

import slipfold as sf
from cycles import OSCILLATORS
from peers import record
from slipfold.version import package_version


def main() -> None:
    """Warm up, time, print the record."""
    options = record.arguments("slipfold on one oscillator", systems=OSCILLATORS)
    oscillator = OSCILLATORS[options.system]
    first, last = oscillator.span
    values = zip(oscillator.formulas.items(), oscillator.start, strict=True)
    model = sf.System(
        name=options.system,
        parameters={oscillator.parameter: first},
        states={name: {"rate": rate, "start": value} for (name, rate), value in values},
    )
    alone = sf.Settings(largest_period=1, largest_duration=1e3)

    def follow() -> sf.Diagram:
        return sf.response(
            model,
            oscillator.parameter,
            (first, last),
            settings=alone,
            settled=oscillator.settled,
        )

    begun = time.perf_counter()
    cycles = follow().branches[-1]
    built = time.perf_counter() - begun
    times = []
    for _ in range(options.repeat):
        begun, used = time.perf_counter(), time.process_time()
        follow()
        times.append((time.perf_counter() - begun, time.process_time() - used))
    assert cycles.durations is not None
    record.Record(
        peer="slipfold",
        version=package_version(),
        settings={"name": "defaults"},
        build_seconds=built,
        seconds={"branch": [wall for wall, _ in times]},
        processor_seconds={"branch": [used for _, used in times]},
        specials={"branch": [(point.type, point.value) for point in cycles.special]},
        points={"branch": len(cycles)},
        reached={"branch": cycles.stopped.value, "duration": float(cycles.durations[-1])},
    ).print()


if __name__ == "__main__":
    main()
