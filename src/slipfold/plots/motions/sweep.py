"""Motions over a parameter as dots, one value as a section, their spectra as a picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow.flow import flow_of
from slipfold.long_term.repeats import reached, sampled_outputs
from slipfold.long_term.sweep import DOWN, UP
from slipfold.plots.angles import label_axis, label_output
from slipfold.plots.axes import axes_or_new
from slipfold.plots.phase import beside
from slipfold.plots.response import MEASURE_NAMES
from slipfold.results.motions.sweep import Sweep

COLOURS = {UP: "#2166ac", DOWN: "#c0392b"}
"""Colours of sweeps; motions from many starts are grey."""

OTHERS = "0.6"

STROBE = "strobe"
"""Measure: what an output is at phase zero."""

SIZE = 1.1
"""Size of a dot in points."""

SAMPLES = 48
"""Samples in a forcing period, from which extremes are interpolated."""

LINES = 3
"""Forcing frequencies that a waterfall shows by default."""

DEEP = 1e-5
"""Least amplitude that a waterfall shows, of the largest."""


def draw_points(
    sweep: Sweep,
    output: str,
    measure: str = STROBE,
    ax: Axes | None = None,
    *,
    runs: Sequence[str] | None = None,
    legend: bool = True,
) -> Axes:
    """Draw what an output is at phase zero of each period, or what it reaches, over the parameter.

    Sweeps lie on top of motions from many starts, the one down on top of the one up. A motion that
    sticks is drawn at phase zero alone.
    """
    if measure not in (STROBE, *MEASURE_NAMES):
        raise InputError(
            f"measure = {measure!r} is unknown; give {', '.join((STROBE, *MEASURE_NAMES))}"
        )
    ax = axes_or_new(ax)
    chosen = sweep.runs if runs is None else runs
    named: dict[str, Any] = {}
    for name in sorted(chosen, key=lambda name: (name in COLOURS, sweep.run(name))):
        place = sweep.run(name)
        x, y = dots_of(sweep, place, output, measure)
        colour = COLOURS.get(name, OTHERS)
        (dots,) = ax.plot(
            x, y, "o", markersize=SIZE, markeredgewidth=0, color=colour, zorder=0.5,
            rasterized=True,
        )  # fmt: skip
        named.setdefault(name if name in COLOURS else "from many starts", dots)
    label_axis(ax, "x", sweep.model.parameter(sweep.vary))
    label_output(ax, "y", sweep.model, output, MEASURE_NAMES.get(measure, ""))
    if legend and len(named) > 1:
        ax.legend(named.values(), named, markerscale=5, loc="best", handletextpad=0.2)
    return ax


def dots_of(sweep: Sweep, run: int, output: str, measure: str) -> tuple[Array, Array]:
    """Return values of the parameter, and what an output is or reaches there."""
    flow = flow_of(sweep.model)
    column, states = flow.output_index(output), sweep.states[run]
    known = np.flatnonzero(np.isfinite(states).all(axis=(1, 2)))
    if measure == STROBE:
        x = np.repeat(sweep.values[known], states.shape[1])
        found = sampled_outputs(sweep.model, sweep.vary, x, states[known].reshape(len(x), -1), 1)
        return x, found[:, 0, column]
    known = known[~sweep.stuck[run, known]]
    repeats = sweep.repeats(sweep.runs[run])
    places, heights = list[Array](), list[Array]()
    # Of what repeats one response says all; of the rest every period is a dot.
    kept = [states[place, : repeats[place] or None] for place in known]
    counts = [len(each) for each in kept]
    if not kept:
        return np.empty(0), np.empty(0)
    at = np.repeat(sweep.values[known], counts)
    samples = sampled_outputs(sweep.model, sweep.vary, at, np.concatenate(kept), SAMPLES)
    samples = samples[:, :, column]
    first = 0
    for place, count in zip(known, counts, strict=True):
        own = samples[first : first + count]
        first += count
        if repeats[place]:
            whole = np.concatenate([own.ravel(), own[0, :1]])[None]
        else:
            whole = np.concatenate([own[:-1], own[1:, :1]], axis=1)
        found = reached(whole, measure)
        places.append(np.full(len(found), sweep.values[place]))
        heights.append(found)
    return np.concatenate(places), np.concatenate(heights)


def draw_section(
    sweep: Sweep,
    output: str,
    against: str | None = None,
    ax: Axes | None = None,
    *,
    at: float,
    runs: Sequence[str] | None = None,
) -> Axes:
    """Draw states at phase zero at the value nearest to `at`: the stroboscopic section."""
    names = [item.name for item in sweep.model.states]
    if against is None:
        against = beside(names, output)
    ax = axes_or_new(ax)
    place = int(np.abs(sweep.values - at).argmin())
    flow, value = flow_of(sweep.model), sweep.values[place]
    for name in sweep.runs if runs is None else runs:
        states = sweep.states[sweep.run(name), place]
        if np.isnan(states).any():
            continue
        found = sampled_outputs(sweep.model, sweep.vary, np.full(len(states), value), states, 1)
        columns = [found[:, 0, flow.output_index(item)] for item in (output, against)]
        ax.plot(*columns, "o", markersize=2 * SIZE, markeredgewidth=0,
                color=COLOURS.get(name, OTHERS), label=name)  # fmt: skip
    ax.margins(0.05)
    label_output(ax, "x", sweep.model, output)
    label_output(ax, "y", sweep.model, against)
    unit = sweep.model.parameter(sweep.vary).unit
    ax.set_title(f"{sweep.vary} = {value:.6g} {unit}".rstrip())
    return ax


def draw_waterfall(
    sweep: Sweep,
    output: str,
    ax: Axes | None = None,
    *,
    run: str | None = None,
    lines: float = LINES,
) -> Axes:
    """Draw amplitudes over frequency and parameter as colours.

    Frequencies are in multiples of the forcing's. Motions are windowed (Hann), so that a line is
    as wide as four steps of the frequency, and a peak as high as its amplitude.
    """
    ax = axes_or_new(ax)
    place = sweep.run(sweep.runs[0] if run is None else run)
    states = sweep.states[place]
    known = np.isfinite(states).all(axis=(1, 2)) & ~sweep.stuck[place]
    if not known.any():
        raise InputError(f"{sweep.runs[place]} has no points without stick; give another run")
    periods, samples = states.shape[1], 2 * int(np.ceil(4 * lines))
    x = np.repeat(sweep.values[known], periods)
    flat = states[known].reshape(len(x), -1)
    outputs = sampled_outputs(sweep.model, sweep.vary, x, flat, samples)
    motion = outputs[:, :, flow_of(sweep.model).output_index(output)]
    motion = motion.reshape(int(known.sum()), -1)
    window = np.hanning(motion.shape[1] + 1)[:-1]
    centred = motion - motion.mean(axis=1, keepdims=True)
    amplitudes = np.full((len(states), motion.shape[1] // 2 + 1), np.nan)
    amplitudes[known] = 2 * np.abs(np.fft.rfft(centred * window)) / window.sum()
    frequencies = np.arange(amplitudes.shape[1]) / periods
    shown = frequencies <= lines
    largest = float(np.nanmax(amplitudes))
    least = max(largest * DEEP, float(np.finfo(float).tiny))
    mesh = ax.pcolormesh(
        sweep.values,
        frequencies[shown],
        np.ma.masked_invalid(np.maximum(amplitudes[:, shown], least)).T,
        norm=LogNorm(least, largest),
        cmap="magma",
        rasterized=True,
        shading="nearest",
    )
    figure = ax.get_figure(root=True)
    assert figure is not None
    bar = figure.colorbar(mesh, ax=ax, pad=0.02)
    label_output(bar.ax, "y", sweep.model, output, "amplitude of")
    label_axis(ax, "x", sweep.model.parameter(sweep.vary))
    ax.set_ylabel("frequency over that of the forcing")
    return ax
