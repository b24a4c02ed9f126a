"""What is printed is one short line; what holds numbers compares without raising."""

import functools

import numpy as np
import pytest

import slipfold as sf

LONGEST = 320
"""Characters: two lines of a wide terminal."""


@functools.cache
def diagram():
    return sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.98), f=12.5)


@functools.cache
def plane():
    point = diagram().special[0]
    return sf.locus(point, ("f", "Nd"), ((12.4, 12.6), (0, 0.1)))


@functools.cache
def motion():
    return sf.simulate(sf.SlidingOscillator(), periods=1000, f=12.2, Nd=0.15)


def regions():
    check = sf.RegionCheck((1.0, 2.0), "rest", 1, True, "settled on period 1")
    region = sf.Region(1, (1,), 1.0, (1.0, 2.0), True, (check,) * 3)
    return sf.RegionMap(np.ones(4), np.ones(4), np.ones((4, 4), int), (region,) * 12)


SHOWN = {
    "diagram": diagram,
    "branch": lambda: diagram().branches[0],
    "special point": lambda: diagram().branches[1].special[0],
    "labeled point": lambda: diagram().special[0],
    "orbit": lambda: diagram().special[0].point.orbit,
    "extrema of a branch": lambda: diagram().branches[0].extrema,
    "check": lambda: diagram().special[0].point.orbit.check(),
    "collocated orbit": lambda: diagram().special[0].point.orbit.check().collocated,
    "plane": plane,
    "locus": lambda: plane().loci[0],
    "locus point": lambda: plane().special[0].point,
    "labeled locus point": lambda: plane().special[0],
    "simulation": motion,
    "spectrum": lambda: motion().spectrum(),
    "modes": lambda: sf.SlidingOscillator().modes(),
    "region map": regions,
    "region": lambda: regions().regions[0],
    "region check": lambda: regions().regions[0].checks[0],
}


@pytest.mark.parametrize("name", SHOWN)
def test_everything_prints_as_one_short_line(name):
    text = repr(SHOWN[name]())
    assert "\n" not in text
    assert "array(" not in text
    assert len(text) <= LONGEST


@pytest.mark.parametrize("name", SHOWN)
def test_everything_is_a_table_in_a_notebook(name):
    html = SHOWN[name]()._repr_html_()
    assert html.startswith(("<table", "<pre"))


def test_lines_say_what_was_found():
    first, second = diagram().branches
    start, end = "<Branch 1 of sliding: period 1, ", "Nd = 0 to 0.375947 N, PD at 0.0435789, limit>"
    assert repr(first) == f"{start}{len(first)} points, {end}"
    assert repr(first.special) == "(<PD at Nd = 0.0435789 N, supercritical, to branch 2>,)"
    assert repr(diagram().special[1]) == "<NS at Nd = 0.0566907 N, subcritical; on branch 2>"
    assert "NS at 0.0566907, NS at 0.166438" in repr(second)


SHORT = {
    "end at a limit": lambda: diagram().branches[0].stopped,
    "end at birth": lambda: diagram().branches[1].started,
    "end of a locus": lambda: plane().loci[0].stopped,
    "check": lambda: diagram().special[0].point.orbit.check(),
    "settled": lambda: motion().settlement,
    "not settled": lambda: sf.simulate(sf.SlidingOscillator(), periods=20).settlement,
    "on a cycle": lambda: sf.simulate(sf.built_in_models()["vanderpol-free"]()).settlement,
    "settings": sf.Settings,
    "other settings": lambda: sf.Settings(steps=sf.Steps(largest=0.05, points=9), largest_period=2),
}


@pytest.mark.parametrize("name", SHORT)
def test_a_verdict_prints_as_less_than_one_hundred_characters(name):
    text = repr(SHORT[name]())
    assert "\n" not in text
    assert len(text) < 100


def test_verdicts_say_what_a_person_wants():
    start, born = diagram().branches[0].stopped, diagram().branches[1].started
    assert repr(start).startswith("<End: limit at 0.375947: spring collapsed: l/L fell to")
    assert str(start) == start.reason
    assert repr(born) == "<End: bifurcation at 0.0435789: emanates at Nd = 0.0435789115>"
    settled = motion().settlement
    assert repr(settled) == f"<Settlement: settled on period 2, drift {settled.drift:.1e}>"
    assert "settled on a cycle of 6.66" in repr(SHORT["on a cycle"]())
    assert repr(SHORT["not settled"]()).startswith("<Settlement: not settled")
    assert repr(sf.Settings()) == "Settings()"
    other = SHORT["other settings"]()
    assert repr(other) == "Settings(steps=Steps(largest=0.05, points=9), largest_period=2)"
    assert eval(repr(other), vars(sf)) == other
