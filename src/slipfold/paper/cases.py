"""The cases and figures of the source paper, and more, from ``cases.toml``."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from slipfold.loci.window import Window
from slipfold.models.quantities import Parameter
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.results.attractors import Basins
from slipfold.results.trajectories import RegimeMap, Sweep


@dataclass(frozen=True)
class PlaneCase:
    """One bifurcation set."""

    model: SlidingOscillator  # the model; its values of `vary` play no part
    vary: tuple[str, str]  # names of the two parameters
    window: Window  # least and largest value of each

    @property
    def key(self) -> str:
        """Name for files."""
        return f"plane_{self.vary[0]}_{self.vary[1]}"


@dataclass(frozen=True)
class PlaneFigure:
    """The figure of a bifurcation set: its window and a part of it, magnified."""

    plane: PlaneCase  # the bifurcation set
    title: str  # what the first parameter is
    detail: Window  # the part of the window that is drawn once more
    wide: bool = False  # whether the detail is drawn below instead of on the right

    @property
    def key(self) -> str:
        """Name for files."""
        return f"bifurcation_set_{self.plane.vary[0]}_{self.plane.vary[1]}"

    @property
    def needs(self) -> tuple[PlaneCase, ...]:
        """All that must be computed before it can be drawn."""
        return (self.plane,)


@dataclass(frozen=True)
class CurveCase:
    """One response diagram; equal curves are computed once."""

    model: SlidingOscillator  # the model; its value of `vary` plays no part
    vary: str  # parameter followed
    span: tuple[float, float]  # its first and last value

    @property
    def key(self) -> str:
        """Name for files: the parameter followed and what differs from the base case."""
        return "_".join([self.vary, *changes(self.model, self.vary)])


@dataclass(frozen=True)
class Steady:
    """One steady response reached from zero initial conditions."""

    model: SlidingOscillator

    @property
    def key(self) -> str:
        """Name for files."""
        return "_".join(["simulation", *changes(self.model)])


Case = CurveCase | Steady | PlaneCase
"""What is computed as one piece."""


@dataclass(frozen=True)
class Row:
    """A family of curves, drawn as one row of panels."""

    curves: tuple[CurveCase, ...]
    member: str  # name of the parameter in which they differ
    common: tuple[str, ...] = ()  # names of the parameters set for all curves of the row
    # Range of the parameter followed that is drawn once more, magnified; None for no such panel
    detail: tuple[float, float] | None = None
    wide: bool = False  # whether its panels take the whole width, one below the other

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each curve, e.g. ``"0.4"``."""
        return tuple(value_text(curve.model, self.member)[0] for curve in self.curves)


@dataclass(frozen=True)
class Figure:
    """One figure of the paper."""

    number: int  # its number in the paper
    title: str  # what it shows
    rows: tuple[Row, ...]  # families of response curves
    spectra: tuple[Steady, ...] = ()  # steady responses whose spectra it shows

    @property
    def key(self) -> str:
        """Name for files."""
        return f"figure{self.number}"

    @property
    def curves(self) -> tuple[CurveCase, ...]:
        """All curves, row by row."""
        return tuple(curve for row in self.rows for curve in row.curves)

    @property
    def needs(self) -> tuple[CurveCase | Steady, ...]:
        """All that must be computed before it can be drawn."""
        return (*self.curves, *self.spectra)


@dataclass(frozen=True)
class Cases:
    """All that the paper shows or claims, and the bifurcation sets beyond it."""

    figures: tuple[Figure, ...]
    # Rows that a claim needs and no figure shows, by number of the claim
    further: tuple[tuple[int, Row], ...] = ()
    # Figures of bifurcation sets, which the paper does not have
    planes: tuple[PlaneFigure, ...] = ()

    @property
    def needs(self) -> tuple[Case, ...]:
        """All that must be computed, each once.

        The planes come first, since each takes longer than anything else; then the order is that
        of the paper.
        """
        planes = [figure.plane for figure in self.planes]
        drawn = [item for figure in self.figures for item in figure.needs]
        claimed = [curve for _, row in self.further for curve in row.curves]
        return tuple(dict.fromkeys([*planes, *drawn, *claimed]))

    @property
    def all_figures(self) -> tuple[Figure | PlaneFigure, ...]:
        """The figures of the paper and those beyond it."""
        return (*self.figures, *self.planes)

    def shown_in(self, curve: CurveCase) -> tuple[int, ...]:
        """Return the numbers of the figures that show a curve."""
        return tuple(figure.number for figure in self.figures if curve in figure.curves)

    def only(self, numbers: Iterable[int]) -> Cases:
        """Return the cases of some figures of the paper alone."""
        wanted = set(numbers)
        return Cases(tuple(figure for figure in self.figures if figure.number in wanted))


def _content() -> dict[str, Any]:
    return tomllib.loads(files("slipfold.paper").joinpath("cases.toml").read_text("utf-8"))


@cache
def read_cases() -> Cases:
    """Read the figures of the source paper and the bifurcation sets.

    >>> [figure.number for figure in read_cases().figures]
    [2, 3, 4, 5, 6, 7]
    """
    content = _content()
    figures = tuple(
        Figure(
            item["number"],
            item["title"],
            tuple(_row(row) for row in item["row"]),
            tuple(Steady(SlidingOscillator(**case["set"])) for case in item.get("spectrum", ())),
        )
        for item in content["figure"]
    )
    further = tuple((item["number"], _row(row)) for item in content["claim"] for row in item["row"])
    return Cases(figures, further, tuple(_plane(item) for item in content["plane"]))


def _row(content: Mapping[str, Any]) -> Row:
    common = content.get("set", {})
    [(member, values)] = content["family"].items()
    curves = []
    for value in values:
        model = SlidingOscillator(**common, **{member: value})
        unit = model.values[content["span_of"]] if "span_of" in content else 1.0
        first, last = content["span"]
        curves.append(CurveCase(model, content["vary"], (first * unit, last * unit)))
    detail = tuple(content["detail"]) if "detail" in content else None
    return Row(tuple(curves), member, tuple(common), detail, content.get("wide", False))


def _plane(content: Mapping[str, Any]) -> PlaneFigure:
    first, second = content["vary"]
    window, detail = (
        ((float(a), float(b)), (float(c), float(d)))
        for (a, b), (c, d) in (content["window"], content["detail"])
    )
    plane = PlaneCase(SlidingOscillator(), (first, second), window)
    return PlaneFigure(plane, content["title"], detail, content.get("wide", False))


def value_text(model: SlidingOscillator, name: str) -> tuple[str, str]:
    """Return the value of a parameter as figures show it, and its unit.

    >>> value_text(SlidingOscillator(Vd=0.4), "Vd")
    ('0.4', ' m/s')
    """
    parameter = model.parameter(name)
    value = model.values[name]
    if parameter.unit == "rad":
        return f"{math.degrees(value):.10g}", "°"
    return f"{value:.10g}", f" {parameter.unit}" if parameter.unit else ""


def equation_text(model: SlidingOscillator, name: str) -> str:
    """Return e.g. ``"$V_d$ = 0.4 m/s"``."""
    value, unit = value_text(model, name)
    return f"{model.parameter(name).symbol} = {value}{unit}"


def changes(model: SlidingOscillator, without: str = "") -> list[str]:
    """Return what differs from the base case, for names of files."""
    changed = [parameter for parameter in model.parameters if _changed(model, parameter, without)]
    texts = [(item.name, *value_text(model, item.name)) for item in changed]
    return [f"{name}{value}{'deg' * (unit == '°')}" for name, value, unit in texts] or ["base"]


def _changed(model: SlidingOscillator, parameter: Parameter, without: str) -> bool:
    value = model.values[parameter.name]
    same = math.isclose(value, parameter.default, rel_tol=1e-12, abs_tol=0.0)
    return parameter.name != without and not same


BOX = {"x": (-0.3, 0.3), "y": (-0.3, 0.3), "vx": (-10, 10), "vy": (-10, 10)}
"""Box of starting states."""

TRANSIENT, KEPT = 4000, 48
"""Forcing periods left out of sweeps, and stored."""


@dataclass(frozen=True)
class SweepCase:
    """Solutions swept up and down over part of a curve, and from some starts at each value."""

    curve: CurveCase
    span: tuple[float, float]
    points: int
    starts: int = 4

    @property
    def key(self) -> str:
        """Name for files."""
        return f"sweep_{self.curve.key}"

    def compute(self) -> Sweep:
        """Compute it."""
        from slipfold.computations.long_term import sweep

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
        from slipfold.computations.long_term import basins

        return basins(self.model, {"x": (-0.5, 0.5), "y": (-0.5, 0.5)}, points=self.points)


@dataclass(frozen=True)
class RegimeCase:
    """A map of regimes over part of a plane."""

    plane: PlaneCase
    window: Window
    points: tuple[int, int]

    @property
    def key(self) -> str:
        """Name for files."""
        return f"regimes_{self.plane.vary[0]}_{self.plane.vary[1]}"

    def compute(self) -> RegimeMap:
        """Compute it."""
        from slipfold.computations.long_term import regimes

        over = dict(zip(self.plane.vary, self.window, strict=True))
        return regimes(self.plane.model, over, points=self.points)


Motions = SweepCase | BasinCase | RegimeCase
"""What is computed as one piece."""


@dataclass(frozen=True)
class CompletedFigure:
    """A figure of the paper with tori and sampled solutions, a curve a row."""

    number: int  # that of the figure
    curves: tuple[CurveCase, ...]
    sweeps: tuple[SweepCase, ...]

    @property
    def key(self) -> str:
        """Name for files."""
        return f"figure{self.number}_completed"

    @property
    def needs(self) -> tuple[CurveCase | SweepCase, ...]:
        """All that must be computed before it can be drawn."""
        return (*self.curves, *self.sweeps)


@dataclass(frozen=True)
class HysteresisFigure:
    """A range with two responses, and their basins of attraction."""

    curve: CurveCase
    swept: SweepCase
    basins: tuple[BasinCase, ...]

    @property
    def key(self) -> str:
        """Name for files."""
        return "hysteresis"

    @property
    def needs(self) -> tuple[CurveCase | SweepCase | BasinCase, ...]:
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
    def needs(self) -> tuple[PlaneCase | RegimeCase, ...]:
        """All that must be computed before it can be drawn."""
        return (self.regimes.plane, self.regimes)


MotionFigure = CompletedFigure | HysteresisFigure | RegimeFigure

AnyFigure = Figure | PlaneFigure | MotionFigure


def motion_figures(cases: Cases) -> tuple[MotionFigure, ...]:
    """Read the figures of long-term behavior that belong to cases of the paper.

    >>> [figure.key for figure in motion_figures(read_cases())]
    ['figure2_completed', 'figure3_completed', 'hysteresis', 'regimes_f_Nd']
    """
    content = _content()
    curves = {figure.number: figure.curves for figure in cases.figures}
    planes = {figure.plane.vary: figure.plane for figure in cases.planes}
    result: list[MotionFigure] = [
        _completed(item, curves[item["number"]])
        for item in content["completed"]
        if item["number"] in curves
    ]
    sweeps = {
        each.curve: each
        for figure in result if isinstance(figure, CompletedFigure)
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
            result.append(HysteresisFigure(curve, swept, basins_))
    item = content["regimes"]
    if tuple(item["vary"]) in planes:
        first, second = item["window"]
        window = (first[0], first[1]), (second[0], second[1])
        points = item["points"][0], item["points"][1]
        result.append(RegimeFigure(RegimeCase(planes[*item["vary"]], window, points)))
    return tuple(result)


def _completed(item: Mapping[str, Any], curves: tuple[CurveCase, ...]) -> CompletedFigure:
    first, last = item["span"]
    sweeps = tuple(SweepCase(curve, (first, last), item["points"]) for curve in curves)
    return CompletedFigure(item["number"], curves, sweeps)
