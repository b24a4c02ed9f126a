"""A curve along which a parameter turns where nothing was located says so, of whatever it is."""

from itertools import pairwise

import numpy as np
import pytest

import slipfold as sf
from slipfold.bifurcations.branches.bifurcations import Bifurcations
from slipfold.bifurcations.branches.closed_branches import Returns
from slipfold.bifurcations.loci.special_points import SpecialPoints
from slipfold.continuation.traced_curve import MonitorResult

# Radius r of the cycles, or state x: p^2 + (r^2 - 4)^2/16 = 1/4, and p^2 + x^2 = 1/4.
CYCLES = {
    "name": "cycles",
    "parameters": {"p": 0},
    "formulas": {"g": "p^2 + (x^2 + y^2 - 4)^2/16 - 1/4"},
    "states": {"x": {"rate": "-x*g - y", "start": 2.2}, "y": "-y*g + x"},
}
EQUILIBRIA = {
    "name": "equilibria",
    "parameters": {"p": 0},
    "states": {"x": {"rate": "1/4 - x^2 - p^2", "start": 0.5}},
}
# Folds at W = 1.269601955546 and 1.115700251771 (see tests of textbook systems).
FORCED = sf.built_in_models()["duffing"]()


def reversals(values):
    """Number of extrema of values in a row."""
    steps = [step for step in np.diff(values) if abs(step) > 1e-9]
    return sum(first * second < 0 for first, second in pairwise(steps))


def followed(kind):
    if kind == "forced orbits":
        (branch, *_) = sf.response(FORCED, vary="W", span=(0.9, 1.6)).branches
        return branch
    model = sf.System({"cycles": CYCLES, "equilibria": EQUILIBRIA}[kind])
    given = {"settled": True} if kind == "cycles" else {}
    return sf.response(model, vary="p", span=(-1, 1), start={"p": 0.3}, **given).branches[0]


@pytest.mark.parametrize("kind", ["forced orbits", "cycles", "equilibria"])
def test_each_turn_of_a_branch_is_a_fold(kind, monkeypatch):
    branch = followed(kind)
    assert [item.type for item in branch.special] == ["LP", "LP"]
    assert reversals(branch.parameter) == 2
    assert not branch.failed
    monkeypatch.setattr(Bifurcations, "__call__", lambda self, interval: MonitorResult())
    branch = followed(kind)
    assert branch.special == ()
    assert branch.stopped.kind == "contradiction"
    assert branch.failed
    assert "the direction of a parameter changes and nothing was located" in branch.stopped.reason


def test_a_loss_of_stability_that_nothing_explains_is_a_contradiction(monkeypatch):
    model = sf.System(parameters={"r": -1}, states={"x": "r*x - x^3", "y": "2*r*y - y^3"})
    (found, *_) = sf.response(model, "r", (-1, 0.9)).branches
    assert (len(found.special), found.stopped.kind) == (1, "span")
    monkeypatch.setattr(Bifurcations, "hidden", lambda self, found, *_: found)
    (branch,) = sf.response(model, "r", (-1, 0.9)).branches
    assert branch.stopped.kind == "contradiction"
    assert "the number of unstable multipliers changes by 2 and nothing" in branch.stopped.reason


@pytest.mark.parametrize("kind", ["cycles", "equilibria"])
def test_a_branch_that_repeats_itself_ends(kind, monkeypatch):
    monkeypatch.setattr(Returns, "__call__", lambda self, interval: MonitorResult())
    branch = followed(kind)
    assert [item.type for item in branch.special] == ["LP"] * 6  # three in each direction
    assert branch.stopped.kind == "contradiction"
    assert "on the branch repeats what it passed before" in branch.stopped.reason


def test_each_turn_of_a_locus_is_an_extremum(monkeypatch):
    # Mathieu's tongue: of period doublings h has its least value near w = 2, at h = 4 z.
    model = sf.built_in_models()["mathieu"]().replace(w=1.95)
    settings = sf.Settings(largest_period=1)
    (branch,) = sf.response(model, vary="h", span=(0.02, 0.25), settings=settings).branches
    window = {"w": (1.9, 2.1), "h": (0.0, 0.3)}
    (locus,) = sf.locus(branch.special[0], ("w", "h"), window, switch=False).loci
    assert [item.type for item in locus.special if item.type in ("MIN", "MAX")] == ["MIN"]
    assert (reversals(locus.values[:, 0]), reversals(locus.values[:, 1])) == (0, 1)
    monkeypatch.setattr(SpecialPoints, "__call__", lambda self, interval: MonitorResult())
    diagram = sf.locus(branch.special[0], ("w", "h"), window, switch=False)
    assert "contradiction" in (diagram.loci[0].started.kind, diagram.loci[0].stopped.kind)
    assert diagram.failed
