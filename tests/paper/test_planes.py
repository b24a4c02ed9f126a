"""Bifurcation sets beyond the paper: their cases, their figures, and what is said of them."""

import math
from functools import partial
from types import SimpleNamespace

import pytest
from PIL import Image

import slipfold as sf
from helpers.hand_drawn_loci_plots import drawn_locus, locus_diagram
from slipfold import SlidingOscillator
from slipfold.computations import loci
from slipfold.interface.paper import reproduce
from slipfold.interface.paper.cases import Case, Cases, Figure, read_cases
from slipfold.interface.paper.drawing import draw
from slipfold.interface.paper.tables import planes_markdown
from slipfold.plots import figure_style

PLANES = read_cases().of_kind("plane")
WINDOW = ((12.40, 12.48), (0.0, 0.06))
SMALL = Figure(
    "bifurcation_set_f_Nd",
    "plane",
    "A small window",
    cases=(Case("bifurcation_set", SlidingOscillator(), ("f", "Nd"), WINDOW),),
    detail=((12.42, 12.45), (0.03, 0.05)),
)


def test_planes():
    planes = [figure.cases[0] for figure in PLANES]
    assert [plane.vary for plane in planes] == [
        (name, "Nd") for name in ("f", "Vd", "alpha", "mu", "Ns")
    ]
    spans = [plane.spans[0] for plane in planes]
    assert spans == [(11.5, 13.5), (0.2, 1.2), (0.1, math.pi - 0.1), (0.1, 0.9), (0.2, 2.0)]
    assert {plane.model for plane in planes} == {SlidingOscillator()}


def test_the_text_has_the_summary_of_each_plane_that_was_computed():
    diagram = SimpleNamespace(summary=lambda: "the loci of the first plane")
    text = planes_markdown(PLANES[:2], {PLANES[0].cases[0]: diagram})
    assert "```text\nthe loci of the first plane\n```" in text
    assert text.count("Not computed.") == 1


@pytest.mark.parametrize("figure", PLANES, ids=lambda figure: figure.cases[0].vary[0])
def test_figures_show_the_window_and_a_detail(figure):
    (plane,) = figure.cases
    vary, window = plane.vary, plane.spans
    (left, right), (_, top) = window
    values = [(left, 0.1 * top), ((left + right) / 2, 0.05 * top), (right, 0.1 * top)]
    diagram = locus_diagram(drawn_locus("PD", values, vary=vary), vary=vary, window=window)
    with figure_style():
        whole, detail = draw(figure, {plane: diagram}).axes
    assert (whole.get_xlim(), whole.get_ylim()) == window
    assert (detail.get_xlim(), detail.get_ylim()) == figure.detail
    assert whole.get_title(loc="left").startswith("(a)  $")
    assert detail.get_title(loc="left") == "(b)  detail of (a)"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """One locus of a small window, since all of it takes long; with what the observer saw."""
    seen = []
    cases = Cases((SMALL,))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(loci, "bifurcation_set", partial(sf.bifurcation_set, types="PD", periods=1))
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
