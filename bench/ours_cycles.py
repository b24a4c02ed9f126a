"""slipfold on one of the systems that nothing forces, printed as the peers print theirs.

    python bench/ours_cycles.py --repeat 3 --system canards

Warm, with default settings: the equilibrium too, normal forms, uncertainties and checks are part of
it. `build_seconds` is the first call: compiled flows are loaded, or compiled.
"""

import time

import slipfold as sf
from cycles import OSCILLATORS
from ours_beam import structure
from peers import record
from slipfold.version import package_version


def model_of(name: str) -> sf.Model:
    """The model as a user would write it."""
    oscillator = OSCILLATORS[name]
    if not oscillator.formulas:
        return structure()
    values = zip(oscillator.formulas.items(), oscillator.start, strict=True)
    return sf.System(
        name=name,
        parameters={oscillator.parameter: oscillator.span[0]},
        states={state: {"rate": rate, "start": value} for (state, rate), value in values},
    )


def main() -> None:
    """Warm up, time, print the record."""
    options = record.arguments("slipfold on one oscillator", systems=OSCILLATORS)
    oscillator, model = OSCILLATORS[options.system], model_of(options.system)
    first, last = oscillator.span
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
