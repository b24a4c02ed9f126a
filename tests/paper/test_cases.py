import math

import pytest

from slipfold import SlidingOscillator
from slipfold.interface.paper.cases import Case, read_cases

CASES = read_cases()
FIGURES = CASES.of_kind("family")


def members(number, row=0):
    [figure] = [figure for figure in FIGURES if figure.number == number]
    family = figure.rows[row]
    return [curve.model.values[family.member] for curve in family.curves]


def test_figures_are_those_of_the_paper():
    assert [figure.number for figure in FIGURES] == [2, 3, 4, 5, 6, 7]
    assert members(2) == [12.5, 12.2]
    assert members(3) == [0.05, 0.10, 0.15]
    assert members(4) == [0.4, 0.6, 0.8, 1.0]
    assert members(5) == [0.6, 0.8, 1.0]
    assert members(6) == [0.3, 0.4, 0.5, 0.6]
    for row in (0, 1):
        assert members(7, row) == pytest.approx([math.radians(a) for a in (30, 45, 60, 75)])


def test_what_is_set_besides():
    speeds = {
        (figure.number, row_number): {curve.model.Vd for curve in row.curves}
        for figure in FIGURES
        for row_number, row in enumerate(figure.rows)
    }
    assert speeds[5, 0] == speeds[6, 0] == speeds[7, 1] == {1.0}
    assert speeds[7, 0] == {0.6}
    frequencies = {
        curve.model.f
        for figure in FIGURES
        if figure.number > 3
        for curve in figure.of_kind("response")
    }
    assert frequencies == {12.5}


def test_equal_curves_are_computed_once():
    assert len(CASES.needs) == 24 + len(CASES.of_kind("plane"))
    base = Case("response", SlidingOscillator(), ("Nd",), ((0.0, 0.98),))
    assert CASES.shown_in(base) == (2, 4, 7)
    fast = Case("response", SlidingOscillator(Vd=1.0), ("Nd",), ((0.0, 0.98),))
    assert CASES.shown_in(fast) == (4, 5, 6, 7)


def test_claim_9_needs_curves_no_figure_shows():
    [(number, row)] = CASES.further
    assert number == 9
    assert [curve.model.mu for curve in row.curves] == [0.3, 0.4, 0.5, 0.6]
    assert [bool(CASES.shown_in(curve)) for curve in row.curves] == [False, False, True, False]


def test_only_some_figures():
    some = CASES.only([5])
    assert [figure.number for figure in some.figures] == [5]
    assert len(some.needs) == 3
