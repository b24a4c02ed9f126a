"""Equilibria that Newton's method does not reach from where a model starts."""

import numpy as np
import pytest

import slipfold as sf
from slipfold.models.equilibria import search_equilibrium


def system(limits=None, **rates):
    return sf.System(name="own", states=rates, **({"limits": limits} if limits else {}))


@pytest.mark.parametrize(
    ("rates", "size"),
    [
        ({"x": "x^2 - 1"}, 1.0),  # its slope vanishes at the start
        ({"x": "1 - x^1.5"}, 1.0),  # it is not defined on one side of it
        ({"x": "1/x - 0.01"}, 100.0),  # nor at the start itself
        ({"x": "v", "v": "x^2 - 9 - v"}, 3.0),
    ],
)
def test_an_equilibrium_is_found_around_the_start(rates, size):
    model = system(**rates)
    found = search_equilibrium(model, model.start)
    assert np.abs(found).max() == pytest.approx(size, rel=1e-12)


def test_one_that_breaks_a_limit_is_none():
    model = system({"side": {"output": "x", "bound": 0}}, x="x^2 - 1")
    assert search_equilibrium(model, model.start) == pytest.approx([1.0])


@pytest.mark.parametrize("rates", [{"x": "x^2 + 1"}, {"x": "y", "y": "exp(x)"}])
def test_where_there_is_none_nothing_is_found(rates):
    model = system(**rates)
    assert search_equilibrium(model, model.start) is None


def test_a_fold_is_followed_from_a_start_at_the_top_of_the_parabola():
    model = sf.System(name="fold", parameters={"a": -1.0}, states={"x": "a + x^2"})
    (branch,) = sf.response(model, vary="a", span=(-1, 0.5)).branches
    assert [(item.type, round(item.value, 9)) for item in branch.special] == [("LP", 0.0)]
    assert branch.stopped.value == pytest.approx(-1)
