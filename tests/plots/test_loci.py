import numpy as np
from matplotlib.colors import to_hex

from helpers.hand_drawn_loci_plots import (
    WINDOW,
    drawn_fold,
    drawn_locus,
    drawn_regions,
    drawn_torus,
    locus_diagram,
    valley,
)
from slipfold.plots import draw_loci
from slipfold.plots.loci import LOCUS_COLORS


def texts(ax):
    return sorted(text.get_text() for text in ax.texts if text.get_text())


def curves(ax):
    return [line for line in ax.get_lines() if line.get_linestyle() != "None"]


def legend_texts(ax):
    return [text.get_text() for text in ax.get_legend().get_texts() if text.get_text().strip()]


def whole():
    return locus_diagram(valley(), drawn_fold(), drawn_torus(), regions=drawn_regions())


def test_axes_have_symbols_units_and_the_window(ax):
    assert draw_loci(whole(), ax) is ax
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$f$ (Hz)", "$N_d$ (N)")
    assert (ax.get_xlim(), ax.get_ylim()) == WINDOW


def test_a_plane_in_which_nothing_was_found_is_empty(ax):
    draw_loci(locus_diagram(), ax)
    assert (ax.get_xlim(), ax.get_ylim(), ax.get_legend()) == (*WINDOW, None)
    assert not curves(ax)


def test_types_criticalities_and_periods_differ(ax):
    draw_loci(whole(), ax, annotate=False)
    drawn = [
        (to_hex(line.get_color()), line.get_linestyle(), line.get_linewidth())
        for line in curves(ax)
    ]
    fold, torus, below, above = drawn  # PD on top
    assert [item[0] for item in drawn] == [LOCUS_COLORS[name] for name in ("LP", "NS", "PD", "PD")]
    assert [torus[1], below[1], above[1]] == ["-", "--", "-"]
    assert len({str(line._unscaled_dash_pattern) for line in curves(ax)}) == 3
    assert fold[2] == torus[2] < below[2] == above[2]
    assert texts(ax) == []


def test_points_loci_and_regions_are_named(ax):
    draw_loci(whole(), ax)
    names = ["GPD", "LP 2", "NS 2", "PD", "collapse", "period 1", "period 2"]
    assert texts(ax) == names


def test_markers(ax):
    draw_loci(whole(), ax, annotate=False)
    marks = [line for line in ax.get_lines() if line.get_linestyle() == "None"]
    places = {tuple(line.get_xydata()[0]): line for line in marks}
    point, extremum, limit = places[12.4, 0.06], places[12.5, 0.05], places[12.7, 0.2]
    assert to_hex(point.get_markerfacecolor()) == "#000000"
    assert to_hex(extremum.get_markerfacecolor()) == "#ffffff"
    assert extremum.get_markersize() < point.get_markersize()
    assert limit.get_marker() == "x"
    assert len(marks) == 3


def test_the_legend_says_what_occurs(ax):
    draw_loci(whole(), ax)
    assert legend_texts(ax) == [
        "PD of period 1, supercritical",
        "PD of period 1, subcritical",
        "NS of period 2, supercritical",
        "LP of period 2",
        "GPD",
        "extremum of a locus",
        "limit of the model",
        "stable: period 1",
        "stable: period 2",
    ]


def test_regions_are_painted_below_the_lines(ax):
    draw_loci(whole(), ax)
    [picture] = ax.images
    assert picture.get_zorder() < min(line.get_zorder() for line in ax.get_lines())
    assert set(np.unique(picture.get_array())) == {1, 2}
    assert picture.get_extent() == [*WINDOW[0], *WINDOW[1]]


def test_names_do_not_overlap(ax):
    figure = ax.get_figure()
    draw_loci(whole(), ax)
    boxes = [text.get_window_extent() for text in ax.texts if text.get_text()]
    assert len(boxes) == 7
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])
    assert figure.axes == [ax]


def test_angles_are_shown_in_degrees_at_round_numbers(ax):
    plane, window = ("alpha", "Nd"), ((0.1, np.pi - 0.1), (0.0, 0.4))
    values = [(0.2, 0.1), (1.5, 0.3), (3.0, 0.1)]
    draw_loci(locus_diagram(drawn_locus("PD", values, vary=plane), vary=plane, window=window), ax)
    assert ax.get_xlabel() == r"$\alpha$ (°)"
    ax.get_figure().draw_without_rendering()
    shown = [
        label.get_text()
        for label, tick in zip(ax.get_xticklabels(), ax.get_xticks(), strict=True)
        if window[0][0] <= tick <= window[0][1]
    ]
    assert shown == ["30", "60", "90", "120", "150"]
    assert ax.get_xlim() == window[0]
