"""Response diagrams: branches, tori, special points and measurements over a parameter."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.lines import Line2D

from slipfold.arrays import Array
from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.tori.torus_branch import TorusBranch
from slipfold.errors import InputError
from slipfold.lines import (
    OTHER,
    STABLE,
    STUCK,
    branch_segments,
    check_measure,
    is_level,
    level_unit,
    measured_along,
    measured_at,
    parts_of,
    torus_segments,
)
from slipfold.models.model import Model
from slipfold.parameter_space.measurement import Measurement, parse_measured
from slipfold.plots.labels import Label, place_labels
from slipfold.plots.style import (
    LINES,
    MARKERS,
    MEASURE_NAMES,
    axes_or_new,
    label_output,
    palette,
    settle,
    within,
)
from slipfold.plots.trajectories import COLORS, OTHERS, draw_points
from slipfold.results.diagram import Diagram
from slipfold.results.measured import Fit, MeasurementPlan
from slipfold.results.trajectories import Sweep

MEASURED = "#c2410c"
"""Color of measurements: no branch has it, and in gray it is darker than paper."""

SWEEPS = {
    "up": ("measured, upward", MEASURED, 2.8),
    "down": ("measured, downward", "none", 5.0),
    "": ("measured", MEASURED, 2.8),
}
"""Name, color and size of measurements by how the parameter reached its value."""

CROWDED = 9.0
"""Distance in points below which points of one type share a name: half the width of the name."""

TORI = {STABLE: "torus", OTHER: "unstable torus"}

BREAKS = ("broken", "failed", "heteroclinic", "homoclinic", "points", "resonance")
"""Kinds of ends at which tori are marked as not followed further."""


@dataclass(frozen=True)
class Mark:
    """A point with a marker: a bifurcation, an event, a limit or a failure."""

    type: str  # key of `MARKERS`
    name: str  # text next to it
    parameter: float
    value: float
    fill: str = "full"  # "open" of a subcritical bifurcation, "pale" where that is not known


def draw_response(
    diagram: Diagram,
    output: str | None = None,
    measure: str = "max",
    ax: Axes | None = None,
    color: str = "black",
    annotate: bool = True,
    measured: Measurement | None = None,
    under: Sweep | None = None,
) -> Axes:
    """Draw one response diagram, with a measurement or a sweep `under` it if they are given.

    Lines of stable and of neutral (undamped) orbits are solid, those of orbits that are unstable by
    a period doubling dashed, by a fold or a torus bifurcation dotted. A subcritical point has an
    open marker, one of which that is not known a pale one. Tori are drawn lighter.
    """
    output = output or _first_output(diagram)
    if under is not None:
        for part in parts_of(measure):
            ax = draw_points(under, output, part, ax, legend=False)
    ax = draw_family([diagram], output, measure, ax, [color])
    handles: list[Any] = torus_handles(diagram.tori, color) if measure != STUCK else []
    if under is not None:
        handles += _sweep_handles(under)
    if measured is not None:
        vary = _curves([diagram])[0].vary
        if measured.vary != vary:
            raise InputError(
                f"{measured.vary} was varied in the measurement but the diagram is over {vary}; "
                f"follow the response over {measured.vary}"
            )
        draw_measured(ax, measured, measure, output)
        handles += ax.get_legend_handles_labels()[0]
    if handles:
        ax.legend(handles=handles)
    if annotate:
        name_family(ax, [diagram], None, output, measure, [color])
    return ax


def _first_output(diagram: Diagram) -> str:
    """Return the first of what is shown that is not a revolving angle, else the first."""
    names = _curves([diagram])[0].model.shown
    turning = {
        name for branch in diagram.branches for name, count in branch.revolutions.items() if count
    }
    return next((name for name in names if name not in turning), names[0])


def _curves(diagrams: Sequence[Diagram]) -> list[Any]:
    curves = [item for each in diagrams for item in (*each.branches, *each.tori)]
    if not curves:
        raise InputError("the diagram has 0 branches, so there is nothing to draw; give at least 1")
    return curves


def draw_family(
    diagrams: Sequence[Diagram],
    output: str = "x",
    measure: str = "max",
    ax: Axes | None = None,
    colors: Sequence[str] | None = None,
) -> Axes:
    """Draw several response diagrams into one picture; `name_family` adds the names."""
    first = _curves(diagrams)[0]
    check_measure([branch for each in diagrams for branch in each.branches], measure)
    ax = axes_or_new(ax)
    if measure == STUCK:
        ax.set_ylabel("fraction of the period in which a contact sticks")
    elif is_level(measure):
        ax.set_ylabel(f"level of {output} ({level_unit(first.model, output, measure)})")
    else:
        words = " and ".join(MEASURE_NAMES.get(part, part) for part in parts_of(measure))
        label_output(ax, "y", first.model, output, words)
    colors = palette(len(diagrams)) if colors is None else colors
    colored = list(zip(diagrams, colors, strict=True))
    for diagram, color in colored:
        _draw_branches(ax, diagram, output, measure, color, families=False)
        _draw_tori(ax, diagram.tori, output, measure, color)
    # The ordinate fits all but families, which have cycles of every amplitude.
    fitted = ax.dataLim.frozen()
    for diagram, color in colored:
        _draw_branches(ax, diagram, output, measure, color, families=True)
    if fitted.height > 0:
        ax.dataLim.intervaly = fitted.intervaly
    # Markers lie on top of all lines.
    for diagram, color in colored:
        faces = {"full": color, "pale": _lighter(color), "open": "white"}
        for mark in marks_in(diagram, output, measure):
            ax.plot(
                mark.parameter, mark.value, linestyle="none", marker=MARKERS[mark.type],
                color=color, markerfacecolor=faces[mark.fill],
                markeredgewidth=0.9, zorder=3,
            )  # fmt: skip
    ax.set_xlabel(first.model.parameter(first.vary).label)
    return ax


def _draw_branches(
    ax: Axes, diagram: Diagram, output: str, measure: str, color: str, *, families: bool
) -> None:
    """Draw the lines of all branches that are, or are not, families of cycles, as of a center."""
    for branch, part in product(diagram.branches, parts_of(measure)):
        if (branch.stopped.kind == "family") == families:
            for line in branch_segments(branch, output, part):
                ax.plot(line.parameter, line.value, color=color, **LINES[line.kind])


def name_family(
    ax: Axes,
    diagrams: Sequence[Diagram],
    names: Sequence[str] | None = None,
    output: str = "x",
    measure: str = "max",
    colors: Sequence[str] | None = None,
    without: tuple[float, float] | None = None,
) -> None:
    """Write the names of special points and curves where they cover nothing.

    Call it last: a name may cover what is drawn later, or be moved by it.
    """
    settle(ax)
    colors = palette(len(diagrams)) if colors is None else colors
    labels = []
    for diagram, color in zip(diagrams, colors, strict=True):
        named: dict[str, list[Array]] = {}
        for mark in marks_in(diagram, output, measure):
            place = np.array([[mark.parameter, mark.value]])
            hidden = without and without[0] <= mark.parameter <= without[1]
            if mark.name and not hidden and len(within(ax, place)):
                named.setdefault(mark.name, []).append(place)
        for name, places in named.items():
            for group in _groups(ax, np.concatenate(places)):
                text = name if len(group) == 1 else f"{len(group)} {name}"
                labels.append(Label(text, group, color))
    for diagram, name, color in zip(diagrams, names or (), colors, strict=names is not None):
        anchors = within(ax, _anchors(diagram, output, measure))
        if len(anchors):
            labels.append(Label(name, anchors, color, size=7.5))
    place_labels(ax, labels)


def _groups(ax: Axes, places: Array) -> list[Array]:
    """Split points into groups in which neighbors are closer than the width of a name."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    steps = np.abs(np.diff(ax.transData.transform(places), axis=0)).max(axis=1, initial=0.0)
    return np.split(places, np.flatnonzero(steps > CROWDED * figure.dpi / 72) + 1)


def _anchors(diagram: Diagram, output: str, measure: str) -> Array:
    """Return points along all branches, shape (n, 2)."""
    chosen = []
    for branch in diagram.branches:
        lines = branch_segments(branch, output, parts_of(measure)[0])
        points = np.concatenate([np.column_stack([item.parameter, item.value]) for item in lines])
        chosen.append(points[np.linspace(0, len(points) - 1, 40).astype(int)])
    return np.concatenate(chosen)


def marks_in(diagram: Diagram, output: str, measure: str) -> Iterator[Mark]:
    """Yield the marks of all branches."""
    for branch, part in product(diagram.branches, parts_of(measure)):
        yield from marks_of(branch, output, part)


def marks_of(branch: Branch, output: str, measure: str = "max") -> tuple[Mark, ...]:
    """Return the marks of a branch; extrema of what is drawn alone."""
    found = []
    for point in branch.special:
        # A branch point lies on two branches; the one met first marks it.
        again = point.type == "BP" and (point.leads_to or branch.id) < branch.id
        others = point.measured not in (None, (measure, output))
        if point.type in MARKERS and not again and not others:
            name = point.name if point.type == "EVENT" else point.type
            value = measured_at(point, output, measure)
            fill = "full" if point.undecided is None else "pale"
            fill = "open" if point.criticality == "subcritical" else fill
            found.append(Mark(point.type, name, float(point.value), value, fill))
    end = branch.stopped
    if len(branch) and end.kind in ("limit", "failed"):
        type_, name = "FAILED", ""
        if end.kind == "limit":
            type_, name = "LIMIT", limit_name(branch.model, end.reason)
        value = float(measured_along(branch, output, measure)[-1])
        found.append(Mark(type_, name, float(branch.parameter[-1]), value))
    return tuple(mark for mark in found if np.isfinite(mark.value))


def limit_name(model: Model, reason: str) -> str:
    """Return one word for a limit of a model, e.g. ``"collapse"``."""
    for limit in model.limits:
        if reason.startswith(limit.reason.partition("{")[0]):
            return limit.name.split()[-1]
    return "limit"


def _draw_tori(
    ax: Axes, tori: Sequence[TorusBranch], output: str, measure: str, color: str
) -> None:
    """Draw tori in a lighter shade of a color; unstable ones are dotted."""
    for each, part in product(tori, parts_of(measure)):
        lines = torus_segments(each, output, part)
        for line in lines:
            ax.plot(line.parameter, line.value, color=_lighter(color), **LINES[line.kind])
        if lines and each.stopped.kind in BREAKS:
            place = lines[-1].parameter[-1], lines[-1].value[-1]
            ax.plot(*place, linestyle="none", marker=MARKERS["FAILED"], color=color, zorder=3)


def torus_handles(tori: Sequence[TorusBranch], color: str) -> list[Line2D]:
    """Return the entries of a legend for tori."""
    stable = np.concatenate([each.stable[1:] for each in tori] or [np.empty(0, bool)])
    return [
        Line2D([], [], color=_lighter(color), label=TORI[kind], **LINES[kind])
        for kind, found in ((STABLE, stable.any()), (OTHER, not stable.all()))
        if found
    ]


def _sweep_handles(sweep: Sweep) -> list[Line2D]:
    """Return the entries of a legend for the dots of a sweep."""
    colors = {
        f"sweep {name}" if name in COLORS else "from many starts": COLORS.get(name, OTHERS)
        for name in sweep.runs
    }
    return [
        Line2D([], [], linestyle="none", marker="o", markersize=3, color=color, label=name)
        for name, color in colors.items()
    ]


def _lighter(color: str) -> str:
    red, green, blue = (0.5 + 0.5 * part for part in to_rgb(color))
    return to_hex((red, green, blue))


def draw_measured(ax: Axes, measurement: Measurement, measure: str, output: str) -> None:
    """Draw the measurements of a quantity, with their errors where there are any."""
    known = [item.measure for item in measurement.quantities if item.output == output]
    parts = [part for part in parts_of(measure) if part in known] or [measure]
    sweep = np.array(measurement.sweep, dtype=object)
    for part, (way, (name, inside, size)) in product(parts, SWEEPS.items()):
        read, errors = measurement.of(part, output)
        rows = (sweep == way) & np.isfinite(read)
        if rows.any():
            ax.errorbar(
                measurement.values[rows], read[rows], np.nan_to_num(errors[rows]),
                linestyle="none", marker="o", markersize=size, markeredgewidth=0.7, elinewidth=0.7,
                color=MEASURED, label=name if part == parts[0] else None, zorder=2.5,
                markerfacecolor=inside,
            )  # fmt: skip


def draw_fit(fit: Fit, quantity: str | None = None, ax: Axes | None = None) -> Axes:
    """Draw measurements, the predictions of the fitted model, and which were not used."""
    measured = fit.measurement
    chosen = measured.quantities[0] if quantity is None else parse_measured(quantity, fit.model)
    column = measured.quantities.index(chosen)
    ax = axes_or_new(ax)
    draw_measured(ax, measured, chosen.measure, chosen.output)
    ax.plot(
        measured.values, fit.predicted[:, column], linestyle="none", marker="_", markersize=9,
        color="black", label="fitted", zorder=2,
    )  # fmt: skip
    left = ~fit.used & np.isfinite(measured.measured[:, column])
    if left.any():
        ax.plot(
            measured.values[left], measured.measured[left, column], linestyle="none", marker="x",
            markersize=7, color="0.4", label="left out", zorder=3,
        )  # fmt: skip
    ax.margins(0.05)
    ax.set_xlabel(fit.model.parameter(measured.vary).label)
    label_output(ax, "y", fit.model, chosen.output, MEASURE_NAMES[chosen.measure])
    ax.legend()
    return ax


def draw_plan(plan: MeasurementPlan, ax: Axes | None = None) -> Axes:
    """Draw the information of each measurement: its change with each parameter, over its error."""
    ax = axes_or_new(ax)
    sizes = np.abs([plan.model.values[name] for name in plan.fitted])
    sensitivity = np.abs(plan.slopes) / plan.errors[:, None] * sizes
    order = np.argsort(plan.values)
    for column, color in enumerate(palette(len(plan.fitted))):
        for row, quantity in enumerate(plan.quantities):
            values = sensitivity[order, row, column]
            ax.plot(
                plan.values[order], np.where(values > 0, values, np.nan), color=color, marker=".",
                linestyle=("-", "--", ":", "-.")[row % 4],
                label=f"{plan.fitted[column]}, {quantity}",
            )  # fmt: skip
    ax.set_yscale("log")
    ax.set_xlabel(plan.model.parameter(plan.vary).label)
    ax.set_ylabel(r"$|\partial\,$measurement$/\partial\,\ln p\,|\;/\;$error")
    ax.legend()
    return ax
