"""AUTO-07p on its own demos, with the constants of its own files, through bifpy's compiled path.

    python bench/peers/auto07p_demos.py --system tor

The equations are those of docs/gallery/coming_from/systems, which slipfold reads: they are
translated, not written again. A demo is a sequence of runs, each from a special point of an earlier
one. Times are AUTO's own clock, of executables that bifpy has built, all runs of a demo together.

Where a demo's constants do not do: in `pen` the second angle is a lead over the first, and DSMAX
0.1 passes the period doubling, so it is 0.05 (NMX 400); of its two branch points AUTO reports the
second. `kpr` is not HomCont but cycles to a period of 1000. BifurcationKit's systems have AUTO's
usual constants.
"""

import math
import shutil
import tomllib
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

import auto07p
import record

ROOT = Path(__file__).parents[2]
FOLDERS = (
    ROOT / "docs" / "gallery" / "coming_from" / "systems",
    ROOT / "src" / "slipfold" / "models" / "systems",
)
FUNCTIONS = ("sin", "cos", "exp", "atan")


@dataclass(frozen=True)
class Run:
    """One run of a demo: settings, and the point that it leaves, by run, type and number."""

    settings: dict[str, float]
    stop: dict[int, Any] = field(default_factory=dict)
    leaves: tuple[int, str, int] | None = None
    switch: int = 1


@dataclass(frozen=True)
class Demo:
    """A demo: the parameter varied first, values at the start, a duration to settle, the runs."""

    vary: str
    runs: tuple[Run, ...]
    start: dict[str, float] = field(default_factory=dict)
    settle: tuple[float, float] | None = None
    file: str | None = None


def still(ntst: int = 50, **settings: float) -> dict[str, float]:
    """Settings of a run of equilibria."""
    return {"ips": 1, "ntst": ntst, "isp": 1, "epss": 1e-5, **settings}


HOPF, ROUND = (0, "HOPF_BIFURCATION", 0), {"epss": 1e-4, "dsmin": 1e-3}
TOR = {"ntst": 25, "isp": 2, "ds": 1e-3, "dsmin": 1e-5, "dsmax": 0.01, "epss": 1e-5, "jac": 1}
PLP = {"ntst": 20, "isp": 1, "epsl": 1e-8, "epsu": 1e-8, "epss": 1e-6, "ds": 0.1, "dsmin": 1e-4}
PEN = {"ntst": 30, "ilp": 0, "ds": -0.1, "dsmin": 0.01, "dsmax": 0.5, "epss": 1e-4, "nmx": 200}
LOR = {"isp": 2, "ilp": 0, "dsmin": 0.01, "dsmax": 25.0, "epss": 1e-4, "nmx": 50}
ABC = {"ntst": 25, "isp": 1, "ds": 0.02, "dsmax": 0.1, "nmx": 200, **ROUND}

DEMOS = {
    "ab": Demo("p", (
        Run(still(ds=0.1, dsmin=1e-3, dsmax=0.05, nmx=400), {1: 0.25}),
        Run({"ntst": 70, "ilp": 0, "isp": 1, "ds": 0.01, "dsmin": 1e-3, "dsmax": 0.5, "epss": 1e-5,
             "nmx": 500}, {1: 0.25, 11: 1000.0}, HOPF),
    )),
    "tor": Demo("n", (
        Run(still(25, ds=1e-3, dsmin=1e-5, dsmax=0.01, nmx=125), {1: [-0.9, -0.4]}),
        Run({**TOR, "nmx": 125}, {1: [-0.9, -0.4]}, HOPF),
        Run({**TOR, "nmx": 90}, {1: [-0.9, -0.4]}, (1, "BRANCH_POINT", 0), -1),
    ), {"n": -0.9}, file="freire"),
    "plp": Demo("rho", (
        Run(still(20, ds=0.1, dsmin=0.01, dsmax=3.0, nmx=200, epsl=1e-9, epsu=1e-9, epss=1e-7),
            {1: 6.0}),
        *(Run({**PLP, "dsmax": 3.0, "nmx": 500}, {1: 4.0} if i else {1: 6.0},
              (0, "HOPF_BIFURCATION", i)) for i in (0,)),
    )),
    "chu": Demo("alpha", (
        Run(still(25, ds=0.01, dsmin=1e-4, dsmax=0.1, nmx=200), {1: 16.0}),
        Run({"ntst": 25, "isp": 2, "ds": 0.01, "dsmin": 1e-4, "dsmax": 0.1, "epss": 1e-4,
             "nmx": 100}, {}, HOPF),
    ), {"alpha": 5.0, "x": 1.4994, "z": -1.4994}),
    "pen": Demo("I", (
        Run({**PEN, "ntst": 15, "isp": 2, "dsmax": 0.05, "nmx": 400}, {11: 30.0}),
        Run({**PEN, "isp": 2}, {11: 30.0}, (0, "PERIOD_DOUBLING", 0), -1),
        Run({**PEN, "isp": 1}, {11: 30.0}, (1, "BRANCH_POINT", 0), -1),
    ), settle=(100.0, 1.5738797205)),
    "kpr": Demo("lambda", (
        Run(still(ds=-0.01, dsmin=1e-5, dsmax=0.01, nmx=300), {1: -1.6}),
        Run({"ntst": 50, "isp": 2, "ds": 0.01, "dsmin": 1e-5, "dsmax": 0.5, "epss": 1e-5,
             "nmx": 300}, {11: 1000.0}, HOPF),
    ), {"lambda": -1.609375, "x": -1.25, "y": -1.25, "z": -1.25}),
    "lor": Demo("rho", (
        Run({**LOR, "ntst": 20, "ds": -0.5}, {1: 200.0}),
        Run({**LOR, "ntst": 40, "ds": -0.1}, {1: 200.0}, (0, "PERIOD_DOUBLING", 0), -1),
        Run({**LOR, "ntst": 60, "ds": 0.1}, {1: 200.0}, (1, "PERIOD_DOUBLING", 0), -1),
    ), settle=(100.0, 0.4333)),
    "pp2": Demo("quota", (
        Run(still(90, ds=0.02, dsmin=0.01, dsmax=0.06, nmx=100, mxbf=10), {1: [0.0, 1.0]}),
        Run({"ntst": 90, "isp": 2, "ds": 0.02, "dsmin": 0.01, "dsmax": 0.06, "epss": 1e-5,
             "nmx": 100}, {1: [0.0, 1.0], 11: 36.0}, HOPF),
    )),
    "frc": Demo("W", (
        Run({"ntst": 20, "isp": 2, "ds": -0.5, "dsmin": 1e-3, "dsmax": 5.0, "epss": 1e-4,
             "nmx": 60}, {1: 2 * math.pi}),
    ), {"r": 0.2}, settle=(0.0, 2 * math.pi / 100)),
    "abc": Demo("D", (
        Run(still(15, ds=0.02, dsmin=1e-3, dsmax=0.1, nmx=130), {1: 0.4}),
        *(Run(ABC, {1: 0.25} if i else {}, (0, "HOPF_BIFURCATION", i)) for i in (0, 1)),
    )),
    "co": Demo("q2", (Run(still(ds=1e-3, dsmin=1e-6, dsmax=0.01, nmx=400), {1: 1.9}),), {
        "x": 0.2193727, "y": 0.05428538, "s": 0.5188157}),
    "lorenz84": Demo("F", (Run(still(ds=-1e-3, dsmin=1e-6, dsmax=0.05, nmx=400), {1: 3.0}),), {
        "F": 2.999, "X": 2.9787, "Y": -0.0387, "Z": 0.0582, "U": -0.02105}),
    "steinmetz": Demo("k8", (
        Run(still(ds=-0.01, dsmin=1e-5, dsmax=0.1, nmx=400), {1: 0.5}),
        Run({"ntst": 50, "isp": 2, "ds": 0.01, "dsmin": 1e-5, "dsmax": 0.5, "epss": 1e-5,
             "nmx": 300}, {1: 0.5}, HOPF),
    ), {"k8": 1.2, "A": 2.553191, "B": 14.24495, "X": 0.02623491, "Y": 0.61259227}),
}  # fmt: skip


class Equations:
    """A system's file as the functions that AUTO wants."""

    def __init__(self, name: str, demo: Demo) -> None:
        self.demo = demo
        paths = (folder / f"{demo.file or name}.toml" for folder in FOLDERS)
        tables = tomllib.loads(next(path for path in paths if path.exists()).read_text())

        def table(name: str, key: str) -> dict[str, dict[str, Any]]:
            entries = tables.get(name, {}).items()
            return {k: entry if isinstance(entry, dict) else {key: entry} for k, entry in entries}

        states = table("states", "rate")
        self.formulas = {k: compiled(v["rate"]) for k, v in table("formulas", "rate").items()}
        self.rates_of = {k: compiled(v["rate"]) for k, v in states.items()}
        self.angles = [v.get("angle", False) for v in states.values()]
        values = {k: float(eval(f"{v['value']}")) for k, v in table("parameters", "value").items()}
        self.values = {k: demo.start.get(k, value) for k, value in values.items()}
        self.state = [demo.start.get(k, v.get("start", 0.0)) for k, v in states.items()]
        self.forced = "forcing" in tables
        self.state += [0.0, 1.0] * self.forced
        self.angles += [False, False] * self.forced

    def rates(self, state: Any, parameters: Any) -> list[Any]:
        """All rates of a state."""
        names = {function: getattr(math, function) for function in FUNCTIONS}
        names |= {"pi": math.pi, **self.values, f"{self.demo.vary}": parameters[0]}
        # Which Python has another use for.
        names["lambda_"] = names.get("lambda")
        names |= {key: state[i] for i, key in enumerate(self.rates_of)}
        circle: list[Any] = []
        if self.forced:
            # AUTO wants autonomous equations: the drive sin(W t) is a stable circle's first state.
            drive, other = state[len(self.rates_of)], state[len(self.rates_of) + 1]
            inward = 1 - drive * drive - other * other
            turns = parameters[0]
            circle = [inward * drive + turns * other, inward * other - turns * drive]
            names["drive"] = drive
        for key, formula in self.formulas.items():
            if not (self.forced and key == "drive"):
                names[key] = eval(formula, {}, names)
        return [*(eval(rate, {}, names) for rate in self.rates_of.values()), *circle]

    def begin(self, state: Any, parameters: Any, phase: Any) -> None:
        """The state and the parameter to start from."""
        for i, value in enumerate(self.state):
            state[i] = value
        parameters[0] = self.values[self.demo.vary]
        if self.demo.settle:
            parameters[10] = self.demo.settle[1]

    def orbit(self) -> tuple[Any, Any] | None:
        """What a motion settles on, over about a period, where the demo starts from an orbit."""
        if self.demo.settle is None:
            return None
        from scipy.integrate import solve_ivp

        until, duration = self.demo.settle
        values = [self.values[self.demo.vary]]
        rates = lambda t, state: self.rates(state, values)  # noqa: E731
        last = solve_ivp(rates, (0, until), self.state, rtol=1e-9, atol=1e-9).y[:, -1]
        # Whole turns say nothing, but take digits.
        last = [
            math.remainder(x, 2 * math.pi) if angle else x
            for x, angle in zip(last, self.angles, strict=True)
        ]
        once = solve_ivp(rates, (0, duration), last, rtol=1e-9, atol=1e-9, max_step=duration / 80)
        return once.t.tolist(), once.y.T.tolist()


def compiled(text: str) -> Any:
    """A rate in Python's notation."""
    return compile(text.replace("^", "**").replace("lambda", "lambda_"), "rate", "eval")


NAMES = {**auto07p.NAMES, "HOPF_BIFURCATION": "HB"}


def points(result: Any) -> list[Any]:
    """All points of a run."""
    return [point for part in result.branches for point in part.points]


def follow(name: str) -> list[Any]:
    """All runs of a demo."""
    auto = auto07p.engine()
    demo = DEMOS[name]
    equations = Equations(name, demo)
    results: list[Any] = []
    for run in demo.runs:
        cycles = "ips" not in run.settings
        settings = {"ndim": len(equations.state), "rl0": -1e9, "rl1": 1e9}
        settings |= {"epsl": 1e-7, "epsu": 1e-7, **run.settings}
        limits: dict[str, Any] = {"icu": [1, auto.PERIOD_INDEX] if cycles else [1]}
        if run.stop:
            limits["uzstop"] = run.stop
        parent = None
        if cycles:
            limits["thl"] = {11: 0.0}
        if run.leaves:
            number, kind, which = run.leaves
            parent = [p for p in points(results[number]) if p.point_type.name == kind][which]
            if kind == "HOPF_BIFURCATION":
                limits["source_ips"] = auto.IPS_EQUILIBRIUM
        elif demo.settle:
            limits["dat"] = equations.orbit()
        results.append(
            auto07p.build(
                auto, (equations.rates, equations.begin), settings, parent, run.switch, **limits
            )
        )
    return results


def main() -> None:
    """Run a demo, time it, print the record."""
    options = record.arguments("AUTO-07p on one of its demos", (), DEMOS)
    results, built = auto07p.timed(lambda: follow(options.system))
    times = []
    for _ in range(options.repeat):
        times.append(sum(auto07p.rerun(Path(item.output_directory))[1] for item in results))
    for result in results:
        shutil.rmtree(result.output_directory)
    record.Record(
        peer="AUTO-07p",
        version=f"bifpy {version('bifpy')}",
        settings={},
        build_seconds=built,
        seconds={},
        solver_seconds={"branches": times},
        specials={
            str(number): [
                (NAMES[point.point_type.name], point.parameters[0])
                for point in points(result)
                if point.point_type.name in NAMES
            ]
            for number, result in enumerate(results)
        },
        points={str(number): len(points(result)) for number, result in enumerate(results)},
        reached={
            str(number): points(result)[-1].parameters[0] for number, result in enumerate(results)
        },
        final_state={
            str(number): list(points(result)[-1].state) for number, result in enumerate(results)
        },
    ).print()


if __name__ == "__main__":
    main()
