"""Compare what this tree computes with results that another tree saved.

    python bench/same_numbers.py make FOLDER [PART ...]       # in the tree before a change
    python bench/same_numbers.py compare FOLDER [PART ...]    # in the tree after it

About two hundred results of all kinds are saved as netCDF files. A part is the beginning of a
name, for example `response-` or `locus-`. Files are read with xarray alone, so that a defect of
`slipfold.load` hides nothing. Special points, ends and their counts must agree. The points of a
curve must agree where there are as many as before; where the steps differ this is said, and is no
failure.
"""

import argparse
import json
import math
import re
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
sys.path.insert(0, str(Path(__file__).parents[1] / "docs" / "gallery"))

import demos

import slipfold as sf
from helpers.foreign_systems import cases as foreign_cases

RELATIVE = 1e-9
"""What two runs of the same method may differ by, of the largest of a variable's values.

Rounding errors grow by the condition of an orbit; special points carry their own uncertainties.
"""

SPECIAL = 1e-12
"""The same of the values of special points, over what they are known to."""

STEPS = ("point", "locus_point", "sample")
"""Dimensions whose length the steps decide."""

LATER_NAMES: dict[str, str] = {
    "scattered": "uncertain",
    "scattered_units": "uncertain_units",
    **{
        f"scatter_{name}": f"uncertain_{name}"
        for name in (
            *("kind", "mean", "size", "low", "high", "gradient", "correlation"),
            *("first", "total", "first_error", "total_error"),
        )
    },
    "region_share": "region_fraction",
    "verdict": "classification",
    "strobe": "sample",
    "turns": "revolutions",
    "readings": "measured",
    "read": "predicted",
    "fitted_least": "fitted_lower_bound",
    "fitted_most": "fitted_upper_bound",
    **{f"begun_{name}": f"started_{name}" for name in ("kind", "reason", "value")},
}
"""Names of variables and dimensions in files of before, and what they are called now."""

LATER_TEXTS = {
    "born at": "emanates at",
    "born": "bifurcation",
    "birth": "bifurcation",
    "turns or sticks": "reverses or sticks",
    ", turns": ", reverses",
}
"""Words in texts of before, and what is said now; applied in this order."""

NOT_COMPARED = (
    *("computed", "seconds", "checked", "settings", "title", "output_long_name"),
    *("slipfold_version", "heyoka_version", "numpy_version", "python_version"),
    *("scipy_version", "xarray_version", "schema", "residual", "uncertainty", "processor"),
)
"""What names a run or measures rounding errors."""

NUMBER = re.compile(r"[-+]?\d+\.\d+(?:e[-+]?\d+)?")

SLIDING = sf.SlidingOscillator
BUILT_IN = sf.built_in_models()
BOX = {"q": (-3, 3), "v": (-3, 3)}

RESPONSES: dict[str, list[tuple[str, tuple[float, float], dict[str, Any]]]] = {
    "sliding": [
        ("Nd", (0, 0.98), {"f": 12.5}),
        ("Nd", (0, 0.3), {"f": 12.2}),
        ("Nd", (0, 0.2), {"f": 12.8, "alpha": 1.0}),
        ("f", (12.2, 12.8), {"Nd": 0.1}),
        ("Vd", (0.4, 1.2), {"f": 12.5, "Nd": 0.03}),
        ("alpha", (0.9, 1.1), {"f": 12.5, "Nd": 0.03}),
        ("mu", (0.3, 0.6), {"f": 12.5, "Nd": 0.04}),
    ],
    "steady-sliding": [("mu", (0.1, 0.6), {})],
    "duffing": [("W", (0.5, 1.5), {}), ("F", (0.05, 0.4), {}), ("d", (0.03, 0.2), {})],
    "lorenz": [("rho", (0, 30), {}), ("sigma", (5, 15), {}), ("beta", (1, 3), {})],
    "lure": [("a", (1, 3), {}), ("b", (0.8, 1.3), {})],
    "mathieu": [("h", (0.01, 0.2), {}), ("w", (1.8, 2.2), {"h": 0.1})],
    "pin-on-disc": [("mu", (0.05, 0.5), {}), ("V", (0.3, 1), {})],
    "roessler": [("c", (2, 4), {}), ("a", (0.1, 0.25), {})],
    "squeal": [("mu", (0.3, 0.9), {}), ("kc", (1, 2), {})],
    "stribeck": [("vd", (0.8, 2), {}), ("c", (0.05, 0.3), {})],
    "stuart-landau": [("r", (-0.5, 0.5), {}), ("w", (0.5, 2), {})],
    "vanderpol-free": [("mu", (0.5, 3), {})],
    "vanderpol": [("w", (0.95, 1.05), {}), ("a", (0.1, 0.5), {})],
    "chain": [("f", (0.2, 0.4), {}), ("level", (0.5, 1.5), {})],
}
"""Parameter, span and other values of responses of built-in models."""

SLOW = {
    *("lorenz_96-0", "lorenz_96-1", "friction_chain-0", "rub-0", "rub-1", "drum_brake-0"),
    *("tor", "chu", "pen"),
}
"""Systems that take tens of seconds."""


def mass(frequency: float, slip: float, stick: float) -> sf.Structure:
    """A mass on a floor, forced (Den Hartog 1931): x'' + x = cos(W t) - friction."""
    return sf.Structure(
        [[1.0]],
        None,
        [[1.0]],
        names="x",
        contacts=sf.FrictionContact("x", sf.Coulomb(mu_s=stick, mu_k=slip), load=1.0, Vd=0.0),
        forcing=sf.HarmonicForce("x", F=1.0),
        f=frequency / (2 * math.pi),
    )


def belt(law: sf.FrictionLaw, speed: float) -> sf.Structure:
    """A mass on a belt: k = m = 1, normal force 1."""
    contact = sf.FrictionContact("x", law, load=1.0, Vd=speed)
    return sf.Structure([[1.0]], None, [[1.0]], names="x", contacts=contact)


def doubling() -> sf.SpecialPoint:
    """The period doubling of the sliding oscillator at 12.5 Hz."""
    return sf.response(SLIDING(), vary="Nd", span=(0, 0.05), f=12.5).special[0]


def smooth_responses() -> Iterator[tuple[str, Callable[[], Any]]]:
    """Responses of built-in models, of demos of other programs and of systems of other fields."""
    for name, runs in RESPONSES.items():
        for vary, span, values in runs:
            label = "-".join(["response", name, vary, *map(str, values)])
            model = BUILT_IN[name]().replace(**values)
            yield label, lambda model=model, vary=vary, span=span: sf.response(model, vary, span)
    for name in demos.DEMOS:
        if name not in SLOW:
            yield f"response-demo-{name}", lambda name=name: demos.response(name)
    for case in foreign_cases():
        for method in case.methods if str(case) not in SLOW else ():
            yield (
                f"response-foreign-{case}-{method}",
                lambda case=case, method=method: case.response(method),
            )
    for method in ("shooting", "collocation"):
        settings = sf.Settings(discretization=method)
        yield (
            f"response-sliding-{method}",
            lambda settings=settings: sf.response(
                SLIDING(f=12.5), "Nd", (0, 0.2), settings=settings
            ),
        )
    for step in (0.01, 0.1, 1.0):
        settings = sf.Settings(steps=sf.Steps(largest=step))
        yield (
            f"response-sliding-step-{step}",
            lambda settings=settings: sf.response(
                SLIDING(f=12.5), "Nd", (0, 0.98), settings=settings
            ),
        )
    yield (
        "response-events",
        lambda: sf.response(SLIDING(f=12.5), "Nd", (0, 0.3), events=[sf.Event("x", 0.1)]),
    )
    yield "response-gradients", lambda: sf.response(SLIDING(f=12.5), "Nd", (0, 0.3), gradients=True)
    yield (
        "response-search",
        lambda: sf.response(BUILT_IN["duffing"](), "W", (1.0, 1.3), search=True),
    )
    yield (
        "response-tori",
        lambda: sf.response(BUILT_IN["vanderpol"](a=0.3, e=0.2), "w", (1, 1.03), tori=True),
    )


def sticking_responses() -> Iterator[tuple[str, Callable[[], Any]]]:
    """Responses with phases of stick."""
    for slip, stick in ((0.2, 0.2), (0.5, 0.5), (0.5, 0.8), (0.3, 0.35)):
        model = mass(0.6, slip, stick)
        yield (
            f"response-stick-mass-{slip}-{stick}",
            lambda model=model: sf.response(model, "f", (0.08, 0.12)),
        )
    for name, law in {
        "coulomb": sf.Coulomb(mu_s=0.8, mu_k=0.5),
        "rational": sf.RationalStribeck(mu_s=1.0, d=3.0),
    }.items():
        model = belt(law, 0.2)
        yield (
            f"response-stick-belt-{name}",
            lambda model=model: sf.response(model, "Vd", (0.2, 0.6), settled=True),
        )
    for pulsation, speed in ((0.3, 0.2), (0.5, 0.3)):
        law = sf.Coulomb(mu_s=0.5, mu_k=0.5)
        model = SLIDING(friction=law, f=12.5, Nd=pulsation, Vd=speed)
        yield (
            f"response-stick-plane-{pulsation}-{speed}",
            lambda model=model, load=pulsation: sf.response(model, "Nd", (load, load + 0.1)),
        )


def loci() -> Iterator[tuple[str, Callable[[], Any]]]:
    """Curves of special points in two parameters."""
    window = {"f": (12.3, 12.7), "Nd": (0, 0.1)}
    yield "locus-PD", lambda: sf.locus(doubling(), ("f", "Nd"), ((12.3, 12.7), (0, 0.1)))
    yield "locus-PD-mu", lambda: sf.locus(doubling(), ("mu", "Nd"), ((0.4, 0.6), (0, 0.1)))
    yield "locus-set", lambda: sf.bifurcation_set(SLIDING(), ("f", "Nd"), window, regimes=(3, 3))
    for name, vary, span, pair, box in (
        ("lorenz", "rho", (0, 30), ("rho", "sigma"), ((10, 30), (8, 12))),
        ("duffing", "W", (0.5, 1.5), ("W", "F"), ((0.8, 1.6), (0.1, 0.3))),
        ("squeal", "mu", (0.3, 0.9), ("mu", "kc"), ((0.2, 1), (1, 2))),
        ("stuart-landau", "r", (-0.5, 0.5), ("r", "w"), ((-1, 1), (0.5, 2))),
        ("mathieu", "h", (0.01, 0.2), ("w", "h"), ((1.8, 2.2), (0.01, 0.3))),
        ("chain", "f", (0.2, 0.4), ("f", "level"), ((0.2, 0.4), (0.5, 1.5))),
    ):
        yield (
            f"locus-{name}",
            lambda name=name, vary=vary, span=span, pair=pair, box=box: sf.locus(
                sf.response(BUILT_IN[name](), vary, span).special[-1], pair, box, switch=False
            ),
        )


def trajectories() -> Iterator[tuple[str, Callable[[], Any]]]:
    """Simulations and what is measured on long trajectories."""
    for name, build in BUILT_IN.items():
        periods = (20,) if build().forced else ()
        yield (
            f"simulate-{name}",
            lambda build=build, periods=periods: sf.simulate(build(), *periods),
        )
    for load in (0.02, 0.05, 0.1, 0.15):
        yield (
            f"simulate-sliding-{load}",
            lambda load=load: sf.simulate(SLIDING(), 200, f=12.2, Nd=load),
        )
    for slip, stick in ((0.2, 0.2), (0.5, 0.8)):
        model = mass(0.6, slip, stick)
        yield f"simulate-mass-{slip}-{stick}", lambda model=model: sf.simulate(model, 20)
    for speed in (0.2, 0.5):
        model = belt(sf.Coulomb(mu_s=0.8, mu_k=0.5), speed)
        yield f"simulate-belt-{speed}", lambda model=model: sf.simulate(model, 50)
    yield "simulate-limit", lambda: sf.simulate(SLIDING(), 20, {"y": -0.99995})
    for load in (0.02, 0.05, 0.15):
        yield f"lyapunov-{load}", lambda load=load: sf.lyapunov(SLIDING(), f=12.5, Nd=load)
    yield "lyapunov-free", lambda: sf.lyapunov(BUILT_IN["vanderpol-free"]())
    duffing = BUILT_IN["duffing"](W=1.2)
    yield "attractors-duffing", lambda: sf.attractors(duffing, BOX, starts=16)
    yield "attractors-free", lambda: sf.attractors(BUILT_IN["vanderpol-free"](), starts=8)
    yield "basins-duffing", lambda: sf.basins(duffing, BOX, points=(6, 5))
    box = {"phase": (0, 1), "v": (-4, 4)}
    yield "basins-phase", lambda: sf.basins(duffing, box, points=(4, 5))
    yield (
        "fractions-duffing",
        lambda: sf.basin_fractions(BUILT_IN["duffing"](), "W", (1, 1.4), BOX, points=3, starts=32),
    )
    rest = {"points": 5, "starts": 1, "transient": 200, "periods": 32}
    yield "sweep-sliding", lambda: sf.sweep(SLIDING(f=12.2), "Nd", (0.05, 0.15), **rest)
    window = {"f": (12.2, 12.21), "Nd": (0.06, 0.16)}
    yield "regimes-sliding", lambda: sf.regimes(SLIDING(), window, points=(2, 3))


def designs() -> Iterator[tuple[str, Callable[[], Any]]]:
    """Uncertainties, designs, fits, maps and studies."""
    distributions = {"mu": "normal 5%", "Vd": "uniform 1%"}
    yield (
        "uncertainty",
        lambda: sf.uncertainty(
            doubling(), distributions, samples=32, loads=[0.0434, "50mN"], indices=True
        ),
    )
    bounds = {"Vd": (0.4, 0.8)}
    yield "design", lambda: sf.design(doubling(), bounds, above=["50mN"], load="20mN")
    forces = [0.01, 0.02, 0.03, 0.04]
    yield (
        "fit",
        lambda: sf.fit(
            SLIDING(f=12.5),
            sf.measure(SLIDING(f=12.5, mu=0.46), "Nd", forces, ["max y"]),
            {"mu": (0.3, 0.7)},
        ),
    )
    outputs, fitted = ["max y", "max x"], ["mu", "Vd"]
    yield (
        "plan",
        lambda: sf.plan_measurement(SLIDING(f=12.5), "Nd", forces, outputs, fitted, errors=1e-4),
    )
    over = {"Vd": [0.4, 0.6, 1.0], "alpha": ["30deg", "60deg"]}
    yield "map", lambda: sf.threshold_map(SLIDING(f=12.5), "Nd", over=over, span=(0, 0.05))
    threshold = {"what": "threshold", "vary": "Nd", "span": [0, 0.9]}
    response = {"what": "response", "vary": "Nd", "span": [0, 0.1]}
    grid = {"grid": {"Vd": [0.5, 0.6, 0.7], "alpha": [1.0, 1.05]}}
    for label, compute in {"threshold": threshold, "response": response}.items():
        given = {"model": "sliding", "parameters": {"f": 12.5}, "compute": compute, "cases": grid}
        yield f"study-{label}", lambda given=given: sf.study(given)
    drawn = {
        "sample": "saltelli",
        "count": 4,
        "distributions": {"mu": "normal 2%", "Vd": "normal 2%"},
    }
    given = {"model": "sliding", "parameters": {"f": 12.5, "Nd": 0.02}, "cases": drawn}
    yield "study-drawn", lambda: sf.study(given | {"compute": {"what": "simulation"}})


def cases() -> dict[str, Callable[[], Any]]:
    """All computations by name."""
    families = (smooth_responses, sticking_responses, loci, trajectories, designs)
    return {name: work for family in families for name, work in family()}


def make(folder: Path, names: list[str]) -> None:
    """Save results; what fails is saved as its sentence."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        target = folder / f"{name}.nc"
        if target.exists() or target.with_suffix(".txt").exists():
            continue
        begun = time.process_time()
        save(cases()[name], target)
        print(f"{name}: {time.process_time() - begun:.1f} s", flush=True)


def save(work: Callable[[], Any], target: Path) -> None:
    """Compute one result and save it, or the sentence of its failure."""
    try:
        work().save(target)
    except Exception as error:  # the sentence is what is compared
        target.with_suffix(".txt").write_text(f"{type(error).__name__}: {error}\n")


@dataclass
class Differences:
    """What differs between two files."""

    serious: list[str]
    steps: list[str]


def compare_files(before: Path, after: Path) -> Differences:
    """Compare two saved results."""
    old, new = xr.load_dataset(before), xr.load_dataset(after)
    renamed = {
        name: LATER_NAMES[name] for name in [*old.variables, *old.dims] if name in LATER_NAMES
    }
    old = old.rename(renamed)
    found = Differences([], [])
    for size in sorted(set(old.sizes) | set(new.sizes), key=str):
        lengths = old.sizes.get(size, 0), new.sizes.get(size, 0)
        if lengths[0] != lengths[1]:
            text = f"{size}: {lengths[0]} before, {lengths[1]} now"
            (found.steps if size in STEPS else found.serious).append(text)
    for name in sorted(set(old.variables) ^ set(new.variables), key=str):
        found.serious.append(f"{name} is {'new' if name in new.variables else 'missing'}")
    for name in sorted(set(old.variables) & set(new.variables), key=str):
        if not any(word in str(name) for word in NOT_COMPARED):
            compare_variables(str(name), old, new, found)
    for name in sorted(set(old.attrs) & set(new.attrs)):
        if name not in NOT_COMPARED and not same_attribute(old.attrs[name], new.attrs[name]):
            found.serious.append(
                f"attribute {name}: {old.attrs[name]!s:.80} {new.attrs[name]!s:.80}"
            )
    return found


def compare_variables(name: str, old: xr.Dataset, new: xr.Dataset, found: Differences) -> None:
    """Compare one variable; its scale is the largest of its values."""
    before, after = old[name].values, new[name].values
    if before.shape != after.shape:
        if not set(old[name].dims) & set(STEPS):
            found.serious.append(f"{name}: shape {before.shape} before, {after.shape} now")
        return
    if before.dtype.kind not in "fc":
        pairs = zip(before.ravel(), after.ravel(), strict=True)
        unequal = [pair for pair in pairs if not same_text(*map(str, pair))]
        if unequal:
            found.serious.append(f"{name}: {unequal[0][0]!s:.60} before, {unequal[0][1]!s:.60} now")
        return
    if not before.size or np.array_equal(before, after, equal_nan=True):
        return
    if not np.array_equal(np.isfinite(before), np.isfinite(after)):
        found.serious.append(f"{name}: other values are finite than before")
        return
    finite = np.isfinite(before)
    error = np.abs(np.where(finite, after - before, 0))
    scale = np.max(np.abs(before), where=finite, initial=0)
    allowed = RELATIVE * scale
    if name == "special_value" and "special_uncertainty" in old:
        allowed = SPECIAL * scale + 3 * np.abs(old["special_uncertainty"].values)
    if np.any(error > allowed):
        moved = old[name].dims and set(old[name].dims) & set(STEPS)
        text = f"{name}: differs by {np.max(error):.1e} of {scale:.1e}"
        (found.steps if moved else found.serious).append(text)


def same_text(before: str, after: str) -> bool:
    """Whether two texts agree, numbers in them to rounding."""
    for old, new in LATER_TEXTS.items():
        before = before.replace(old, new)
    if before == after:
        return True
    numbers = [np.array(NUMBER.findall(text), float) for text in (before, after)]
    words = [NUMBER.sub("", text) for text in (before, after)]
    return words[0] == words[1] and np.allclose(*numbers, rtol=RELATIVE, atol=0)


def same_attribute(before: Any, after: Any) -> bool:
    """Whether two attributes say the same, numbers to rounding."""
    if isinstance(before, str) and isinstance(after, str):
        try:
            return same_attribute(json.loads(before), json.loads(after))
        except ValueError:
            return same_text(before, after)
    if isinstance(before, dict) and isinstance(after, dict):
        before = {LATER_NAMES.get(key, key): value for key, value in before.items()}
        return before.keys() == after.keys() and all(
            key in NOT_COMPARED or same_attribute(before[key], after[key]) for key in before
        )
    if isinstance(before, list) and isinstance(after, list):
        return len(before) == len(after) and all(map(same_attribute, before, after))
    try:
        return bool(np.allclose(before, after, rtol=RELATIVE, atol=1e-12, equal_nan=True))
    except TypeError:
        return bool(np.all(before == after))


def compare(folder: Path, names: list[str], now: Path) -> int:
    """Compute each result again, save it beside and print what differs; the number that do."""
    now.mkdir(parents=True, exist_ok=True)
    differing = 0
    for name in names:
        before, after = folder / f"{name}.nc", now / f"{name}.nc"
        if not before.exists() and not before.with_suffix(".txt").exists():
            print(f"{name}: not made before")
            continue
        for path in (after, after.with_suffix(".txt")):
            path.unlink(missing_ok=True)
        save(cases()[name], after)
        if before.exists() and after.exists():
            result = compare_files(before, after)
        else:
            sentences = [
                path.with_suffix(".txt").read_text().strip() if not path.exists() else "a result"
                for path in (before, after)
            ]
            different = sentences[0] != sentences[1]
            result = Differences([" -> ".join(sentences)] if different else [], [])
        differing += bool(result.serious)
        state = "DIFFERS" if result.serious else "other steps" if result.steps else "same"
        print(f"{name}: {state}")
        for line in (*result.serious[:8], *result.steps[:4]):
            print(f"    {line}", flush=True)
    return differing


def main() -> None:
    """Make or compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("action", choices=("make", "compare", "list"))
    parser.add_argument("folder", type=Path, help="where the results of before are")
    parser.add_argument("parts", nargs="*", help="beginnings of names (default: all)")
    parser.add_argument("--now", type=Path, help="folder of the new results (default FOLDER-now)")
    options = parser.parse_args()
    parts = tuple(options.parts) or ("",)
    names = [name for name in cases() if name.startswith(parts)]
    if options.action == "list":
        print("\n".join(names))
    elif options.action == "make":
        make(options.folder, names)
    else:
        now = options.now or options.folder.with_name(options.folder.name + "-now")
        differing = compare(options.folder, names, now)
        print(f"{differing} of {len(names)} differ")
        raise SystemExit(1 if differing else 0)


if __name__ == "__main__":
    main()
