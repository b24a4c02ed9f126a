"""Loci and bifurcation sets computed: from a special point or a window to a loaded result."""

import numpy as np
import pytest

from helpers.locus_diagrams import assert_same
from slipfold import (
    Event,
    InputError,
    Settings,
    SlidingOscillator,
    Steps,
    bifurcation_set,
    locus,
    response,
)
from slipfold.bifurcations.loci import isolated

PLANE = ("f", "Nd")
WINDOW = ((12.3, 12.6), (0.0, 0.1))


@pytest.fixture(scope="module")
def diagram():
    return response(SlidingOscillator(), "Nd", (0, 0.05), f=12.5, events=[Event("x", 0.121)])


@pytest.fixture(scope="module")
def doubling(diagram):
    return next(item for item in diagram.special if item.point.type == "PD")


@pytest.fixture(scope="module")
def found(doubling):
    return locus(doubling.point, PLANE, WINDOW)


def test_locus_from_a_special_point(found, doubling):
    first = found.loci[0]
    assert (first.type, first.period, first.parent) == ("PD", 1, None)
    assert found.vary == PLANE
    assert found.window == WINDOW
    assert found.model == SlidingOscillator(f=12.3, Nd=0)
    assert found.settings == Settings()
    assert found.regions is None
    assert not found.interrupted
    assert not found.failed
    gap = np.abs(first.values - [12.5, doubling.point.value]).sum(axis=1).min()
    assert gap < 1e-9
    assert {point.type for _, point in found.special} >= {"GPD", "MIN"}


def test_an_item_of_a_diagram_will_do(doubling):
    window = {"Nd": (0, "100mN"), "f": ("12.6Hz", 12.3)}
    (again,) = locus(doubling, PLANE, window, switch=False).loci
    (alone,) = locus([doubling, doubling.point], PLANE, WINDOW, switch=False).loci
    assert alone.id == 1
    assert_same(alone, again)


def test_no_window_is_one_sentence(doubling):
    with pytest.raises(InputError, match="no window is given; give two values each for f and Nd"):
        locus(doubling, PLANE)
    with pytest.raises(InputError, match="no window is given; give two values each for f and Nd"):
        bifurcation_set(SlidingOscillator(), PLANE)


def test_settings_reach_the_computation(doubling):
    settings = Settings(steps=Steps(points=3))
    diagram = locus(doubling, PLANE, WINDOW, settings=settings)
    assert diagram.settings == settings
    assert diagram.failed


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"special_point": "PD"}, "'PD' is not a special point of a branch"),
        ({"special_point": None}, "None is not a special point of a branch; give e.g. diagram"),
        ({"special_point": ()}, "no special point is given"),
        ({"vary": ("f", "f")}, "f is given for both"),
        ({"vary": ("mu", "f")}, "f = 0 is outside its bounds"),
        ({"window": ((12.3, 12.4), (0, 0.1))}, "is outside the window"),
        ({"window": ((12.3, 12.6), (0, 1.2))}, "give Nd < Ns"),
        ({"window": ((12.3, 12.3), (0, 0.1))}, "empty"),
        ({"settings": Settings(), "window": None}, "no window is given; give two values each"),
        ({"settings": 3}, "settings = 3 are not options of continuation; give e.g. Settings"),
        ({"vary": (1, 2)}, "1 is not the name of a parameter; give two names"),
        ({"window": ((12.3, 12.6), (False, True))}, "Nd holds False, which is not a number"),
    ],
)
def test_bad_input(doubling, changes, message):
    given = {"special_point": doubling, "vary": PLANE, "window": WINDOW} | changes
    with pytest.raises(InputError, match=message):
        locus(**given)


def test_an_event_has_no_locus(diagram):
    event = next(item for item in diagram.special if item.point.type == "EVENT")
    with pytest.raises(InputError, match="EVENT has no locus in f and Nd"):
        locus(event, PLANE, WINDOW)


def test_points_of_different_models(diagram, doubling):
    other = response(SlidingOscillator(), "Nd", (0, 0.05), f=12.5, mu=0.49).special[0]
    with pytest.raises(InputError, match=r"differ in mu: 0\.5 and 0\.49"):
        locus([doubling, other], PLANE, WINDOW)


# -- bifurcation sets --------------------------------------------------------------------------

ONE = {"types": "pd", "periods": 1, "regions": False}
"""The same: one type and one period need no list."""


def test_set_from_a_window(found, few_lines, monkeypatch):
    followed, trace = [], isolated.trace_response

    def watched(*given, begin, **options):
        followed.append(begin.orbit.period)
        return trace(*given, begin=begin, **options)

    monkeypatch.setattr(isolated, "trace_response", watched)
    window = {"Nd": (0, "100mN"), "f": WINDOW[0]}
    diagram = bifurcation_set(SlidingOscillator(), PLANE, window, **ONE)
    assert set(followed) <= {1}  # motions of period 2 are there, and lead to nothing asked for
    assert [(item.type, item.period) for item in diagram.loci] == [("PD", 1)]
    assert diagram.model == SlidingOscillator(f=12.3, Nd=0)
    assert not diagram.interrupted
    minimum = [p.values for _, p in diagram.special if p.type == "MIN"]
    expected = [p.values for item, p in found.special if p.type == "MIN" and item.type == "PD"]
    np.testing.assert_allclose(minimum, expected, rtol=1e-8)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"model": "sliding"}, "is not a model"),
        ({"window": None}, "no window is given; give two values each for f and Nd"),
        ({"plane": (1, 2)}, "1 is not the name of a parameter; give two names"),
        ({"settings": 3}, "settings = 3 are not options of continuation"),
        ({"types": 3, "regions": False}, "no loci of type 3; give LP, PD, NS, BP"),
        ({"periods": 3, "regions": False}, "period = 3 is neither 1 nor 2"),
        ({"periods": 1.5, "regions": False}, "period = 1.5 is neither 1 nor 2"),
        ({"periods": True, "regions": False}, "period = True is not a number of forcing periods"),
        ({"f": 12}, "f is varied, so it cannot be set to 12 as well; give it once, in the window"),
        ({"mu": -1}, "mu must be >= 0"),
        ({"mass": 1}, "no parameter 'mass'"),
        ({"plane": ("f", "F")}, "no parameter 'F'"),
        ({"plane": ("Nd", "Nd")}, "Nd is given for both"),
        ({"window": ((12, 13), (0, 1.5))}, "give Nd < Ns"),
        ({"types": ["CP"], "regions": False}, "no loci of type 'CP'; give LP, PD, NS, BP"),
        ({"types": (), "regions": False}, "no type or no period"),
        ({"periods": [3], "regions": False}, "period = 3 is neither 1 nor 2"),
        ({"types": ["PD"], "regions": True}, "regions need the loci of all types"),
        ({"types": ["PD"], "regimes": (2, 2)}, "regions need the loci of all types"),
    ],
)
def test_bad_input_for_a_set(changes, message):
    given = {"model": SlidingOscillator(), "plane": PLANE, "window": WINDOW} | changes
    with pytest.raises(InputError, match=message):
        bifurcation_set(**given)
