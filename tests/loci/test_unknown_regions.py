"""Where branch points bound regions, whose loci are not followed, no region is claimed wrongly."""

import numpy as np
import pytest

from slipfold import System, bifurcation_set, load
from slipfold.explorer.views.plane import plane_view
from slipfold.flow import flow_of

HILL = """
name = "hill"
title = "damped Hill equation with a cubic spring"
[parameters]
a = { value = 4.2, doc = "mean stiffness" }
q = { value = 0.66, doc = "amplitude of the stiffness" }
[states]
x = { rate = "v", doc = "displacement" }
v = { rate = "-0.04*v - (a - 2*q*(cos(2*t) + cos(4*t)/2))*x - x^3", doc = "velocity" }
[forcing]
period = "pi"
"""
DIVIDED = ((3.9, 6.0), (0.55, 0.75))
ALIKE = ((5.0, 5.8), (0.6, 0.7))
BLOCK = 10
BLOCKS = 60
"""Forcing periods, ten at a time: perturbations decay by exp(-0.02 pi) in each."""


@pytest.fixture(scope="module")
def found():
    model = System.from_toml(HILL)
    return {window: bifurcation_set(model, ("a", "q"), window) for window in (DIVIDED, ALIKE)}


def attractors(a, q):
    """Number of motions of period 1 on which 48 random ones settle; nothing else is met here."""
    model = System.from_toml(HILL).replace(a=a, q=q)
    flow = flow_of(model)
    constants = flow.constants(model.vector)
    states = np.random.default_rng(7).uniform([-2, -4], [2, 4], (48, 2))
    start = np.zeros(len(states))
    for _ in range(BLOCKS):
        states = flow.advance(states, start, start + BLOCK, constants)
    after = flow.advance(states, start, start + 1, constants)
    assert after == pytest.approx(states, abs=1e-6)
    return len(np.unique(np.round(states, 3) + 0.0, axis=0))


def test_a_region_that_a_pitchfork_divides_is_not_known(found):
    assert (attractors(5.5, 0.66), attractors(4.2, 0.66)) == (1, 2)
    diagram = found[DIVIDED]
    (region,) = diagram.regions.regions
    assert (region.known, region.name) == (False, "unknown")
    assert diagram.regions.at(5.5, 0.66) is None
    assert diagram.regions.at(4.2, 0.66) is None
    row = next(line for line in diagram.summary().splitlines() if "100.00%" in line)
    assert row.split()[1] == "unknown"
    assert "not true all over it" in diagram.summary()
    record = diagram.to_json()["regions"][0]
    assert (record["name"], record["known"]) == ("unknown", False)
    shown = plane_view(diagram)["regions"]
    assert (shown["names"], shown["stable"], shown["known"]) == ({"1": "unknown"}, {}, {"1": False})


def test_what_is_not_known_is_so_after_loading(found, tmp_path):
    found[DIVIDED].save(tmp_path / "set.nc")
    assert load(tmp_path / "set.nc").regions.at(5.5, 0.66) is None


def test_what_is_known_is_true(found):
    diagram = found[ALIKE]
    places = np.random.default_rng(8).uniform(*np.transpose(ALIKE), size=(4, 2))
    for a, q in places:
        assert diagram.regions.at(a, q).stable == (1,)
        assert attractors(a, q) == 1
    assert plane_view(diagram)["regions"]["known"] == {"1": True}
