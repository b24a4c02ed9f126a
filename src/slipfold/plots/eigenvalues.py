"""Frequencies and damping ratios: of equilibria over a parameter, of a mode over its amplitude."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from slipfold.arrays import Array, Complex
from slipfold.bifurcations.branches.branch import Branch
from slipfold.errors import InputError
from slipfold.lines import branch_segments
from slipfold.models.model import evaluation_of
from slipfold.models.nonlinear_mode import OUTPUTS, NonlinearMode
from slipfold.models.units import parse_quantity
from slipfold.orbits.eigenvalues import eigenvalues_of
from slipfold.plots.style import MEASURE_NAMES, label_axis, label_output, palette, panels_of
from slipfold.results.diagram import Diagram

NOTHING = complex(math.nan, math.nan)
"""What is not drawn: a real NaN would leave a frequency of zero."""

BETWEEN = 12
"""Values drawn from one point of a branch to the next: frequencies that meet do so like a root."""


def draw_eigenvalues(diagram: Diagram, *, highest: float | str = math.inf, ax: Any = None) -> Any:
    """Draw frequencies in Hz above, damping ratios in per cent below; return the two axes.

    One color is one mode, from the lowest frequency on; frequencies above `highest` are left out.
    Motions grow where the damping ratio is negative, which is drawn dotted.
    """
    branches = [branch for branch in diagram.branches if branch.kind == "equilibrium"]
    if not branches:
        raise InputError(
            f"the diagram has {len(diagram.branches)} branches of orbits and 0 of equilibria, of "
            "which eigenvalues are drawn; follow the equilibria of an autonomous model, such as "
            "model.steady()"
        )
    reach = 2 * math.pi * parse_quantity(highest, "Hz", "highest")
    if not reach > 0:
        raise InputError(f"highest = {highest} Hz; give a number > 0")
    upper, lower = axes = panels_of(ax, 2, 1, sharex=True).ravel()
    for branch in branches:
        values, eigenvalues = _followed(branch)
        shown = (eigenvalues.imag > 0) & (eigenvalues.imag <= reach)
        columns = np.flatnonzero(shown.any(axis=0))
        first = np.nanmin(np.where(shown, eigenvalues.imag, np.inf)[:, columns], axis=0)
        columns = columns[np.argsort(first)]
        for column, color in zip(columns, palette(len(columns)), strict=True):
            mode = np.where(shown[:, column], eigenvalues[:, column], NOTHING)
            for dots, part in ((False, mode.real <= 0), (True, mode.real > 0)):
                style = {"color": color, "linestyle": ":" if dots else "-"}
                there = np.where(part, mode, NOTHING)
                upper.plot(values, there.imag / (2 * math.pi), **style)
                lower.plot(values, -100 * there.real / np.abs(there), **style)
        for point in branch.special:
            if point.type == "HB":
                for ax in (upper, lower):
                    ax.axvline(point.value, color="0.7", linewidth=0.6, zorder=0)
                upper.annotate(
                    "HB", (point.value, 1.0), (0, 2), xycoords=("data", "axes fraction"),
                    textcoords="offset points", ha="center", fontsize=7,
                )  # fmt: skip
    lower.axhline(0.0, color="0.7", linewidth=0.6, zorder=0)
    upper.set_ylabel("frequency (Hz)")
    lower.set_ylabel("damping ratio (%)")
    label_axis(lower, "x", branches[0].model.parameter(diagram.vary))
    lower.set_xlim(*sorted(diagram.span))
    return axes


def draw_backbone(
    diagram: Diagram, output: str | None = None, *, color: str = "black", ax: Any = None
) -> Any:
    """Draw the amplitude of a nonlinear mode; return the two axes.

    On the left it is over the frequency in Hz, where responses can be drawn as well, on the right
    over the damping ratio in per cent.
    """
    model = diagram.model
    if not isinstance(model, NonlinearMode):
        raise InputError(f"{model.name} is not a nonlinear mode; slipfold.backbone follows one")
    left, right = axes = panels_of(ax, 1, 2, sharey=True).ravel()
    output = output or next((event.name for event in diagram.events), model.shown[0])
    for branch in diagram.branches:
        names = (output, *OUTPUTS)
        height, frequency, ratio = (
            np.concatenate([line.value for line in branch_segments(branch, name)]) for name in names
        )
        left.plot(frequency, height, color=color)
        right.plot(100 * ratio, height, color=color)
    left.set_xlabel("frequency (Hz)")
    right.set_xlabel("damping ratio (%)")
    label_output(left, "y", model, output, MEASURE_NAMES["max"])
    return axes


def _followed(branch: Branch) -> tuple[Array, Complex]:
    """Return parameter values and eigenvalues of a branch, one column a motion.

    Shapes: (n,), (n, n_states).
    """
    jacobian = evaluation_of(branch.model).jacobian
    places = np.linspace(0, len(branch) - 1, (len(branch) - 1) * BETWEEN + 1)
    points = np.arange(len(branch))
    values = np.interp(places, points, branch.parameter)
    states = np.array([np.interp(places, points, column) for column in branch.states.T]).T
    rows: list[Complex] = []
    for value, state in zip(values, states, strict=True):
        row = eigenvalues_of(jacobian(branch.model.replace(**{branch.vary: float(value)}), state))
        if rows:
            # Each belongs to the one before that is nearest to it.
            distance = np.abs(row[None] - rows[-1][:, None])
            row = row[linear_sum_assignment(distance)[1]]
        rows.append(row)
    return values, np.array(rows)
