"""Spans that end or begin exactly on a bifurcation."""

import pytest

import slipfold as sf
from slipfold.models.registry import model_named

ALONE = sf.Settings(largest_period=1)
"""Period doublings are not followed."""


def system(**states):
    return sf.System(name="edge", parameters={"r": -0.5}, states=states)


PITCHFORK = system(x="r*x - x^3", y="-y + x^2")
TRANSCRITICAL = system(x="r*x - x^2", y="-y + x")
FOLD = system(x={"rate": "r + x^2", "start": -0.7}, y="-y + x")
SPANS = [(-0.5, 0.0), (0.0, -0.5), (0.5, 0.0), (0.0, 0.5)]


def arrive(diagram):
    """Whether every branch ends at an end of the span."""
    ends = [end for item in diagram.branches for end in item.ends]
    return all(end.kind in ("span", "bifurcation") for end in ends)


@pytest.mark.parametrize("span", SPANS)
def test_branch_points_of_equilibria(span):
    diagram = sf.response(PITCHFORK, vary="r", span=span)
    assert arrive(diagram)
    rest, other = diagram.branches
    assert sorted(rest.parameter[[0, -1]]) == sorted(span)
    assert [item.type for item in rest.special] == ["BP"]
    # Both halves of x^2 = r, or nothing but the point itself.
    if max(span) > 0:
        assert other.parameter[[0, -1]] == pytest.approx([0.5, 0.5], abs=1e-15)
        assert other.states[:, 0] ** 2 == pytest.approx(other.parameter, abs=1e-10)
    else:
        assert len(other) == 1
    diagram = sf.response(TRANSCRITICAL, vary="r", span=span)
    assert arrive(diagram)
    _, other = diagram.branches
    assert sorted(other.parameter[[0, -1]]) == sorted(span)
    assert other.states[:, 0] == pytest.approx(other.parameter, abs=1e-9)


@pytest.mark.parametrize("span", [(-0.5, 0.0), (0.0, -0.5)])
def test_fold_of_equilibria(span):
    diagram = sf.response(FOLD, vary="r", span=span)
    assert arrive(diagram)
    (branch,) = diagram.branches
    assert branch.parameter[[0, -1]] == pytest.approx([-0.5, -0.5], abs=1e-12)
    assert [(item.type, round(item.value, 9)) for item in branch.special] == [("LP", 0)]


@pytest.mark.parametrize("span", SPANS)
def test_hopf_point_of_equilibria(span):
    assert arrive(sf.response(model_named("stuart-landau"), vary="r", span=span))


@pytest.mark.parametrize("first", [-0.4, 0.4])
def test_pitchfork_of_cycles(first):
    # A cycle of radius one in the plane z = 0; off the plane others with z^2 = r.
    model = sf.System(
        name="cycles",
        parameters={"r": first},
        states={"x": "x*(1 - x^2 - y^2) - y", "y": "y*(1 - x^2 - y^2) + x", "z": "r*z - z^3"},
    )
    cycle = sf.periodic_orbit(model, state=[1, 0, 0], duration=6)
    diagram = sf.response(cycle, vary="r", span=(first, 0), settings=ALONE)
    assert arrive(diagram)
    flat, other = diagram.branches
    assert [item.type for item in flat.special] == ["BP"]
    assert flat.parameter[-1] == 0
    if first > 0:
        assert other.parameter[[0, -1]] == pytest.approx([0.4, 0.4], abs=1e-15)


def test_doubling_of_cycles():
    # MatCont's value; see textbook systems.
    diagram = sf.response(model_named("lure"), vary="a", span=(1.2, 0.6303020061596))
    assert arrive(diagram)


@pytest.mark.parametrize("place", [0, 1])
def test_fold_of_a_forced_orbit(place):
    model = model_named("duffing")
    folds = sf.response(model, vary="W", span=(0.5, 1.8)).branches[0].special
    first = (0.5, 1.8)[place]
    diagram = sf.response(model, vary="W", span=(first, folds[place].value))
    assert arrive(diagram)
    assert diagram.branches[0].parameter[0] == first


@pytest.mark.parametrize("first", [0.0, 0.1])
def test_doubling_of_a_forced_orbit(first):
    model = sf.SlidingOscillator(f=12.5)
    whole = sf.response(model, vary="Nd", span=(0, 0.1), settings=ALONE)
    (doubling,) = whole.branches[0].special
    assert arrive(sf.response(model, vary="Nd", span=(first, doubling.value)))
    assert arrive(sf.response(model, vary="Nd", span=(doubling.value, first)))


@pytest.mark.parametrize("height", [1e-7, 1e-5, 0.01])
@pytest.mark.parametrize("offset", [0.0, 1.0])
def test_a_fold_beside_the_start_leads_back_to_it(offset, height):
    model = sf.System(
        name="hill",
        parameters={"p": 0.0, "h": height},
        states={"x": {"rate": f"h - p - (x - {offset})^2", "start": offset + height**0.5}},
    )
    (branch,) = sf.response(model, vary="p", span=(0, 1)).branches
    assert [point.type for point in branch.special] == ["LP"]
    assert branch.special[0].value == pytest.approx(height, rel=1e-6)
    assert branch.nodes[-1, 0, 0] == pytest.approx(offset - height**0.5, abs=1e-9)
