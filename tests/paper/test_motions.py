"""Figures of what solutions do, beyond the paper: their cases, and how they are drawn."""

import numpy as np
import pytest

from slipfold import SlidingOscillator
from slipfold.interface.paper import reproduce
from slipfold.interface.paper.cases import Case, Cases, Figure, read_cases
from slipfold.interface.paper.drawing import draw
from slipfold.plots import figure_style

MODEL = SlidingOscillator(f=12.2)
CURVE = Case("response", MODEL, ("Nd",), ((0.06, 0.16),))


@pytest.fixture(scope="module")
def small():
    """Hysteresis at 12.2 Hz and its curve completed, coarsely."""
    swept = Case("sweep", MODEL, CURVE.vary, ((0.06, 0.14),), (3,), starts=1)
    basins = [Case("basins", MODEL.replace(Nd=force), points=(6,)) for force in (0.08, 0.13)]
    cases = (CURVE, swept, *basins)
    figures = (
        Figure("figure2_completed", "completed", cases=cases[:2]),
        Figure("hysteresis", "hysteresis", cases=cases),
    )
    return figures, {case: case.compute() for case in cases}


def test_figures_need_curves_and_planes_of_the_paper():
    cases = read_cases(long_term=True)
    completed, second = cases.of_kind("completed")
    ((hysteresis,), (regimes,)) = map(cases.of_kind, ("hysteresis", "regimes"))
    assert completed.of_kind("response") == cases.figures[0].of_kind("response")
    assert second.of_kind("response") == cases.figures[1].of_kind("response")
    assert hysteresis.cases[0].model.f == 12.2
    forces = [case.model.Nd for case in hysteresis.of_kind("basins")]
    assert forces == [0.08, 0.1, 0.13]
    # Both responses are stable there: between the fold of period 2 and the period doubling.
    assert all(0.0741 < force < 0.1398 for force in forces)
    assert regimes.cases[0] in read_cases().needs
    assert len({case.key for case in cases.needs}) == len(cases.needs)


def test_dots_lie_on_both_responses_between_fold_and_doubling(small):
    (completed, _), found = small
    with figure_style():
        canvas = draw(completed, found)
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
        canvas = draw(hysteresis, found)
    for ax, case in zip(canvas.axes[2:], hysteresis.cases[2:], strict=True):
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
    monkeypatch.setattr(Case, "compute", lambda case, *_, **__: found[case])
    seen = []
    made = reproduce(tmp_path, seen.append, cases=Cases((hysteresis,)))
    assert not made.missing
    written = sorted(path.stem for path in made.written if path.suffix == ".nc")
    assert written == sorted(case.key for case in hysteresis.needs)
    assert {"hysteresis.pdf", "hysteresis.png"} <= {path.name for path in made.written}
    assert [item.done for item in seen] == list(range(1, 6))
