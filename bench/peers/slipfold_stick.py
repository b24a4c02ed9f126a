"""slipfold on Den Hartog's oscillator, beside its peers.

    python bench/peers/slipfold_stick.py --repeat 3

`build_seconds` is the first call, in which modes are compiled or loaded.
"""

import time

import record
from stick import FREQUENCY, FRICTION, PERIOD

import slipfold as sf
from slipfold.version import package_version

PERIODS = 1000


def main() -> None:
    """Simulate, print the record."""
    options = record.arguments("slipfold on Den Hartog's oscillator")
    law = sf.Coulomb(mu_s=FRICTION, mu_k=FRICTION)
    model = sf.Structure(
        [[1.0]],
        None,
        [[1.0]],
        names="x",
        contacts=sf.FrictionContact("x", law, load=1.0, Vd=0.0),
        forcing=sf.HarmonicForce("x", F=1.0),
        f=1 / PERIOD,
    )
    begun = time.perf_counter()
    sf.simulate(model, PERIODS)
    built = time.perf_counter() - begun
    times = []
    for _ in range(options.repeat):
        begun, used = time.perf_counter(), time.process_time()
        motion = sf.simulate(model, PERIODS)
        times.append((time.perf_counter() - begun, time.process_time() - used))
    record.Record(
        peer="slipfold",
        version=package_version(),
        settings={"periods": PERIODS, "W": FREQUENCY, "S": FRICTION},
        build_seconds=built,
        seconds={"simulate": [wall for wall, _ in times]},
        processor_seconds={"simulate": [used for _, used in times]},
        final_state={"simulate": motion.states[-1].tolist()},
    ).print()


if __name__ == "__main__":
    main()
