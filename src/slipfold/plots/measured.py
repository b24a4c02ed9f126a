"""Fits to measured responses, and what planned readings would tell."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from slipfold.measured.quantity import Quantity, parse_measured
from slipfold.models.model import Model
from slipfold.plots.angles import label_output
from slipfold.plots.axes import axes_or_new
from slipfold.plots.readings import draw_readings
from slipfold.plots.response import MEASURE_NAMES
from slipfold.plots.style import palette
from slipfold.results.measured.fit import Fit
from slipfold.results.measured.measurement_plan import MeasurementPlan


def draw_fit(fit: Fit, quantity: str | None = None, ax: Axes | None = None) -> Axes:
    """Draw readings, what the fitted model predicts for them, and which were not used."""
    measured = fit.measurement
    chosen = _chosen(measured.quantities, quantity, fit.model)
    column = measured.quantities.index(chosen)
    ax = axes_or_new(ax)
    draw_readings(ax, measured, chosen.measure, chosen.output)
    ax.plot(
        measured.values, fit.predicted[:, column], linestyle="none", marker="_", markersize=9,
        color="black", label="fitted", zorder=2,
    )  # fmt: skip
    left = ~fit.used & np.isfinite(measured.readings[:, column])
    if left.any():
        ax.plot(
            measured.values[left], measured.readings[left, column], linestyle="none", marker="x",
            markersize=7, color="0.4", label="left out", zorder=3,
        )  # fmt: skip
    _label(ax, fit.model, measured.vary, chosen)
    ax.legend()
    return ax


def draw_plan(plan: MeasurementPlan, ax: Axes | None = None) -> Axes:
    """Draw what each reading tells: its change with each parameter's own size, over its error."""
    ax = axes_or_new(ax)
    sizes = np.abs([plan.model.values[name] for name in plan.fitted])
    told = np.abs(plan.slopes) / plan.errors[:, None] * sizes
    order = np.argsort(plan.values)
    for column, (name, colour) in enumerate(
        zip(plan.fitted, palette(len(plan.fitted)), strict=True)
    ):
        for row, quantity in enumerate(plan.quantities):
            ax.plot(
                plan.values[order], _positive(told[order, row, column]), color=colour, marker=".",
                linestyle=("-", "--", ":", "-.")[row % 4], label=f"{name}, {quantity}",
            )  # fmt: skip
    ax.set_yscale("log")
    ax.set_xlabel(plan.model.parameter(plan.vary).label)
    ax.set_ylabel(r"$|\partial\,$reading$/\partial\,\ln p\,|\;/\;$error")
    ax.legend()
    return ax


def _positive(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(values > 0, values, np.nan)


def _chosen(quantities: tuple[Quantity, ...], text: str | None, model: Model) -> Quantity:
    return quantities[0] if text is None else parse_measured(text, model)


def _label(ax: Axes, model: Model, vary: str, quantity: Quantity) -> None:
    ax.set_xlabel(model.parameter(vary).label)
    label_output(ax, "y", model, quantity.output, MEASURE_NAMES[quantity.measure])
