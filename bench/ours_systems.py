"""slipfold on one of the three systems, printed as the peers print theirs.

    python bench/ours_systems.py --repeat 3 --system chain

Branches over the span, warm, with default settings; uncertainties and normal forms are part of it.
`build_seconds` is the first call: compiled flows are loaded, or compiled.
"""

import time

import slipfold as sf
from peers import record
from slipfold.models.registry import model_named
from slipfold.version import package_version
from systems import SYSTEMS


def main() -> None:
    """Warm up, time, print the record."""
    options = record.arguments("slipfold on one system", systems=SYSTEMS)
    system = SYSTEMS[options.system]
    model = model_named(system.model)
    alone = sf.Settings(largest_period=1)

    def follow() -> sf.Diagram:
        return sf.response(model, system.parameter, system.span, settings=alone)

    begun = time.perf_counter()
    branch = follow().branches[0]
    built = time.perf_counter() - begun
    times = []
    for _ in range(options.repeat):
        begun, used = time.perf_counter(), time.process_time()
        follow()
        times.append((time.perf_counter() - begun, time.process_time() - used))
    record.Record(
        peer="slipfold",
        version=package_version(),
        settings={"name": "defaults"},
        build_seconds=built,
        seconds={"branch": [wall for wall, _ in times]},
        processor_seconds={"branch": [used for _, used in times]},
        specials={"branch": [(point.type, point.value) for point in branch.special]},
        points={"branch": len(branch)},
        reached={"branch": branch.stopped.value},
    ).print()


if __name__ == "__main__":
    main()
