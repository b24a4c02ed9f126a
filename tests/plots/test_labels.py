from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from slipfold.plots.labels import Label, place_labels


@pytest.fixture
def axes():
    figure = Figure(figsize=(4, 3))
    FigureCanvasAgg(figure)
    ax = figure.add_subplot()
    ax.set_xlim(0, 1)
    ax.set_ylim(0, 1)
    return ax


def boxes(texts):
    return [text.get_window_extent() for text in texts]


def test_labels_of_one_cluster_do_not_overlap(axes):
    points = [(0.5 + 0.01 * i, 0.5) for i in range(8)]
    texts = place_labels(axes, [Label("PD", np.array([point])) for point in points])
    for one, other in combinations(boxes(texts), 2):
        assert not one.overlaps(other)


def test_labels_stay_inside(axes):
    corners = [(0, 0), (0, 1), (1, 0), (1, 1)]
    texts = place_labels(axes, [Label("collapse", np.array([corner])) for corner in corners])
    frame = axes.get_window_extent()
    for box in boxes(texts):
        assert frame.x0 <= box.x0 < box.x1 <= frame.x1
        assert frame.y0 <= box.y0 < box.y1 <= frame.y1


def test_labels_keep_off_lines(axes):
    axes.plot([0, 1], [0.55, 0.55], color="black")
    [text] = place_labels(axes, [Label("LP", np.array([[0.5, 0.5]]))])
    height = axes.transData.transform((0, 0.55))[1]
    box = text.get_window_extent()
    assert not box.y0 < height < box.y1


def test_a_name_goes_where_its_line_is_alone(axes):
    line = np.column_stack([np.linspace(0, 1, 50), np.full(50, 0.5)])
    axes.plot([0, 0.7], [0.52, 0.52], color="red")
    axes.plot([0, 0.7], [0.48, 0.48], color="red")
    [text] = place_labels(axes, [Label("mine", line, "blue")])
    assert text.xy[0] > 0.7


def test_a_far_label_is_joined_to_its_point(axes):
    # Twelve texts for one point: the last ones are far.
    place_labels(axes, [Label("NS", np.array([[0.5, 0.5]]))] * 12)
    assert len(axes.texts) > 12


@pytest.mark.parametrize("x", [0.06, 0.07, 0.08])
def test_labels_keep_off_ticks_that_point_inwards(axes, x):
    axes.tick_params(direction="in", length=8)
    ticks = np.linspace(0, 1, 21)
    axes.set_yticks(ticks)
    for y in np.linspace(0, 1, 60):  # no room on the right
        axes.plot([x, 1], [y, y], color="black")
    [text] = place_labels(axes, [Label("PD", np.array([[x, 0.6]]))])
    box, left = text.get_window_extent(), axes.get_window_extent().x0
    for _, height in axes.transData.transform(np.column_stack([0 * ticks, ticks])):
        reaches = box.x0 < left + 8 * axes.figure.dpi / 72
        assert not (reaches and box.y0 < height < box.y1)
