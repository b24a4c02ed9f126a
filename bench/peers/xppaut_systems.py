"""XPPAUT's AUTO on one of the three systems, through xpplab.

    python bench/peers/xppaut_systems.py --repeat 3 --system chain [--settings usual|large|fine]

As in `xppaut.py`: two states c, s with a stable unit circle give the forcing, one period is
integrated and handed to AUTO, `seconds` is the call that continues. The presets are those of
`auto07p_systems.py`.
"""

import sys
import tempfile
import time
from importlib.metadata import version
from pathlib import Path

import record
import xppaut
from auto07p_systems import PRESETS

sys.path.insert(0, str(Path(__file__).parents[1]))

from systems import SYSTEMS, TAU, first_orbit


def model_text(name: str) -> str:
    """A system in XPPAUT's language, written by SymPy from its rates."""
    import sympy

    system = SYSTEMS[name]
    first = system.span[0]
    states = sympy.symbols(system.states)
    cosine, parameter = sympy.symbols("c p")
    rates = system.per_period(list(states), cosine, parameter, sympy.exp)
    lines = [f"par p={first!r}", "inward=1-c*c-s*s"]
    lines += [
        f"{state}'={str(rate).replace('**', '^')}"
        for state, rate in zip(system.states, rates, strict=True)
    ]
    lines += [f"c'=inward*c-{TAU!r}*s", f"s'=inward*s+{TAU!r}*c"]
    begin = first_orbit(name)[0]
    lines += [f"init {state}={float(value)!r}" for state, value in zip(states, begin, strict=True)]
    lines += ["init c=1,s=0", "@ total=1,dt=0.002,meth=rungekutta,bounds=1000", "done"]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Time the branch, print the record."""
    options = record.arguments("XPPAUT's AUTO on one system", PRESETS, SYSTEMS)
    xpplab = xppaut.engine()
    system = SYSTEMS[options.system]
    preset = PRESETS[options.settings]
    first, last = system.span
    limits = {**xppaut.LIMITS, "parmin": first - 0.01}
    times, loading = [], 0.0
    for _ in range(options.repeat):
        begun = time.perf_counter()
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "system.ode")
            path.write_text(model_text(options.system))
            model = xpplab.load(str(path))
            model.run(total=1)
            loaded, used = time.perf_counter(), time.process_time()
            found = model.auto.start("periodic", "p", parmax=last, **limits, **preset)
            times.append((time.perf_counter() - loaded, time.process_time() - used))
            loading = loaded - begun
    record.Record(
        peer="XPPAUT",
        version=f"xpplab {version('xpplab')} (XPPAUT 8.0)",
        settings={"name": options.settings, **preset},
        build_seconds=loading,
        seconds={"branch": [wall for wall, _ in times]},
        processor_seconds={"branch": [used for _, used in times]},
        specials={"branch": xppaut.specials(found)},
        points={"branch": len(found)},
        reached={"branch": found[len(found) - 1].value},
    ).print()


if __name__ == "__main__":
    main()
