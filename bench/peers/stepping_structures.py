"""Time stepping of the strip with dry friction at its tip, in plain NumPy and SciPy.

    python bench/peers/stepping_structures.py --repeat 1 [--settings usual|fine]

Its modes, forty at most, are exact over a step in which the friction force is constant: that which
stops the tip, or the largest (Moreau, Numerical aspects of the sweeping process, CMAME 177 (1999)
329-349, with one contact). At each of three frequencies it goes on until a period changes the first
harmonic by less than 1e-7. There is no stability. `usual` has 1000 steps a period, `fine` 4000.
"""

import sys
import time
from pathlib import Path

import numpy as np
import record
import scipy
from scipy.linalg import eigh, expm
from scipy.sparse.linalg import eigsh

sys.path.insert(0, str(Path(__file__).parents[1]))

from strip import COMPARED, DRY_SIZES, FORCE, FRICTION, Array, Strip, strip

PRESETS = {"usual": {"steps": 1000}, "fine": {"steps": 4000}}

STILL, PERIODS, MODES = 1e-7, 400, 40
"""Change of the first harmonic in a period that counts as none, and most periods and modes."""


def modes(made: Strip) -> tuple[Array, Array]:
    """Squares of circular frequencies, and what each mode does at the tip."""
    size = made.mass.shape[0]
    if size <= MODES:
        squares, shapes = eigh(made.stiffness.toarray(), made.mass.toarray())
    else:
        squares, shapes = eigsh(made.stiffness, MODES, made.mass, sigma=0.0, v0=np.ones(size))
    return squares, shapes[made.tip]


def stepping(made: Strip, frequency: float, steps: int) -> tuple[Array, Array, float]:
    """What a step does: to modes, by a force at the tip, and to its velocity by a friction."""
    squares, tip = modes(made)
    r, step = len(squares), 2 * np.pi / (frequency * steps)
    whole = np.zeros((2 * r + 1, 2 * r + 1))
    whole[:r, r : 2 * r] = np.eye(r)
    whole[r : 2 * r, :r] = -np.diag(squares)
    whole[r : 2 * r, r : 2 * r] = -made.beta * np.diag(squares)
    whole[r : 2 * r, 2 * r] = tip
    found = expm(whole * step)
    return found[: 2 * r, : 2 * r], found[: 2 * r, 2 * r], float(tip @ found[r : 2 * r, 2 * r])


def first_harmonic(made: Strip, frequency: float, steps: int) -> float:
    """Amplitude of the first harmonic of the tip, in a motion that repeats."""
    ahead, pushed, stiff = stepping(made, frequency, steps)
    _, tip = modes(made)
    r, phases = len(tip), (np.arange(steps) + 0.5) / steps
    loads, largest = FORCE * np.cos(2 * np.pi * phases), FRICTION * FORCE
    turns = np.exp(-2j * np.pi * (np.arange(steps) + 1) / steps)
    state, moved, before = np.zeros(2 * r), np.empty(steps), 0.0
    for _ in range(PERIODS):
        for k, load in enumerate(loads):
            free = ahead @ state + pushed * load
            held = -float(tip @ free[r:]) / stiff
            state = free + pushed * min(max(held, -largest), largest)
            moved[k] = tip @ state[:r]
        found = float(2 * np.abs(moved @ turns) / steps)
        if abs(found - before) < STILL * found:
            break
        before = found
    return found


def main() -> None:
    """Time it, print the record."""
    options = record.arguments("time stepping of the strip with dry friction", PRESETS)
    preset = PRESETS[options.settings]
    found = record.Record("time stepping", f"NumPy {np.__version__}, SciPy {scipy.__version__}",
                          dict(preset), 0.0, {}, processor_seconds={})  # fmt: skip
    assert found.processor_seconds is not None
    for size in DRY_SIZES:
        made, task, times = strip(size), str(size), []
        for _ in range(options.repeat):
            begun, used = time.perf_counter(), time.process_time()
            reached = [first_harmonic(made, c * made.lowest, preset["steps"]) for c in COMPARED]
            times.append((time.perf_counter() - begun, time.process_time() - used))
        found.seconds[task] = [wall for wall, _ in times]
        found.processor_seconds[task] = [used for _, used in times]
        found.points[task], found.final_state[task] = len(COMPARED), reached
    found.print()


if __name__ == "__main__":
    main()
