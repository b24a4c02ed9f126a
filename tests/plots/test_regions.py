import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from helpers.hand_drawn_loci_plots import WINDOW, drawn_regions, locus_diagram, valley
from slipfold import Region, RegionMap
from slipfold.lines import locus_segments
from slipfold.plots.labels import place_labels
from slipfold.plots.loci import legend_options
from slipfold.plots.regions import (
    PALE,
    PIXELS,
    draw_regions,
    region_labels,
    sharpen,
)

LINES = [stretch.points for stretch in locus_segments(valley())]


def pixels(view):
    """Values of both parameters in each pixel."""
    axes = [
        low + (np.arange(count) + 0.5) * (high - low) / count
        for (low, high), count in zip(view, PIXELS, strict=True)
    ]
    return np.meshgrid(*axes)


def wrong(labels, view):
    f, force = pixels(view)
    return np.mean((labels == 1) != (force > 0.05 + (f - 12.5) ** 2))


@pytest.mark.parametrize("view", [WINDOW, ((12.3, 12.7), (0.0, 0.1))])
def test_borders_follow_lines_and_not_cells(view):
    regions = drawn_regions(cells=30)
    assert wrong(sharpen(regions, LINES, WINDOW, view), view) < 3e-3
    assert wrong(sharpen(regions, [], WINDOW, view), view) > 0.01


def test_a_wedge_narrower_than_a_cell_has_its_own_label():
    # Between two lines that meet at the left; cells are 0.02 wide and high. Those of the wedge are
    # lost where it is narrower than three of them, as they may be in a map.
    centers = np.linspace(0, 1, 101)[1::2]
    x, y = np.meshgrid(centers, centers)
    labels = np.where(y < 0.5 - 0.2 * x, 1, np.where(y < 0.5 + 0.2 * x, 2, 3)).astype(np.int64)
    labels[(labels == 2) & (x < 0.15)] = 1
    places = tuple(Region(i, (i,), 0.3, (0.5, 0.5)) for i in (1, 2, 3))
    lines = [np.array([[0.0, 0.5], [1.0, 0.5 + slope]]) for slope in (-0.2, 0.2)]
    window = ((0.0, 1.0), (0.0, 1.0))
    sharp = sharpen(RegionMap(centers, centers, labels, places), lines, window)
    u, v = pixels(window)
    inside = (np.abs(v - 0.5) < 0.2 * u - 0.005) & (u > 0.05)
    assert np.mean(sharp[inside] == 2) == 1.0


@pytest.fixture
def ax():
    figure = Figure(figsize=(4, 3))
    FigureCanvasAgg(figure)
    ax = figure.add_subplot()
    ax.set_xlim(WINDOW[0])
    ax.set_ylim(WINDOW[1])
    return ax


def test_names_lie_inside_their_regions(ax):
    regions = drawn_regions()
    sharp = sharpen(regions, LINES, WINDOW)
    draw_regions(ax, regions, sharp)
    texts = place_labels(ax, region_labels(ax, regions))
    assert [text.get_text() for text in texts] == ["period 2", "period 1"]
    for text, region in zip(texts, regions.regions, strict=True):
        corners = ax.transData.inverted().transform(text.get_window_extent().get_points())
        for f in corners[:, 0]:
            for force in corners[:, 1]:
                assert regions.at(f, force) is region


def test_a_region_whose_check_disagrees_is_drawn_as_unknown(ax):
    regions = drawn_regions(agrees=False)
    draw_regions(ax, regions, sharpen(regions, LINES, WINDOW))
    (image,) = ax.images
    assert to_hex(image.cmap(image.norm(1))) == "#ffffff"
    assert to_hex(image.cmap(image.norm(2))) == PALE[(1,)]
    (hatched,) = (item for item in ax.collections if item.hatches)
    (area,) = hatched.get_paths()
    assert area.contains_point((12.5, 0.3))
    assert not area.contains_point((12.5, 0.02))
    assert [label.text for label in region_labels(ax, regions)] == ["unknown", "period 1"]
    diagram = locus_diagram(valley(), regions=regions)
    shades = [item for item in legend_options([diagram])["handles"] if isinstance(item, Patch)]
    assert [shade.get_label() for shade in shades] == ["stable: period 1", "unknown"]
