"""What motions do in the planes and along the curves of the paper: cases and their figures."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

from slipfold.computations.long_term import basins, regimes, sweep
from slipfold.loci.window import Window
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.paper.cases import Cases, Curve, changes
from slipfold.paper.planes import Plane
from slipfold.results.attractors import Basins
from slipfold.results.trajectories import RegimeMap, Sweep

BOX = {"x": (-0.3, 0.3), "y": (-0.3, 0.3), "vx": (-10, 10), "vy": (-10, 10)}
"""Where motions begin that do not follow others."""

TRANSIENT, KEPT = 4000, 48
"""Forcing periods left out of sweeps, and kept."""


@dataclass(frozen=True)
class SweepCase:
    """Motions swept up and down over part of a curve, and from some starts at each value."""

    curve: Curve
    span: tuple[float, float]
    points: int
    starts: int = 4

    @property
    def key(self) -> str:
        """Name for files."""
        return f"sweep_{self.curve.key}"

    def compute(self) -> Sweep:
        """Compute it."""
        return sweep(
            self.curve.model, self.curve.vary, self.span, points=self.points, starts=self.starts,
            box=BOX, transient=TRANSIENT, periods=KEPT,
        )  # fmt: skip


@dataclass(frozen=True)
class BasinCase:
    """Basins on a plane of starts at rest."""

    model: SlidingOscillator
    points: int

    @property
    def key(self) -> str:
        """Name for files."""
        return "_".join(["basins", *changes(self.model)])

    def compute(self) -> Basins:
        """Compute it."""
        return basins(self.model, {"x": (-0.5, 0.5), "y": (-0.5, 0.5)}, points=self.points)


@dataclass(frozen=True)
class RegimeCase:
    """What motions do over part of a plane."""

    plane: Plane
    window: Window
    points: tuple[int, int]

    @property
    def key(self) -> str:
        """Name for files."""
        return f"regimes_{self.plane.vary[0]}_{self.plane.vary[1]}"

    def compute(self) -> RegimeMap:
        """Compute it."""
        over = dict(zip(self.plane.vary, self.window, strict=True))
        return regimes(self.plane.model, over, points=self.points)


Motions = SweepCase | BasinCase | RegimeCase
"""What is computed as one piece."""


@dataclass(frozen=True)
class CompletedFigure:
    """A figure of the paper with tori and what motions do besides, a curve a row."""

    number: int  # that of the figure
    curves: tuple[Curve, ...]
    sweeps: tuple[SweepCase, ...]

    @property
    def key(self) -> str:
        """Name for files."""
        return f"figure{self.number}_completed"

    @property
    def needs(self) -> tuple[Curve | SweepCase, ...]:
        """All that must be computed before it can be drawn."""
        return (*self.curves, *self.sweeps)


@dataclass(frozen=True)
class HysteresisFigure:
    """Two responses side by side, and from where each of them wins."""

    curve: Curve
    swept: SweepCase
    basins: tuple[BasinCase, ...]

    @property
    def key(self) -> str:
        """Name for files."""
        return "hysteresis"

    @property
    def needs(self) -> tuple[Curve | SweepCase | BasinCase, ...]:
        """All that must be computed before it can be drawn."""
        return (self.curve, self.swept, *self.basins)


@dataclass(frozen=True)
class RegimeFigure:
    """A map of regimes over its bifurcation set."""

    regimes: RegimeCase

    @property
    def key(self) -> str:
        """Name for files."""
        return self.regimes.key

    @property
    def needs(self) -> tuple[Plane | RegimeCase, ...]:
        """All that must be computed before it can be drawn."""
        return (self.regimes.plane, self.regimes)


MotionFigure = CompletedFigure | HysteresisFigure | RegimeFigure


def motion_figures(cases: Cases) -> tuple[MotionFigure, ...]:
    """Read the figures of motions that go with cases of the paper.

    >>> from slipfold.paper.cases import read_cases
    >>> [figure.key for figure in motion_figures(read_cases())]
    ['figure2_completed', 'figure3_completed', 'hysteresis', 'regimes_f_Nd']
    """
    content = tomllib.loads(files("slipfold.paper").joinpath("cases.toml").read_text("utf-8"))
    curves = {figure.number: figure.curves for figure in cases.figures}
    planes = {figure.plane.vary: figure.plane for figure in cases.planes}
    found: list[MotionFigure] = [
        _completed(item, curves[item["number"]])
        for item in content["completed"]
        if item["number"] in curves
    ]
    sweeps = {
        each.curve: each
        for figure in found if isinstance(figure, CompletedFigure)
        for each in figure.sweeps
    }  # fmt: skip
    hysteresis = content["hysteresis"]
    for curve, swept in sweeps.items():
        if curve.vary == hysteresis["vary"] and curve.model == SlidingOscillator(
            **hysteresis["set"]
        ):
            basins_ = tuple(
                BasinCase(curve.model.replace(**{curve.vary: value}), hysteresis["points"])
                for value in hysteresis["values"]
            )
            found.append(HysteresisFigure(curve, swept, basins_))
    item = content["regimes"]
    if tuple(item["vary"]) in planes:
        first, second = item["window"]
        window = (first[0], first[1]), (second[0], second[1])
        points = item["points"][0], item["points"][1]
        found.append(RegimeFigure(RegimeCase(planes[*item["vary"]], window, points)))
    return tuple(found)


def _completed(item: Mapping[str, Any], curves: tuple[Curve, ...]) -> CompletedFigure:
    first, last = item["span"]
    sweeps = tuple(SweepCase(curve, (first, last), item["points"]) for curve in curves)
    return CompletedFigure(item["number"], curves, sweeps)
