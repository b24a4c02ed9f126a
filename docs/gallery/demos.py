"""Demos of AUTO-07p and tutorials of BifurcationKit: what is followed, and what was measured."""

from __future__ import annotations

import json
import math
import shlex
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from comparison import Comparison

import slipfold as sf

FOLDER = Path(__file__).parent / "coming_from"
MEASURED = FOLDER / "measured.json"
"""Written by `python bench/gallery_demos.py`."""

BUILT_IN = {"tor": "freire"}
"""Demos whose equations slipfold has."""

WITHIN = 1e-4
"""AUTO's demos ask for points to a relative 1e-4 on meshes of 15 to 90 intervals."""


@dataclass(frozen=True)
class Demo:
    """What is followed in a system."""

    vary: str
    span: tuple[float, float]
    start: Mapping[str, float] = field(default_factory=dict)
    settled: bool = False
    options: Mapping[str, object] = field(default_factory=dict)


ONE = {"largest_period": 1}

DEMOS = {
    "ab": Demo("p", (0, 0.25)),
    "tor": Demo("n", (-0.4, -0.9), options=ONE),
    "plp": Demo("rho", (2.021628, 6), options=ONE),
    "chu": Demo("alpha", (5, 16), {"x": 1.4994, "y": 0, "z": -1.4994}, options=ONE),
    "pen": Demo("I", (0.4, 0.12), settled=True, options={"largest_period": 2}),
    "kpr": Demo(
        "lambda",
        (-1.6, -1.86),
        {"x": -1.25, "y": -1.25, "z": -1.25},
        options=ONE | {"discretization": "collocation"},
    ),
    "lor": Demo("rho", (280, 200), settled=True, options={"largest_period": 4}),
    "pp2": Demo("quota", (0, 1)),
    "abc": Demo("D", (0, 0.4), options=ONE),
    "frc": Demo("W", (100, 6.283185307179586), options=ONE),
    "co": Demo("q2", (0.6, 1.9), options={"largest_period": 0}),
    "lorenz84": Demo("F", (3, -1.5), options={"largest_period": 0}),
    "steinmetz": Demo("k8", (1.2, 0.5), options=ONE),
}


def model(name: str) -> sf.Model:
    """Make the model of a system."""
    if name in BUILT_IN:
        return sf.built_in_models()[BUILT_IN[name]]()
    return sf.System(tomllib.loads((FOLDER / "systems" / f"{name}.toml").read_text()))


def response(name: str) -> sf.Diagram:
    """Follow a system as `DEMOS` says."""
    demo = DEMOS[name]
    return sf.response(
        model(name),
        vary=demo.vary,
        span=demo.span,
        start=demo.start or None,
        settled=demo.settled,
        settings=sf.Settings(**demo.options),
    )


def command(name: str) -> str:
    """The same as a command."""
    demo = DEMOS[name]
    words = ["slipfold", "response", BUILT_IN.get(name, f"{name}.toml")]
    words += ["--vary", f"{demo.vary}={demo.span[0]:.8g}:{demo.span[1]:.8g}"]
    for state, value in demo.start.items():
        words += ["--start", f"{state}={value:g}"]
    words += ["--settled"] * demo.settled
    for option, value in demo.options.items():
        words += [f"--{option.replace('_', '-')}", f"{value}"]
    return shlex.join(words)


def own_points(diagram: sf.Diagram) -> list[tuple[str, float]]:
    """Types and values of all special points, mirror images and doubly listed ones once."""
    found: dict[tuple[str, str], float] = {}
    for branch in diagram.branches:
        for point in branch.special:
            found.setdefault((point.type, f"{point.value:.9g}"), point.value)
    return [(kind, value) for (kind, _), value in found.items()]


def match(ours: Iterable[tuple[str, float]], kind: str, value: float) -> float | None:
    """Our value of a point that AUTO reports, None if there is none within AUTO's accuracy."""
    same = [own for own_kind, own in ours if own_kind == kind]
    nearest = min(same, key=lambda own: abs(own - value), default=None)
    if nearest is None or abs(nearest - value) > WITHIN * max(1.0, abs(value)):
        return None
    return nearest


def machine() -> str:
    """What the measurements ran on."""
    return measured()["machine"]


def measured() -> dict:
    """What was measured of all systems in one run."""
    return json.loads(MEASURED.read_text())


def mistaken(ours: Iterable[tuple[str, float]], ends: Iterable[float], value: float) -> bool:
    """Whether AUTO takes a Hopf point, or a homoclinic orbit where a branch ends, for a point."""
    places = [own for kind, own in ours if kind == "HB"] + list(ends)
    return any(abs(own - value) <= WITHIN for own in places)


def compare(table: Comparison, name: str, diagram: sf.Diagram | None = None) -> None:
    """Add the points that AUTO reports, each once; one that is not ours has no number.

    Beside those of a diagram, or else those that `slipfold` found when the two were measured.
    """
    entry = measured()["systems"][name]
    ours, ends = entry["ours"]["points"], entry["ours"]["ends"]
    if diagram is not None:
        ours = own_points(diagram)
        ends = [branch.parameter[-1] for branch in diagram.branches]
    rows = set()
    for kind, value in entry["theirs"]["points"]:
        own = match(ours, kind, value)
        if (own is None and mistaken(ours, ends, value)) or (own and (kind, own) in rows):
            continue
        rows.add((kind, own))
        table.add(
            f"{name}: {kind} {DEMOS[name].vary}",
            math.nan if own is None else own,
            f"{value:.10g}",
            "AUTO-07p, run here",
            WITHIN * max(1.0, abs(value)),
        )


class Times(Comparison):
    """How many points each program found, and how long it took."""

    HEAD = ("system", "points", "AUTO's", "AUTO's that are ours", "slipfold", "AUTO-07p", "ratio")

    def __init__(self, names: Iterable[str]) -> None:
        """Read what was measured."""
        data = measured()
        self.times = [self._row(name, data["systems"][name]) for name in names]

    @staticmethod
    def _row(name: str, entry: dict) -> tuple[str, ...]:
        ours, theirs = entry["ours"], entry["theirs"]
        agree = sum(match(ours["points"], *point) is not None for point in theirs["points"])
        return (
            name,
            f"{len(ours['points'])}",
            f"{len(theirs['points'])}",
            f"{agree}",
            f"{ours['seconds']:.3g} s",
            f"{theirs['seconds']:.3g} s",
            f"{ours['seconds'] / theirs['seconds']:.2g}",
        )

    def _cells(self) -> list[tuple[str, ...]]:
        return [self.HEAD, *self.times]
