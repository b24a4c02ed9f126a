"""The cases and figures of the source paper, and more, from ``cases.toml``."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

from slipfold.models.sliding_oscillator import SlidingOscillator

Interval = tuple[float, float]

BOX = {"x": (-0.3, 0.3), "y": (-0.3, 0.3), "vx": (-10, 10), "vy": (-10, 10)}
"""Box of starting states of sweeps."""

REST = {"x": (-0.5, 0.5), "y": (-0.5, 0.5)}
"""Plane of starting states of basins."""

PERIODS = 1500
"""Forcing periods from rest until the response is taken as steady."""

TRANSIENT, STORED = 4000, 48
"""Forcing periods left out of sweeps, and stored."""

PREFIXES = {"response": (), "bifurcation_set": ("plane",), "spectrum": ("simulation",)}
"""Beginnings of names of files, where they are not the kind."""


@dataclass(frozen=True)
class Case:
    """One computation; equal ones are computed once."""

    kind: str  # "response", "spectrum", "bifurcation_set", "sweep", "basins" or "regimes"
    model: SlidingOscillator  # its values of `vary` have no effect
    vary: tuple[str, ...] = ()  # names of the parameters that are varied
    spans: tuple[Interval, ...] = ()  # first and last value of each
    points: tuple[int, ...] = ()  # number of values along each axis
    starts: int = 4  # of a sweep, at each value

    @property
    def key(self) -> str:
        """Name for files: the parameters varied, and what differs from the base case."""
        changed = changes(self.model, self.vary) if len(self.vary) < 2 else []
        return "_".join([*PREFIXES.get(self.kind, (self.kind,)), *self.vary, *changed])

    def compute(self, *, tori: bool = False) -> Any:
        """Compute it; of a response with its tori on request."""
        from slipfold.computations import loci, long_term
        from slipfold.computations.response import response

        if self.kind == "spectrum":
            return long_term.simulate(self.model, PERIODS).spectrum()
        if self.kind == "basins":
            return long_term.basins(self.model, REST, points=self.points[0])
        if self.kind == "regimes":
            plane = dict(zip(self.vary, self.spans, strict=True))
            return long_term.regimes(self.model, plane, points=(self.points[0], self.points[1]))
        if self.kind == "bifurcation_set":
            names, window = (self.vary[0], self.vary[1]), (self.spans[0], self.spans[1])
            return loci.bifurcation_set(self.model, names, window)
        (vary,), (span,) = self.vary, self.spans
        if self.kind == "response":
            return response(self.model, vary, span, tori=tori)
        return long_term.sweep(
            self.model, vary, span, points=self.points[0], starts=self.starts,
            box=BOX, transient=TRANSIENT, periods=STORED,
        )  # fmt: skip


@dataclass(frozen=True)
class Row:
    """A family of curves, drawn as one row of panels."""

    curves: tuple[Case, ...]
    member: str  # name of the parameter in which they differ
    common: tuple[str, ...] = ()  # names of the parameters set for all curves of the row
    # Range of the parameter followed that is drawn once more, magnified; None for no such panel
    detail: Interval | None = None
    wide: bool = False  # whether its panels take the whole width, one below the other

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each curve, e.g. ``"0.4"``."""
        return tuple(value_text(curve.model, self.member)[0] for curve in self.curves)


@dataclass(frozen=True)
class Figure:
    """One figure: the cases that it shows, and how."""

    key: str  # name for files
    kind: str  # "family", "plane", "completed", "hysteresis" or "regimes"
    title: str = ""
    number: int = 0  # number in the paper; 0: not in the paper
    rows: tuple[Row, ...] = ()  # families of response curves
    cases: tuple[Case, ...] = ()  # further cases
    detail: tuple[Interval, Interval] | None = None  # part of a plane that is drawn once more
    wide: bool = False  # whether the detail is drawn below instead of on the right

    @property
    def needs(self) -> tuple[Case, ...]:
        """All that must be computed before it can be drawn."""
        return (*(curve for row in self.rows for curve in row.curves), *self.cases)

    def of_kind(self, kind: str) -> tuple[Case, ...]:
        """Return the cases of one kind."""
        return tuple(case for case in self.needs if case.kind == kind)


@dataclass(frozen=True)
class Cases:
    """All that the paper shows or claims, and the figures beyond it."""

    figures: tuple[Figure, ...]
    # Rows that a claim needs and no figure shows, by number of the claim
    further: tuple[tuple[int, Row], ...] = ()

    @property
    def needs(self) -> tuple[Case, ...]:
        """All that must be computed, each once; planes first, as they take longest."""
        drawn = [case for figure in self.figures for case in figure.needs]
        claimed = [curve for _, row in self.further for curve in row.curves]
        planes = [case for case in drawn if case.kind == "bifurcation_set"]
        return tuple(dict.fromkeys([*planes, *drawn, *claimed]))

    def of_kind(self, kind: str) -> tuple[Figure, ...]:
        """Return the figures of one kind."""
        return tuple(figure for figure in self.figures if figure.kind == kind)

    def shown_in(self, curve: Case) -> tuple[int, ...]:
        """Return the numbers of the paper's figures that show a curve."""
        shown = (figure for figure in self.figures if figure.number and curve in figure.needs)
        return tuple(figure.number for figure in shown)

    def only(self, numbers: Iterable[int]) -> Cases:
        """Return the cases of some figures of the paper alone."""
        wanted = set(numbers)
        return Cases(tuple(figure for figure in self.figures if figure.number in wanted))


def read_cases(*, long_term: bool = False) -> Cases:
    """Read the figures of the source paper, the bifurcation sets and, on request, long-term ones.

    >>> [figure.number for figure in read_cases().of_kind("family")]
    [2, 3, 4, 5, 6, 7]
    >>> [figure.key for figure in read_cases(long_term=True).figures[-4:]]
    ['figure2_completed', 'figure3_completed', 'hysteresis', 'regimes_f_Nd']
    """
    content = tomllib.loads(
        files("slipfold.interface.paper").joinpath("cases.toml").read_text("utf-8")
    )
    figures = [
        Figure(
            f"figure{item['number']}",
            "family",
            item["title"],
            item["number"],
            tuple(map(_row, item["row"])),
            tuple(
                Case("spectrum", SlidingOscillator(**case["set"]))
                for case in item.get("spectrum", ())
            ),
        )
        for item in content["figure"]
    ]
    figures += map(_plane, content["plane"])
    if long_term:
        figures += _long_term(content, figures)
    further = tuple((item["number"], _row(row)) for item in content["claim"] for row in item["row"])
    return Cases(tuple(figures), further)


def _row(content: Mapping[str, Any]) -> Row:
    common = content.get("set", {})
    [(member, values)] = content["family"].items()
    curves = []
    for value in values:
        model = SlidingOscillator(**common, **{member: value})
        unit = model.values[content["span_of"]] if "span_of" in content else 1.0
        first, last = content["span"]
        curves.append(Case("response", model, (content["vary"],), ((first * unit, last * unit),)))
    detail = tuple(content["detail"]) if "detail" in content else None
    return Row(tuple(curves), member, tuple(common), detail, content.get("wide", False))


def _window(content: Any) -> tuple[Interval, Interval]:
    (a, b), (c, d) = content
    return (float(a), float(b)), (float(c), float(d))


def _plane(item: Mapping[str, Any]) -> Figure:
    vary = tuple(item["vary"])
    plane = Case("bifurcation_set", SlidingOscillator(), vary, _window(item["window"]))
    return Figure(
        "_".join(["bifurcation_set", *vary]), "plane", item["title"], cases=(plane,),
        detail=_window(item["detail"]), wide=item.get("wide", False),
    )  # fmt: skip


def _long_term(content: Mapping[str, Any], figures: Iterable[Figure]) -> list[Figure]:
    """Return the figures of long-term behavior, which use cases of other figures."""
    curves = {figure.number: figure.of_kind("response") for figure in figures}
    planes = {case.vary: case for figure in figures for case in figure.of_kind("bifurcation_set")}
    result, sweeps = list[Figure](), dict[Case, Case]()
    for item in content["completed"]:
        own = curves[item["number"]]
        span, points = (tuple(item["span"]),), (item["points"],)
        sweeps |= {curve: Case("sweep", curve.model, curve.vary, span, points) for curve in own}
        cases = (*own, *(sweeps[curve] for curve in own))
        result.append(Figure(f"figure{item['number']}_completed", "completed", cases=cases))
    item = content["hysteresis"]
    model = SlidingOscillator(**item["set"])
    curve = next(case for case in sweeps if case.model == model and case.vary == (item["vary"],))
    basins = [
        Case("basins", model.replace(**{item["vary"]: value}), points=(item["points"],))
        for value in item["values"]
    ]
    cases = (curve, sweeps[curve], *basins)
    item = content["regimes"]
    plane = planes[tuple(item["vary"])]
    window, points = _window(item["window"]), tuple(item["points"])
    regimes = Case("regimes", plane.model, plane.vary, window, points)
    return [
        *result,
        Figure("hysteresis", "hysteresis", cases=cases),
        Figure(regimes.key, "regimes", cases=(plane, regimes)),
    ]


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


def changes(model: SlidingOscillator, without: Iterable[str] = ()) -> list[str]:
    """Return what differs from the base case, for names of files."""
    texts = [
        (item.name, *value_text(model, item.name))
        for item in model.parameters
        if item.name not in without
        and not math.isclose(model.values[item.name], item.default, rel_tol=1e-12, abs_tol=0.0)
    ]
    return [f"{name}{value}{'deg' * (unit == '°')}" for name, value, unit in texts] or ["base"]
