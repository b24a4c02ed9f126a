from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

import slipfold as sf
from helpers.hand_drawn import (
    INSIDE,
    diagram_of,
    drawn_branch,
    drawn_point,
    threshold_diagram,
)
from slipfold import InputError, find_spectrum
from slipfold.flow.simulate import simulate
from slipfold.plots import (
    draw_family,
    draw_phase,
    draw_response,
    draw_spectrum,
    draw_timeseries,
)
from slipfold.plots.response import marks_of, name_family


@pytest.fixture(scope="module")
def doubled():
    return simulate(sf.SlidingOscillator(f=12.2, Nd=0.15), 1000)


def texts(ax):
    return sorted(text.get_text() for text in ax.texts if text.get_text())


def test_response_has_labels_with_symbols_and_units(ax):
    assert draw_response(threshold_diagram(0.1, [0.3, 0.5]), "y", ax=ax) is ax
    assert ax.get_xlabel() == "$N_d$ (N)"
    assert ax.get_ylabel() == "max $y/L$"
    assert texts(ax) == ["NS", "NS", "PD"]


def test_response_draws_each_stability_in_its_style(ax):
    draw_response(threshold_diagram(0.1, [0.3, 0.5]), ax=ax, annotate=False)
    styles = [line.get_linestyle() for line in ax.get_lines() if line.get_linestyle() != "None"]
    # Period 1: solid, dashed. Period 2: solid, dotted, solid; matplotlib calls both patterns "--".
    assert styles == ["-", "--", "-", "--", "-"]
    assert texts(ax) == []


def test_family_names_its_members(ax):
    family = [threshold_diagram(0.1, slope=1.0), threshold_diagram(0.2, slope=2.0)]
    draw_family(family, ax=ax)
    name_family(ax, family, ["one", "two"], without=(0.0, 0.15))
    assert texts(ax) == ["PD", "one", "two"]


def test_the_axes_fit_all_but_families_and_what_is_drawn_into_them_later(ax):
    s = np.linspace(0, 1, 5)
    center = drawn_branch(s, {"x": 100 * s}, [INSIDE] * 5, stopped="family")
    diagram = diagram_of(center, drawn_branch(s, {"x": s}, [INSIDE] * 5))
    draw_response(diagram, ax=ax)
    assert 1 < ax.get_ylim()[1] < 1.2
    draw_response(diagram_of(drawn_branch(2 * s, {"x": 3 * s}, [INSIDE] * 5)), ax=ax)
    assert 2 < ax.get_xlim()[1] < 2.3
    assert 3 < ax.get_ylim()[1] < 3.4


def test_limits_of_the_model_are_marked(ax):
    s = np.linspace(0, 0.4, 5)
    branch = drawn_branch(
        s, {"x": s}, [INSIDE] * 5, stopped="limit", reason="spring collapsed: l/L fell to 0.0001"
    )
    [mark] = marks_of(branch, "x")
    assert (mark.type, mark.name, mark.parameter) == ("LIMIT", "collapse", 0.4)
    draw_response(diagram_of(branch), ax=ax)
    assert texts(ax) == ["collapse"]


def test_points_of_one_type_that_crowd_share_a_name(ax):
    s = np.linspace(0, 1, 5)
    special = [drawn_point("NS", x, x, {"x": x}) for x in (0.1, 0.9, 0.905, 0.91)]
    draw_response(diagram_of(drawn_branch(s, {"x": s}, [INSIDE] * 5, special)), ax=ax)
    assert texts(ax) == ["3 NS", "NS"]


def test_a_marker_is_pale_where_it_is_not_known_whether_a_point_is_subcritical():
    s = np.linspace(0, 1, 5)
    of = ("PD", None), ("PD", "subcritical"), ("PD", "supercritical"), ("LP", None)
    special = [
        drawn_point(kind, 0.2 * i, 0.2 * i, {"x": 0.0}, criticality=criticality)
        for i, (kind, criticality) in enumerate(of)
    ]
    marks = marks_of(drawn_branch(s, {"x": s}, [INSIDE] * 5, special), "x")
    assert [mark.fill for mark in marks] == ["pale", "open", "full", "full"]


def test_unknown_output_and_measure(ax):
    with pytest.raises(InputError, match="no output 'z'"):
        draw_response(threshold_diagram(0.1), "z", ax=ax)
    with pytest.raises(InputError, match="measure 'mean'"):
        draw_response(threshold_diagram(0.1), measure="mean", ax=ax)


def test_max_and_min_are_the_lines_and_points_of_both():
    def drawn(*measures):
        ax = Figure().add_subplot()
        for measure in measures:
            draw_response(threshold_diagram(0.1, [0.3]), "y", measure, ax, annotate=False)
        return ax, sorted(line.get_xydata().tobytes() for line in ax.get_lines())

    both, lines = drawn("max_and_min")
    assert both.get_ylabel() == "max and min $y/L$"
    assert lines == drawn("max", "min")[1]
    assert lines != drawn("max", "max")[1]


def test_a_real_diagram_draws_itself():
    diagram = sf.response(sf.SlidingOscillator(), "Nd", (0, 0.98))
    ax = diagram.plot("y", measure="peak_to_peak")
    assert ax.get_ylabel() == "peak-to-peak $y/L$"
    assert texts(ax) == ["NS", "NS", "PD", "collapse"]
    ax.get_figure().draw_without_rendering()


def test_spectrum(ax, doubled):
    draw_spectrum(find_spectrum(doubled), "x", ax)
    assert ax.get_xlabel() == "frequency (Hz)"
    assert ax.get_ylabel() == "amplitude of $x/L$"
    assert texts(ax)[:3] == ["$2f$", "$3f$", "$3f/2$"]
    assert {"$f$", "$f/2$", "mean"} < set(texts(ax))
    heights = ax.get_lines()[0].get_ydata()
    assert heights[1] == pytest.approx(0.2763272675, rel=1e-6)  # shared/reference/sliding.json


def test_spectrum_of_micrometers_shows_the_lines_that_larger_ones_show(ax, doubled):
    spectrum = find_spectrum(doubled)
    small = replace(spectrum, coefficients=1e-6 * spectrum.coefficients)
    draw_spectrum(small, "x", ax)
    assert {"$f$", "$f/2$", "$3f/2$", "$2f$"} < set(texts(ax))


def test_a_time_series_is_a_line_and_of_many_vibrations_the_band_between_their_extrema(ax, doubled):
    last = doubled.output("y", start=-5)[1]
    [line] = draw_timeseries(doubled, "y", start=-5).get_lines()
    np.testing.assert_array_equal(line.get_ydata(), last)
    assert not draw_timeseries(doubled, "y", ax).get_lines()
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time (s)", "$y/L$")
    assert ax.get_title() == "band between the extrema of 1000 vibrations"
    corners = ax.collections[0].get_paths()[0].vertices
    ends = corners[np.isclose(corners[:, 0], corners[:, 0].max()), 1]
    np.testing.assert_array_equal([ends.min(), ends.max()], [last.min(), last.max()])
    assert corners[:, 0].max() == doubled.output("y")[0][-1]
    ax.set_title("of the caller", loc="left")
    draw_timeseries(doubled, "x", ax)
    assert ax.get_title(loc="left") == "of the caller"


def test_phase_portrait_has_one_dot_a_forcing_period(ax, doubled):
    draw_phase(doubled, ax=ax, periods=10)
    path, dots = ax.get_lines()
    assert len(path.get_xdata()) == 1280
    np.testing.assert_allclose(dots.get_xdata(), doubled.states[-11:-1, 0], atol=1e-12)
