"""Trajectories and orbits: time series, phase portraits, spectra, sweeps."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, to_rgba

from slipfold.arrays import Array
from slipfold.bifurcations.tori.surface import TorusSpectrum
from slipfold.errors import InputError
from slipfold.flow.flow import flow_of
from slipfold.flow.trajectory import Trajectory, reached
from slipfold.long_term.classification import sampled_outputs
from slipfold.long_term.spectrum import Spectrum
from slipfold.long_term.sweep import DOWN, UP
from slipfold.models.model import Model
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.plots.labels import Label, place_labels
from slipfold.plots.style import (
    MEASURE_NAMES,
    add_color_bar,
    add_title,
    axes_or_new,
    label_axis,
    label_of,
    label_output,
    on_circles,
    settle,
)
from slipfold.results.diagram import Diagram
from slipfold.results.simulation import Simulation
from slipfold.results.trajectories import Sweep
from slipfold.text import with_unit

Solution = Trajectory | PeriodicOrbit

FIRST, BETWEEN = "black", "#2166ac"
"""Colors of the multiples of the first frequency, and of the other lines."""

COLORS = {UP: "#2166ac", DOWN: "#c0392b"}
"""Colors of sweeps; trajectories from many starts are gray."""

OTHERS = "0.6"

STROBOSCOPIC = "stroboscopic"
"""Measure: what an output is at phase zero."""

SIZE = 1.1
"""Size of a dot in points; where there are few values, up to three times as much."""

FEW = 120
"""Number of values below which there are few."""

MOST = 200
"""Vibrations that a time series shows one by one; the lines of more would be a black area."""


def draw_timeseries(
    solution: Solution,
    output: str | None = None,
    ax: Axes | None = None,
    color: str = "black",
    *,
    start: int = 0,
    stop: int | None = None,
    per_period: int = 64,
) -> Axes:
    """Draw one output over time; of many vibrations the band between their extrema."""
    output = output or solution.model.shown[0]
    if isinstance(solution, Trajectory):
        time, values = solution.output(output, start, stop, per_period)
    else:
        time, values = solution.output(output, per_period * solution.period)
    ax = axes_or_new(ax)
    values, time = on_circles(solution.model, [(output, values)], [time])
    vibrations = np.count_nonzero(np.diff(values > np.nanmean(values))) // 2
    if vibrations > MOST:
        first = np.linspace(0, len(values), MOST, endpoint=False).astype(int)
        low, high, start_of = (
            each.reduceat(part, first)
            for each, part in ((np.fmin, values), (np.fmax, values), (np.fmin, time))
        )
        # The last extrema hold from the start of their part to the last time.
        low, high = (np.append(each, each[-1]) for each in (low, high))
        times = np.append(start_of, np.nanmax(time))
        ax.fill_between(times, low, high, facecolor=to_rgba(color, 0.25), edgecolor=color)
        add_title(ax, f"band between the extrema of {vibrations} vibrations")
    else:
        ax.plot(time, values, color=color, linewidth=0.9)
    ax.margins(x=0.0)
    ax.set_xlabel("time (s)")
    label_output(ax, "y", solution.model, output)
    return ax


def draw_phase(
    solution: Solution,
    output: str | None = None,
    against: str | None = None,
    ax: Axes | None = None,
    color: str = "black",
    *,
    periods: int = 64,
    per_period: int = 128,
) -> Axes:
    """Draw one output against another, with a dot at the start of every forcing period.

    By default these are the first state and its rate.
    """
    output = output or solution.model.shown[0]
    against = against or _rate_or_other(solution.model, output)
    if isinstance(solution, Trajectory):
        start = max(solution.periods - periods, 0)
        columns = [solution.output(name, start, None, per_period)[1] for name in (output, against)]
        dots = [column[::per_period] for column in columns]
    else:
        # A multiple of the nodes, so that a sample falls on the start of every forcing period.
        unit = math.lcm(solution.period, len(solution.nodes))
        count = -(-per_period * solution.period // unit) * unit
        columns = [solution.output(name, count)[1] for name in (output, against)]
        dots = [column[:: count // solution.period] for column in columns]
        columns = [np.append(column, column[0]) for column in columns]
    ax = axes_or_new(ax)
    named = (output, against)
    lines = on_circles(solution.model, list(zip(named, columns, strict=True)))
    ax.plot(*lines, color=color, linewidth=0.8)
    starts = on_circles(solution.model, list(zip(named, dots, strict=True)))
    ax.plot(*starts, "o", markersize=3, color=color)
    ax.margins(0.05)
    label_output(ax, "x", solution.model, output)
    label_output(ax, "y", solution.model, against)
    return ax


def _rate_or_other(model: Model, output: str) -> str:
    """Return what an output is drawn against: its rate if that has the usual name, or another.

    >>> from slipfold import SlidingOscillator
    >>> _rate_or_other(SlidingOscillator(), "x")
    'vx'
    """
    states = [item.name for item in model.states]
    rate = f"v{output}"
    others = (name for name in (*model.shown, *states) if name != output)
    return rate if rate in states else next(others, output)


def draw_spectrum(
    solution: Simulation | Spectrum,
    output: str | None = None,
    ax: Axes | None = None,
    color: str = "black",
    *,
    annotate: bool = True,
) -> Axes:
    """Draw the amplitudes of one output over frequency, one line each, on a logarithmic scale.

    Lines of less than 1e-6 are left out, or of 1e-4 of the highest line if that is less. The
    largest multiple of the forcing's frequency is 3, or beyond the highest line.
    """
    spectrum = solution.spectrum() if isinstance(solution, Simulation) else solution
    output = output or spectrum.model.shown[0]
    amplitude = spectrum.of(output)
    largest_order = _beyond_highest(spectrum.order, amplitude)
    drawn = spectrum.order <= largest_order * (1 + 1e-9)
    # Relative to the highest, or vibration of a micrometer would leave the figure empty.
    highest = float(amplitude[drawn].max(initial=0.0))
    floor = min(1e-6, 1e-4 * highest) if highest > 0 else 1e-6
    shown = drawn & (amplitude > floor)
    unit = spectrum.frequency[spectrum.periods] if spectrum.periods < len(spectrum.frequency) else 1
    tallest = amplitude[shown].max(initial=10 * floor)
    ax = _spectrum_axes(ax, label_of(spectrum.model, output), floor, tallest)
    ax.set_xlim(-0.05 * unit, (largest_order + 0.1) * unit)
    _draw_lines(ax, spectrum.frequency[shown], amplitude[shown], color)
    if annotate:
        name_lines(ax, spectrum, output, color)
    return ax


def _beyond_highest(orders: Array, amplitudes: Array) -> float:
    """Return the largest order to draw: 3, or beyond the highest line."""
    return max(3.0, 1.2 * float(orders[np.argmax(amplitudes)]))


def name_lines(ax: Axes, spectrum: Spectrum, output: str = "x", color: str = "black") -> None:
    """Name the multiples of half the frequency of the forcing or a cycle; else the mean alone."""
    settle(ax)
    floor, rightmost = ax.get_ylim()[0], ax.get_xlim()[1]
    labels = []
    for frequency, amplitude, order in zip(
        spectrum.frequency, spectrum.of(output), spectrum.order, strict=True
    ):
        periodic = spectrum.settled or spectrum.model.forced or not order
        if periodic and floor < amplitude and frequency < rightmost and not 2 * order % 1:
            place = np.array([[frequency, amplitude]])
            labels.append(Label(_order_name(round(2 * order)), place, color, leader=False))
    place_labels(ax, labels)


def _order_name(halves: int) -> str:
    """Return e.g. ``"3f/2"`` for three halves of the forcing frequency."""
    if halves == 0:
        return "mean"
    count, half = (halves // 2, "") if halves % 2 == 0 else (halves, "/2")
    return f"${'' if count == 1 else count}f{half}$"


def draw_spectrum_at(
    diagram: Diagram,
    output: str | None = None,
    at: float | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw the lines of the torus nearest to a value of the parameter, and name that torus."""
    known = [each for each in diagram.tori if len(each) > 1]
    if not known:
        raise InputError("the diagram has no tori; compute it with tori=True, or --tori")
    vary, unit = diagram.vary, diagram.model.parameter(diagram.vary).unit
    low = min(each.parameter.min() for each in known)
    high = max(each.parameter.max() for each in known)
    if at is None or not low <= at <= high:
        where = with_unit(f"{vary} = {low:.6g} to {high:.6g}", unit)
        problem = "no value is given" if at is None else f"no torus at {vary} = {at:g}"
        raise InputError(f"{problem}; there are tori at {where}, give one of these as at")
    # The first one of each is the orbit from which they emanate.
    rows = [1 + int(np.abs(each.parameter[1:] - at).argmin()) for each in known]
    chosen, row = min(
        zip(known, rows, strict=True), key=lambda pair: abs(pair[0].parameter[pair[1]] - at)
    )
    output = output or diagram.model.shown[0]
    ax = draw_torus_spectrum(chosen.spectrum(row), output, ax)
    place = with_unit(f"{vary} = {chosen.parameter[row]:.6g}", unit)
    add_title(ax, f"tori {chosen.id}, {place}")
    return ax


def draw_torus_spectrum(
    spectrum: TorusSpectrum, output: str | None = None, ax: Axes | None = None
) -> Axes:
    """Draw the amplitudes of one output over frequency, up to three times the first one.

    Lines of less than a ten-thousandth of the largest are left out.
    """
    output = output or spectrum.names[0]
    first, second = spectrum.frequencies
    frequency, amplitude = spectrum.frequency, spectrum.of(output)
    lowest = max(1e-4 * float(amplitude.max()), float(np.finfo(float).tiny))
    shown = (frequency <= 3.5 * first) & (amplitude > lowest)
    tallest = max(amplitude.max(), 10 * lowest)
    ax = _spectrum_axes(ax, label_of(spectrum.model, output), lowest, tallest)
    ax.set_xlim(-0.05 * first, 3.5 * first)
    between = spectrum.orders[:, 1] != 0
    for color, name, own in (
        (FIRST, f"multiples of $f_1$ = {first:.6g} Hz", shown & ~between),
        (BETWEEN, f"with $f_2$ = {second:.6g} Hz", shown & between),
    ):
        _draw_lines(ax, frequency[own], amplitude[own], color, name)
    ax.legend()
    settle(ax)
    # The tallest lines have names.
    highest = np.flatnonzero(shown)[np.argsort(amplitude[shown])[::-1][:8]]
    place_labels(
        ax,
        [
            Label(
                _combination_name(*spectrum.orders[line]),
                np.array([[frequency[line], amplitude[line]]]),
                BETWEEN if between[line] else FIRST,
            )
            for line in highest
        ],
    )
    return ax


def _combination_name(k: int, l: int) -> str:  # noqa: E741
    """Return e.g. ``"3f_1 - f_2"`` as mathematics."""
    terms = [
        f"{'-' if order < 0 else '+'}{'' if abs(order) == 1 else abs(order)}f_{place}"
        for place, order in ((1, k), (2, l))
        if order
    ]
    return f"${''.join(terms).removeprefix('+')}$" if terms else "mean"


def _spectrum_axes(ax: Axes | None, label: str, floor: float, tallest: float) -> Axes:
    ax = axes_or_new(ax)
    ax.set_yscale("log")
    ax.set_ylim(floor, 10.0 ** np.ceil(np.log10(tallest) + 0.25))
    ax.set_xlabel("frequency (Hz)")
    ax.set_ylabel(f"amplitude of {label}")
    return ax


def _draw_lines(
    ax: Axes, frequency: Array, amplitude: Array, color: str, name: str = "_nolegend_"
) -> None:
    """Draw a stem and a dot for each line; names keep clear of both."""
    ax.plot(frequency, amplitude, "o", markersize=3, color=color, label=name)
    stems = np.full(len(frequency), ax.get_ylim()[0]), amplitude
    ax.plot(np.array([frequency] * 2), np.array(stems), color=color, linewidth=1.0)


def draw_points(
    sweep: Sweep,
    output: str | None = None,
    measure: str = STROBOSCOPIC,
    ax: Axes | None = None,
    *,
    runs: Sequence[str] | None = None,
    legend: bool = True,
    beside: Mapping[str, float] = MappingProxyType({}),
) -> Axes:
    """Draw an output at phase zero of each period, or its extremes, over the parameter.

    Sweeps lie on top of trajectories from many starts, the one down on top of the one up; of few
    values the dots below are larger. A trajectory that sticks is drawn at phase zero alone. What
    repeats has the size `beside` of its run in points, if there is one, to be seen below a line.
    """
    if measure not in (STROBOSCOPIC, *MEASURE_NAMES):
        raise InputError(
            f"measure = {measure!r} is unknown; give {', '.join((STROBOSCOPIC, *MEASURE_NAMES))}"
        )
    output = output or sweep.model.shown[0]
    ax = axes_or_new(ax)
    chosen = sweep.runs if runs is None else runs
    named: dict[str, Any] = {}
    larger = float(np.clip(FEW / len(sweep.values), 1, 3))
    order = sorted(chosen, key=lambda name: (name in COLORS, sweep.run(name)))
    layers = list(dict.fromkeys(name if name in COLORS else OTHERS for name in order))[::-1]
    for name in order:
        x, y = dots_of(sweep, sweep.run(name), output, measure)
        below = layers.index(name if name in COLORS else OTHERS)
        dot = SIZE * larger * (1 + (larger - 1) / 3 * below)
        single = np.isin(x, sweep.values[sweep.repeats(name) > 0]) & (name in beside)
        for some, size in ((single, beside.get(name)), (~single, dot)):
            (dots,) = ax.plot(
                x[some], y[some], "o", markersize=size, markeredgewidth=0,
                color=COLORS.get(name, OTHERS), zorder=0.5, rasterized=True,
            )  # fmt: skip
        if len(x):
            named.setdefault(name if name in COLORS else "from many starts", dots)
    label_axis(ax, "x", sweep.model.parameter(sweep.vary))
    label_output(ax, "y", sweep.model, output, MEASURE_NAMES.get(measure, ""))
    if legend and len(named) > 1:
        ax.legend(named.values(), named, markerscale=5 / larger, loc="best", handletextpad=0.2)
    return ax


def dots_of(sweep: Sweep, run: int, output: str, measure: str) -> tuple[Array, Array]:
    """Return values of the parameter, and what an output is or reaches there."""
    column, states = flow_of(sweep.model).output_index(output), sweep.states[run]
    known = np.flatnonzero(np.isfinite(states).all(axis=(1, 2)))
    if measure != STROBOSCOPIC:
        known = known[~sweep.stuck[run, known]]
    if not len(known):
        return np.empty(0), np.empty(0)
    if measure == STROBOSCOPIC:
        x = np.repeat(sweep.values[known], states.shape[1])
        found = sampled_outputs(sweep.model, sweep.vary, x, states[known].reshape(len(x), -1), 1)
        return x, found[:, 0, column]
    # Of what repeats one response says all; otherwise every period is a dot.
    repeats = sweep.repeats(sweep.runs[run])[known]
    rows = [states[place, : count or None] for place, count in zip(known, repeats, strict=True)]
    counts = [len(each) for each in rows]
    at = np.repeat(sweep.values[known], counts)
    # Extremes are interpolated between 48 samples of a forcing period.
    samples = sampled_outputs(sweep.model, sweep.vary, at, np.concatenate(rows), 48)
    places, heights = list[Array](), list[Array]()
    parts = np.split(samples[:, :, column], np.cumsum(counts)[:-1])
    for place, count, own in zip(known, repeats, parts, strict=True):
        width = own.size if count else 48
        heights.append(reached(own.ravel(), width, measure, bool(count), forced=True))
        places.append(np.full(len(heights[-1]), sweep.values[place]))
    return np.concatenate(places), np.concatenate(heights)


def draw_section(
    sweep: Sweep,
    output: str | None = None,
    against: str | None = None,
    ax: Axes | None = None,
    *,
    at: float,
    runs: Sequence[str] | None = None,
) -> Axes:
    """Draw states at phase zero at the value nearest to `at`: the stroboscopic section."""
    output = output or sweep.model.shown[0]
    against = against or _rate_or_other(sweep.model, output)
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
                color=COLORS.get(name, OTHERS), label=name)  # fmt: skip
    ax.margins(0.05)
    label_output(ax, "x", sweep.model, output)
    label_output(ax, "y", sweep.model, against)
    add_title(ax, with_unit(f"{sweep.vary} = {value:.6g}", sweep.model.parameter(sweep.vary).unit))
    return ax


def draw_waterfall(
    sweep: Sweep,
    output: str | None = None,
    ax: Axes | None = None,
    *,
    run: str | None = None,
    lines: float | None = None,
) -> Axes:
    """Draw amplitudes over frequency and parameter as colors.

    Frequencies are in multiples of the forcing's, up to `lines`: by default 3, or beyond the
    highest line below 12. Amplitudes are shown down to 1e-5 of the largest.
    Trajectories are windowed (Hann), so that a line is as wide as four steps of the frequency, and
    a peak as high as its amplitude.
    """
    output = output or sweep.model.shown[0]
    ax = axes_or_new(ax)
    place = sweep.run(sweep.runs[0] if run is None else run)
    states = sweep.states[place]
    known = np.isfinite(states).all(axis=(1, 2)) & ~sweep.stuck[place]
    if not known.any():
        raise InputError(f"{sweep.runs[place]} has no points without stick; give another run")
    periods, samples = states.shape[1], 2 * int(np.ceil(4 * (lines or 3)))
    x = np.repeat(sweep.values[known], periods)
    flat = states[known].reshape(len(x), -1)
    outputs = sampled_outputs(sweep.model, sweep.vary, x, flat, samples)
    solution = outputs[:, :, flow_of(sweep.model).output_index(output)]
    solution = solution.reshape(int(known.sum()), -1)
    window = np.hanning(solution.shape[1] + 1)[:-1]
    centered = solution - solution.mean(axis=1, keepdims=True)
    amplitudes = np.full((len(states), solution.shape[1] // 2 + 1), np.nan)
    amplitudes[known] = 2 * np.abs(np.fft.rfft(centered * window)) / window.sum()
    frequencies = np.arange(amplitudes.shape[1]) / periods
    if lines is None:
        lines = _beyond_highest(frequencies, np.nanmax(amplitudes, axis=0))
    shown = frequencies <= lines
    largest = float(np.nanmax(amplitudes))
    smallest = max(1e-5 * largest, float(np.finfo(float).tiny))
    mesh = ax.pcolormesh(
        sweep.values,
        frequencies[shown],
        np.ma.masked_invalid(np.maximum(amplitudes[:, shown], smallest)).T,
        norm=LogNorm(smallest, largest),
        cmap="magma",
        rasterized=True,
        shading="nearest",
    )
    label_output(add_color_bar(ax, mesh), "y", sweep.model, output, "amplitude of")
    label_axis(ax, "x", sweep.model.parameter(sweep.vary))
    ax.set_ylabel("frequency over that of the forcing")
    return ax
