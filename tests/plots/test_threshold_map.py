from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from helpers.threshold_maps import made_map
from slipfold.plots import draw_threshold_map
from slipfold.plots.maps import HATCHES

SPEEDS, ANGLES = np.linspace(0.4, 1.0, 7), np.radians(np.linspace(30, 75, 6))


def drawn_map(kinds=None, values=None, **changes):
    kinds = np.full((7, 6), "") if kinds is None else kinds
    plane = 0.1 * SPEEDS[:, None] + 0.2 * ANGLES if values is None else values
    over = {"Vd": SPEEDS, "alpha": ANGLES}
    return made_map(over=over, values=np.where(kinds == "", plane, np.nan), kinds=kinds, **changes)


def failed_map():
    kinds = np.full((len(SPEEDS), len(ANGLES)), "", dtype="U30")
    kinds[:2, :2] = "limit: lost contact"
    kinds[6, 3:] = "no PD in the span"
    kinds[3, 3] = "interrupted"
    return drawn_map(kinds)


def bar(ax):
    [other] = [each for each in ax.get_figure().axes if each is not ax]
    return other


def mesh(ax):
    [found] = [item for item in ax.collections if hasattr(item, "get_coordinates")]
    return found


def lines(ax):
    [found] = [item for item in ax.collections if hasattr(item, "levels")]
    return found


def written(ax):
    ax.get_figure().draw_without_rendering()
    return [text.get_text() for text in ax.texts if text.get_text()]


def test_axes_have_symbols_units_and_the_grid(ax):
    assert draw_threshold_map(drawn_map(), ax) is ax
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$V_d$ (m/s)", r"$\alpha$ (°)")
    assert bar(ax).get_ylabel() == "$N_d$ (N) at the first PD"
    assert (ax.get_xlim(), ax.get_ylim()) == ((0.4, 1.0), (ANGLES[0], ANGLES[-1]))
    assert ax.get_legend() is None


def test_every_point_colors_its_neighborhood(ax):
    found = drawn_map()
    draw_threshold_map(found, ax)
    assert mesh(ax).get_array().tolist() == found.values.T.tolist()
    edges = np.asarray(mesh(ax).get_coordinates())[0, :, 0]
    assert edges == pytest.approx([0.4, 0.45, 0.55, 0.65, 0.75, 0.85, 0.95, 1.0])
    assert mesh(ax).get_clim() == (found.values.min(), found.values.max())


def test_contour_lines_lie_at_the_ticks_of_the_color_bar(ax):
    found = drawn_map()
    draw_threshold_map(found, ax)
    levels = lines(ax).levels
    assert len(levels) > 2
    assert set(levels) <= set(bar(ax).get_yticks())
    for level, path in zip(levels, lines(ax).get_paths(), strict=True):
        speed, angle = path.vertices.T
        assert 0.1 * speed + 0.2 * angle == pytest.approx(level)
    assert sorted(written(ax)) == [f"{level:g}" for level in levels]


def test_failures_are_hatched_by_kind(ax):
    draw_threshold_map(failed_map(), ax)
    drawn = {patch.get_label(): patch for patch in ax.patches}
    assert list(drawn) == ["limit: lost contact", "no PD in the span"]
    assert [patch.get_hatch() for patch in drawn.values()] == list(HATCHES[:2])
    contact, beyond = (patch.get_path() for patch in drawn.values())
    assert contact.contains_points([(0.41, 0.53), (0.54, 0.7)]).all()
    assert not contact.contains_points([(0.56, 0.7), (0.54, 0.8)]).any()
    assert beyond.contains_points([(0.96, ANGLES[3]), (0.99, ANGLES[5] - 0.01)]).all()
    assert len(contact.vertices) == 5 * 4
    assert len(beyond.vertices) == 5 * 3


def test_the_legend_explains_the_hatches(ax):
    draw_threshold_map(failed_map(), ax)
    legend = ax.get_legend()
    assert legend.get_title().get_text() == "no threshold"
    assert [text.get_text() for text in legend.get_texts()] == [
        "limit: lost contact",
        "no PD in the span",
        "interrupted",
    ]
    hatches = [patch.get_hatch() for patch in legend.get_patches()]
    assert hatches == [*HATCHES[:2], None]
    ax.get_figure().draw_without_rendering()
    box = legend.get_window_extent()
    assert box.y1 < ax.xaxis.label.get_window_extent().y0
    assert box.y0 > 0
    other = Figure().add_subplot()
    draw_threshold_map(failed_map(), other, legend=False)
    assert other.get_legend() is None


def test_a_map_without_any_threshold(ax):
    draw_threshold_map(drawn_map(np.full((7, 6), "no PD in the span")), ax)
    assert ax.get_figure().axes == [ax]
    assert len(ax.patches) == 1
    assert not ax.collections


def test_thresholds_that_are_angles_are_shown_in_degrees(ax):
    degrees = 20 + 60 * np.arange(42).reshape(7, 6) / 41
    found = drawn_map(threshold="mu", values=degrees)
    assert draw_threshold_map(found, ax).get_xlabel() == "$V_d$ (m/s)"
    assert bar(ax).get_ylabel() == r"$\mu$ at the first PD"
    over = {"Vd": SPEEDS, "f": np.linspace(12, 13, 6)}
    angles = replace(found, threshold="alpha", over=over, values=np.radians(degrees))
    other = Figure(layout="constrained").add_subplot()
    draw_threshold_map(angles, other)
    assert bar(other).get_ylabel() == r"$\alpha$ (°) at the first PD"
    assert np.degrees(lines(other).levels) == pytest.approx([30, 40, 50, 60, 70])
    assert sorted(written(other))[0] == "30°"
