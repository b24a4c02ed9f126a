import itertools
import re
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import to_rgb

import slipfold
from slipfold.orbits.bifurcation_types import BIFURCATION_TYPES
from slipfold.plots.loci import LOCUS_COLORS
from slipfold.plots.regions import OTHERS, PALE, region_color
from slipfold.plots.style import figure_style, palette

# Machado, Oliveira & Fernandes 2009, doi:10.1109/TVCG.2009.113, severity 1, in linear RGB.
BLINDNESS = {
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}


def linear(color):
    rgb = np.array(to_rgb(color))
    return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)


def lightness(rgb):
    """CIE L* of linear RGB."""
    luminance = float(np.clip(rgb, 0, 1) @ [0.2126, 0.7152, 0.0722])
    return 116 * np.cbrt(luminance) - 16 if luminance > 0.008856 else 903.3 * luminance


@pytest.mark.parametrize("count", [1, 2, 3, 4])
@pytest.mark.parametrize("sight", [None, *BLINDNESS])
def test_colors_differ_in_lightness_for_everyone(count, sight):
    matrix = np.eye(3) if sight is None else np.array(BLINDNESS[sight])
    values = [lightness(matrix @ linear(color)) for color in palette(count)]
    assert np.all(np.diff(values) > (15 if sight is None else 10))
    assert values[-1] < 80  # still seen on white


def combinations(most):
    return [(1,) * (n - k) + (2,) * k for n in range(most + 1) for k in range(n + 1)]


@pytest.mark.parametrize("sight", [None, *BLINDNESS])
def test_every_line_is_seen_on_every_area(sight):
    matrix = np.eye(3) if sight is None else np.array(BLINDNESS[sight])
    darkest = max(lightness(matrix @ linear(color)) for color in LOCUS_COLORS.values())
    areas = [region_color(stable) for stable in [*combinations(9), (4,), (1, 4), (1, 1, 8)]]
    assert min(lightness(matrix @ linear(color)) for color in areas) > darkest + 10


def test_no_two_kinds_of_regions_share_a_color():
    kinds = [*combinations(6), (3,), (4,), (1, 4), (4, 4), (8,)]
    assert len({region_color(stable) for stable in kinds}) == len(kinds)
    shown = [np.array(to_rgb(region_color(stable))) for stable in combinations(4)]
    assert min(np.abs(a - b).max() for a, b in itertools.combinations(shown, 2)) > 0.05
    assert {*PALE.values(), *OTHERS} > {region_color(stable) for stable in combinations(4)}


def test_style_ends_with_its_context():
    before = mpl.rcParams["pdf.fonttype"], mpl.rcParams["font.size"]
    with figure_style():
        assert mpl.rcParams["pdf.fonttype"] == 42
        assert mpl.rcParams["savefig.dpi"] == 300
    assert (mpl.rcParams["pdf.fonttype"], mpl.rcParams["font.size"]) == before


def test_the_page_draws_special_points_as_figures_do():
    page = Path(slipfold.__file__).parent / "interface/explorer/page" / "diagram_data.js"
    table = re.search(r"export const MARKERS = \{(.*?)\}", page.read_text(), re.DOTALL).group(1)
    drawn = dict(re.findall(r'(\w+): "([\w-]+)"', table))
    shapes = {"o": "circle", "s": "square", "^": "triangle-up", "D": "diamond", "p": "pentagon"}
    expected = {name: shapes[item.marker] for name, item in BIFURCATION_TYPES.items()}
    assert {name: drawn[name] for name in expected} == expected
