"""Studies: cases a second, what a second process and a cluster add, memory by number of cases.

    OMP_NUM_THREADS=1 python bench/many_cases/measure.py --cases 2000 --largest 100000

Force responses with all special points over plate speed, friction coefficient and direction, and
motions of one period, which take next to no time, for what a case costs besides.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

import machine
import slipfold as sf
from slipfold.version import package_version

PROCESSES = 2

RESPONSE = {
    "model": "sliding",
    "parameters": {"f": 12.5},
    "compute": {"what": "response", "vary": "Nd", "span": [0, 0.98]},
}

MOTION = {
    "model": "sliding",
    "parameters": {"f": 12.5, "Nd": 0.02},
    "compute": {"what": "simulation", "periods": 1},
}

SMALL, TASKS = 4000, 2000

GROUP = 64
"""Responses that go side by side."""


def scattered(count):
    """So many cases over Vd, mu and alpha, spread evenly."""
    ends = {"Vd": (0.4, 1.2), "mu": (0.2, 0.6), "alpha": ("25deg", "70deg")}
    distributions = {
        name: {"distribution": "uniform", "from": low, "to": high}
        for name, (low, high) in ends.items()
    }
    return {
        "cases": {
            "sample": "latin hypercube",
            "count": count,
            "seed": 0,
            "distributions": distributions,
        }
    }


def timed(study, executor):
    """Seconds that a study takes, and what it found."""
    begun = time.perf_counter()
    found = sf.study(study, executor=executor)
    return time.perf_counter() - begun, found


def resident():
    """Largest memory of this process so far in bytes."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmHWM"):
            return 1024 * int(line.split()[1])
    raise RuntimeError("this system does not tell how much memory a process took")


def memory(count):
    """Memory while cases are computed and when they are saved, and bytes of what is kept."""
    seen = []
    with tempfile.TemporaryDirectory() as folder:
        store, file = Path(folder, "kept.study"), Path(folder, "kept.nc")
        found = sf.study(
            {**MOTION, **scattered(count)},
            store,
            on_progress=lambda progress: seen.append(resident()),
        )
        found.save(file)
        kept = (store / "cases.jsonl").stat().st_size
        return {
            "cases": count,
            "computing": seen[-1],
            "saving": resident(),
            "store": kept,
            "file": file.stat().st_size,
        }


def cluster():
    """Seconds of small cases in processes and on a cluster, and how many tasks it takes a second.

    None without the extra.
    """
    try:
        from distributed import LocalCluster
    except ImportError:
        return None
    study = {**MOTION, **scattered(SMALL)}
    in_processes, _ = timed(study, PROCESSES)
    with LocalCluster(n_workers=PROCESSES, threads_per_worker=1, dashboard_address=None) as local:
        timed(study, local.scheduler_address)  # workers import, and load what is compiled
        on_cluster, _ = timed(study, local.scheduler_address)
        with local.get_client() as client:
            begun = time.perf_counter()
            client.gather(client.map(abs, range(TASKS), pure=False))
            rate = TASKS / (time.perf_counter() - begun)
    return {"cases": SMALL, "processes": in_processes, "cluster": on_cluster, "tasks": rate}


def main():
    """Measure, print the record."""
    parser = argparse.ArgumentParser(description="studies")
    parser.add_argument("--cases", type=int, default=512, help="responses (default 512)")
    parser.add_argument("--largest", type=int, default=100_000, help="motions (default 100,000)")
    parser.add_argument("--memory", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.memory:
        print(json.dumps(memory(options.memory)))
        return
    timed({**RESPONSE, **scattered(2)}, None)  # compiles, or loads what is compiled
    timed({**MOTION, **scattered(2)}, None)
    few = max(options.cases // 2, 1)  # several groups for each process
    one, _ = timed({**RESPONSE, **scattered(few)}, None)
    with ProcessPoolExecutor(PROCESSES, get_context("spawn")) as pool:
        timed({**RESPONSE, **scattered(min(few, 4 * GROUP))}, pool)  # they begin, and load
        several, _ = timed({**RESPONSE, **scattered(few)}, pool)
    seconds, found = timed({**RESPONSE, **scattered(options.cases)}, PROCESSES)
    counts = [10**power for power in range(2, 8) if 10**power <= options.largest]
    each = [sys.executable, __file__, "--memory"]
    record = {
        "version": package_version(),
        "machine": machine.description(),
        "threads": os.environ.get("OMP_NUM_THREADS", "as many as there are cores"),
        "processes": PROCESSES,
        "cases": options.cases,
        "seconds": seconds,
        "failures": len(found.failures),
        "special": len(found.listed["case"]),
        "few": few,
        "one": one,
        "several": several,
        "cluster": cluster(),
        "memory": [
            json.loads(subprocess.check_output([*each, str(count)], text=True)) for count in counts
        ],
    }
    print(json.dumps(record))


if __name__ == "__main__":
    main()
