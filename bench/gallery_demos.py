"""AUTO's demos and BifurcationKit's tutorials: slipfold and AUTO-07p in one run, for the gallery.

    python bench/gallery_demos.py [NAME ...] [--repeat 3]

Writes docs/gallery/coming_from/measured.json. slipfold's times are processor seconds of
`slipfold.response` with compiled flows, normal forms and checks included; AUTO's its own clock.
"""

import argparse
import json
import sys
import time
from pathlib import Path
from statistics import median
from typing import Any

import machine
import processes

sys.path.insert(0, str(Path(__file__).parents[1] / "docs" / "gallery"))

import demos


def ours(name: str, repeat: int) -> dict[str, Any]:
    """Seconds and points of slipfold, ends of branches, and largest states at the last."""
    diagram = demos.response(name)
    times = []
    for _ in range(repeat):
        begun = time.process_time()
        demos.response(name)
        times.append(time.process_time() - begun)
    return {
        "seconds": median(times),
        "points": demos.own_points(diagram),
        "ends": [float(branch.parameter[-1]) for branch in diagram.branches],
        "last": diagram.branches[-1].orbit(-1).extrema.maximum[0].tolist(),
    }


def theirs(name: str, repeat: int) -> dict[str, Any]:
    """The same of AUTO."""
    record = processes.ask("peers/auto07p_demos.py", "--system", name, "--repeat", f"{repeat}")
    if isinstance(record, processes.Absent):
        raise SystemExit(f"{name}: {record.reason}")
    points = [point for run in record["specials"].values() for point in run]
    return {
        "seconds": median(record["solver_seconds"]["branches"]),
        "points": points,
        "ends": list(record["reached"].values()),
        "last": record["final_state"][max(record["final_state"])],
    }


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(demos.DEMOS))
    parser.add_argument("--repeat", type=int, default=3, help="repeats of each (default 3)")
    options = parser.parse_args()
    names = options.names or list(demos.DEMOS)
    systems = demos.measured()["systems"] if options.names else {}
    for name in names:
        systems[name] = {"ours": ours(name, options.repeat), "theirs": theirs(name, options.repeat)}
        print(name, json.dumps(systems[name]), file=sys.stderr, flush=True)
    lines = ",\n".join(f"{json.dumps(key)}: {json.dumps(item)}" for key, item in systems.items())
    text = f'{{"machine": {json.dumps(machine.description())},\n"systems": {{\n{lines}\n}}}}\n'
    demos.MEASURED.write_text(text)


if __name__ == "__main__":
    main()
