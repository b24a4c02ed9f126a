"""Bifurcation sets beyond the paper: their cases, their figures, and what is said of them."""

import math
import sys
from functools import partial

import pytest
from PIL import Image

import slipfold as sf
from helpers.hand_drawn_loci_plots import (
    drawn_fold,
    drawn_locus,
    drawn_regions,
    drawn_torus,
    locus_diagram,
    valley,
)
from slipfold import SlidingOscillator
from slipfold.paper import reproduce
from slipfold.paper.cases import Cases, Plane, PlaneFigure, read_cases
from slipfold.paper.drawing import draw_plane
from slipfold.paper.tables import planes_markdown
from slipfold.plots import figure_style

MODULE = sys.modules[reproduce.__module__]
PLANES = read_cases().planes
SMALL = PlaneFigure(
    Plane(SlidingOscillator(), ("f", "Nd"), ((12.40, 12.48), (0.0, 0.06))),
    "A small window",
    ((12.42, 12.45), (0.03, 0.05)),
)


def test_planes():
    assert [figure.plane.vary for figure in PLANES] == [
        (name, "Nd") for name in ("f", "Vd", "alpha", "mu", "Ns")
    ]
    spans = [figure.plane.window[0] for figure in PLANES]
    assert spans == [(11.5, 13.5), (0.2, 1.2), (0.1, math.pi - 0.1), (0.1, 0.9), (0.2, 2.0)]
    assert {figure.plane.model for figure in PLANES} == {SlidingOscillator()}


def markdown(*loci, regions=None):
    diagram = locus_diagram(*loci, regions=regions)
    return planes_markdown(PLANES[:1], {PLANES[0].plane: diagram})


def test_the_text_says_where_the_criticality_changes_and_the_threshold_is_lowest():
    text = markdown(valley(), drawn_fold(), drawn_torus(), regions=drawn_regions())
    assert "GPD, f = 12.4 Hz (± 1e-12), Nd = 0.06 N (± 2e-13)" in text
    assert "subcritical for f from 12 Hz to 12.4 Hz" in text
    assert "supercritical for f from 12.4 Hz to 13 Hz" in text
    assert "The threshold is lowest at f = 12.5 Hz (± 1e-12), Nd = 0.05 N (± 2e-13)** (MIN)" in text


def test_the_text_does_not_hide_a_simulation_that_disagrees():
    text = markdown(valley(), regions=drawn_regions(agrees=False))
    assert "Simulations that agree: 2 of 3." in text
    assert "| 0 of 1 agree | from rest: nothing periodic |" in text


@pytest.mark.parametrize("figure", PLANES, ids=lambda figure: figure.plane.vary[0])
def test_figures_show_the_window_and_a_detail(figure):
    vary, window = figure.plane.vary, figure.plane.window
    (left, right), (_, top) = window
    values = [(left, 0.1 * top), ((left + right) / 2, 0.05 * top), (right, 0.1 * top)]
    diagram = locus_diagram(drawn_locus("PD", values, vary=vary), vary=vary, window=window)
    with figure_style():
        whole, detail = draw_plane(figure, diagram).axes
    assert (whole.get_xlim(), whole.get_ylim()) == window
    assert (detail.get_xlim(), detail.get_ylim()) == figure.detail
    assert whole.get_title(loc="left").startswith("(a)  $")
    assert detail.get_title(loc="left") == "(b)  detail of (a)"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A small bifurcation set without regions, which take long; with what the observer saw."""
    seen = []
    cases = Cases((), (), (SMALL,))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(MODULE, "bifurcation_set", partial(sf.bifurcation_set, regions=False))
        return reproduce(tmp_path_factory.mktemp("planes"), seen.append, cases=cases), seen


def test_files(made):
    found = sorted(
        str(path.relative_to(made[0].out)) for path in made[0].out.rglob("*") if path.is_file()
    )
    figures = ["bifurcation_set_f_Nd.pdf", "bifurcation_set_f_Nd.png"]
    tables = ["bifurcation_sets.md", "claims.md", "data/plane_f_Nd.nc", "thresholds.csv"]
    assert found == figures + tables
    assert (made[0].missing, made[0].stopped) == ((), ())
    with Image.open(made[0].out / figures[1]) as image:
        assert image.width == 2070
