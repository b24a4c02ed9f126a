"""The figures of the paper, drawn from what was computed."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D

from slipfold.attractors.spectrum import Spectrum
from slipfold.branches.branch import Branch
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.paper.cases import Curve, Figure, Row, Steady, value_text
from slipfold.plots.response import HasBranches, draw_family
from slipfold.plots.spectrum import draw_spectrum
from slipfold.plots.style import COLUMN, LINES, MARKERS, figure_style, palette

__all__ = ["draw_figure", "render_figure"]

OUTPUTS = ("y", "x")
"""Left and right panel of a row, as in the paper."""

ROW_HEIGHT = 2.75
SPECTRUM_HEIGHT = 1.9
LEGEND_HEIGHT = 0.45

MEANINGS = {
    "PD": "period doubling",
    "NS": "Neimark–Sacker",
    "LP": "fold",
    "BP": "branch point",
    "LIMIT": "limit of the model",
}


def draw_figure(
    figure: Figure,
    diagrams: Mapping[Curve, HasBranches],
    spectra: Mapping[Steady, Spectrum],
    measure: str = "max",
) -> Canvas:
    """Draw one figure of the paper.

    Parameters
    ----------
    figure
        Which.
    diagrams
        Its curves.
    spectra
        Its spectra.
    measure
        What is shown of each orbit, see `slipfold.plots.draw_response`.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, tied to no window.
    """
    heights = [ROW_HEIGHT] * len(figure.rows) + [SPECTRUM_HEIGHT] * len(figure.spectra)
    canvas = Canvas(figsize=(2 * COLUMN, sum(heights) + LEGEND_HEIGHT), layout="constrained")
    grid = canvas.subplots(len(heights), 2, squeeze=False, height_ratios=heights)
    letters = iter("abcdefghijkl")
    for axes, row in zip(grid, figure.rows, strict=False):
        _draw_row(axes, row, [diagrams[curve] for curve in row.curves], letters, measure)
    for axes, case in zip(grid[len(figure.rows) :], figure.spectra, strict=True):
        for ax, output in zip(axes, OUTPUTS, strict=True):
            draw_spectrum(spectra[case], output, ax, palette(1)[0])
            ax.set_title(f"({next(letters)})  {_settings(case)}")
    branches = [branch for curve in figure.curves for branch in diagrams[curve].branches]
    _explain(canvas, branches)
    return canvas


def render_figure(
    figure: Figure,
    diagrams: Mapping[Curve, HasBranches],
    spectra: Mapping[Steady, Spectrum],
    measure: str = "max",
) -> dict[str, bytes]:
    """Draw one figure of the paper as PDF and PNG.

    Parameters
    ----------
    figure
        Which.
    diagrams
        Its curves.
    spectra
        Its spectra.
    measure
        What is shown of each orbit, see `slipfold.plots.draw_response`.

    Returns
    -------
    dict
        File names and contents.
    """
    contents = {}
    with figure_style():
        canvas = draw_figure(figure, diagrams, spectra, measure)
        for suffix in ("pdf", "png"):
            memory = io.BytesIO()
            # Without the date the same numbers make the same file.
            metadata = {"CreationDate": None} if suffix == "pdf" else None
            canvas.savefig(memory, format=suffix, metadata=metadata)
            contents[f"{figure.key}.{suffix}"] = memory.getvalue()
    return contents


def _draw_row(
    axes: Sequence[Axes],
    row: Row,
    diagrams: Sequence[HasBranches],
    letters: Iterator[str],
    measure: str,
) -> None:
    parameter = row.curves[0].model.parameter(row.member)
    unit = value_text(row.curves[0].model, row.member)[1]
    symbol = parameter.symbol or parameter.name
    names = [f"{symbol} = {name}{unit}" for name in row.names]
    for ax, output in zip(axes, OUTPUTS, strict=True):
        draw_family(diagrams, names, output, measure, ax)
        ax.set_title(f"({next(letters)})  {_common(row)}")


def _common(row: Row) -> str:
    """Return what holds for all curves of a row, e.g. the frequency of a force response."""
    model = row.curves[0].model
    shown = [*row.common]
    if "f" not in (row.member, row.curves[0].vary, *shown):
        shown.append("f")
    return ", ".join(_equation(model, name) for name in shown)


def _settings(case: Steady) -> str:
    return ", ".join(_equation(case.model, name) for name in ("f", "Nd"))


def _equation(model: SlidingOscillator, name: str) -> str:
    value, unit = value_text(model, name)
    return f"{model.parameter(name).symbol} = {value}{unit}"


def _explain(canvas: Canvas, branches: Sequence[Branch]) -> None:
    """Put a legend of lines and markers below the panels."""
    handles = [
        Line2D([], [], color="0.2", label=label, **LINES[kind])
        for kind, label in (
            ("stable", "stable"),
            ("period doubling", "unstable: period doubling"),
            ("fold or torus", "unstable: fold or torus"),
        )
    ]
    special = [point for branch in branches for point in branch.special]
    for type_, meaning in MEANINGS.items():
        if any(point.type == type_ for point in special):
            handles.append(_marker(type_, f"{type_} {meaning}" if type_ != "LIMIT" else meaning))
    if any(point.criticality == "subcritical" for point in special):
        handles.append(_marker("PD", "open: subcritical", "white"))
    canvas.legend(handles=handles, loc="outside lower center", ncols=4, columnspacing=1.4)


def _marker(type_: str, label: str, face: str = "0.2") -> Line2D:
    return Line2D(
        [],
        [],
        linestyle="none",
        marker=MARKERS[type_],
        color="0.2",
        markerfacecolor=face,
        markeredgewidth=0.9,
        label=label,
    )
