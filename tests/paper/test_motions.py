"""Figures of what motions do, beyond the paper: their cases, and how they are drawn."""

import sys

import numpy as np
import pytest

import slipfold as sf
from slipfold import SlidingOscillator
from slipfold.paper import reproduce
from slipfold.paper.cases import (
    BasinCase,
    Cases,
    CompletedFigure,
    CurveCase,
    HysteresisFigure,
    SweepCase,
    motion_figures,
    read_cases,
)
from slipfold.paper.drawing import draw_motions
from slipfold.plots import figure_style

MODULE = sys.modules[reproduce.__module__]
CURVE = CurveCase(SlidingOscillator(f=12.2), "Nd", (0.06, 0.16))


@pytest.fixture(scope="module")
def small():
    """Hysteresis at 12.2 Hz and its curve completed, coarsely."""
    swept = SweepCase(CURVE, (0.06, 0.16), 6, starts=1)
    basins = [BasinCase(CURVE.model.replace(Nd=force), 12) for force in (0.08, 0.13)]
    figures = CompletedFigure(2, (CURVE,), (swept,)), HysteresisFigure(CURVE, swept, tuple(basins))
    found = {case: case.compute() for case in (swept, *basins)}
    found[CURVE] = sf.response(CURVE.model, "Nd", CURVE.span)
    return figures, found


def test_figures_need_curves_and_planes_of_the_paper():
    cases = read_cases()
    completed, second, hysteresis, regimes = motion_figures(cases)
    assert completed.curves == cases.figures[0].curves
    assert second.curves == cases.figures[1].curves
    assert hysteresis.curve.model.f == 12.2
    assert [case.model.Nd for case in hysteresis.basins] == [0.08, 0.1, 0.13]
    # Both responses are stable there: between the fold of period 2 and the period doubling.
    assert all(0.0741 < case.model.Nd < 0.1398 for case in hysteresis.basins)
    assert regimes.regimes.plane in cases.needs
    keys = [case.key for figure in motion_figures(cases) for case in figure.needs]
    assert len(set(keys)) == len({case for f in motion_figures(cases) for case in f.needs})


def test_dots_lie_on_both_responses_between_fold_and_doubling(small):
    (completed, _), found = small
    with figure_style():
        canvas = draw_motions(completed, found)
    _, right = canvas.axes
    dots = [line for line in right.lines if line.get_marker() == "o" and len(line.get_xdata()) > 1]
    up, down = (
        {
            round(float(x), 3): y
            for line in dots
            if line.get_color() == color
            for x, y in line.get_xydata()
        }
        for color in ("#2166ac", "#c0392b")
    )
    assert down[0.1] - up[0.1] > 0.1
    assert down[0.06] == pytest.approx(up[0.06], abs=1e-6)


def test_basins_have_the_same_colors_in_all_panels(small):
    (_, hysteresis), found = small
    with figure_style():
        canvas = draw_motions(hysteresis, found)
    for ax, case in zip(canvas.axes[2:], hysteresis.basins, strict=True):
        image = ax.images[0]
        (first,) = (item for item in found[case] if item.period == 1)
        ones = found[case].labels == first.id
        shown = image.cmap(image.norm(image.get_array()))
        assert np.allclose(shown[ones], shown[ones][0])
        assert shown[ones][0][:3] == pytest.approx([0xC3 / 255, 0xDE / 255, 0xD6 / 255], abs=0.01)
        share = f"{100 * ones.mean():.2g} % period 1"
        assert share in ax.get_title(loc="left")


def test_files_that_are_written(tmp_path, monkeypatch, small):
    (_, hysteresis), found = small
    monkeypatch.setattr(MODULE, "motion_figures", lambda _: (hysteresis,))
    monkeypatch.setattr(SweepCase, "compute", lambda case: found[case])
    monkeypatch.setattr(BasinCase, "compute", lambda case: found[case])
    seen = []
    made = reproduce(tmp_path, seen.append, cases=Cases(()), motions=True)
    assert not made.missing
    written = sorted(path.stem for path in made.written if path.suffix == ".nc")
    assert written == sorted(case.key for case in hysteresis.needs)
    assert {"hysteresis.pdf", "hysteresis.png"} <= {path.name for path in made.written}
    assert [item.done for item in seen] == list(range(1, 6))
