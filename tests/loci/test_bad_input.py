"""Input that cannot be used is refused in one sentence that says what to do."""

import re

import pytest

from helpers.bifurcation_sets import bifurcations, response
from helpers.textbook_models import Mathieu, Torus
from helpers.toy_models import Falling
from slipfold import InputError, Parameter, SlidingOscillator
from slipfold.bifurcations.branches.response import trace_response
from slipfold.bifurcations.loci.bifurcation_set import find_bifurcation_set
from slipfold.bifurcations.loci.follow import follow_loci

FORCE, WINDOW = ("f", "Nd"), ((12.0, 13.0), (0.0, 0.5))


@pytest.fixture(scope="module")
def doubling():
    (found,) = bifurcations(response("Nd", (0.0, 0.98), (("f", 12.5),)), "PD")
    return found


def refusal(points, plane=FORCE, window=WINDOW):
    with pytest.raises(InputError) as caught:
        follow_loci(points, plane, window)
    text = str(caught.value)
    assert "\n" not in text
    assert not re.search(r"[.!?](?: |$)", text.replace("e.g. ", ""))  # one sentence
    return text


def test_parameters_that_do_not_move_it():
    # The torus of the normal form is at m = 0 whatever v and n are.
    (point,) = trace_response(Torus(), "m", (-0.5, 0.4))[0].special
    text = refusal([point], ("v", "n"), ((0.5, 2.0), (0.5, 2.0)))
    assert "NS at v = 1, n = 1 has no locus in v and n: neither of them moves it" in text


def test_a_parameter_that_moves_nothing_but_one_that_does_is_fine():
    (point,) = trace_response(Mathieu(), "h", (0.0, 0.1))[0].special[:1]
    (found,) = follow_loci([point], ("g", "h"), ((0.5, 2.0), (0.0, 0.1)), switch=False)
    assert found.values[:, 1] == pytest.approx(point.value, abs=1e-11)


def test_special_points_of_different_parameters(doubling):
    (other,) = bifurcations(response("Nd", (0.0, 0.98), (("f", 12.5), ("Vd", 0.4))), "PD")
    assert refusal([doubling, other]) == (
        "the special points differ in Vd: 0.6 and 0.4; vary Vd or follow them one by one"
    )
    # In a plane that has what they differ in both are taken.
    loci = follow_loci([doubling, other], ("Vd", "Nd"), ((0.3, 1.0), (0.0, 0.5)), switch=False)
    assert len(loci) == 1


# -- sets --------------------------------------------------------------------------------------


def refused_set(model=None, plane=FORCE, window=WINDOW, **keys):
    with pytest.raises(InputError) as caught:
        find_bifurcation_set(model or SlidingOscillator(), plane, window, **keys)
    text = str(caught.value)
    assert "\n" not in text
    return text


class Drifting(Falling):
    """It falls for ever: no motion is periodic."""

    name = "drifting"
    parameters = (*Falling.parameters, Parameter("g", 1.0, lower=0.5))
    limits = ()

    def coefficients(self, p):
        return {"g": p["g"]}


def test_set_of_a_window_without_any_response():
    text = refused_set(Drifting(), ("f", "g"), ((1.0, 2.0), (0.5, 1.0)), regions=False)
    assert "no response exists on any of" in text
