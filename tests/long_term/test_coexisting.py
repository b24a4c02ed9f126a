"""Branches that nothing leads to: isolas made on purpose, and responses of two periods."""

from functools import cache

import numpy as np
import pytest

import slipfold as sf
from helpers.dry_friction import FORCED_SLIDER
from helpers.explorer_models import RAYLEIGH
from slipfold.bifurcations.branches.orbit_between import orbits_at
from slipfold.long_term.coexisting import STAGE
from slipfold.long_term.verified import ATTRACTOR

# Besides x = 0 the rates vanish on the circle p^2 + (x - 2)^2 = 1/4, whose outer half attracts.
ISOLA = """
name = "isola"
parameters = { p = 0.0 }
[states]
x = "-x*(p^2 + (x - 2)^2 - 1/4)"
"""

# The same about 2 cos(W t), so that everything is a response of period 1.
FORCED_ISOLA = """
name = "forced isola"
parameters = { p = 0.0, W = 1.0 }
forcing = { period = "2*pi/W" }
[states]
x = "-W*sin(W*t) - (x - cos(W*t))*(p^2 + (x - cos(W*t) - 2)^2 - 1/4)"
"""


def system(text):
    return sf.System.from_toml(text)


@cache
def searched_for(text):
    """The response of one of the models above with a search, which several tests look at."""
    return sf.response(system(text), vary="p", span=(-1, 1), search=True)


@pytest.mark.parametrize("text", [pytest.param(ISOLA, marks=pytest.mark.long), FORCED_ISOLA])
def test_an_isola_is_found_and_followed_round(text):
    diagram = sf.response(system(text), vary="p", span=(-1, 1))
    assert len(diagram.branches) == 1
    searched = searched_for(text)
    known, isola = searched.branches
    assert np.array_equal(known.parameter, diagram.branches[0].parameter)
    assert searched.searched.found == (isola.id,) == (2,)
    folds = [point.value for point in isola.special if point.type == "LP"]
    assert sorted(folds) == pytest.approx([-0.5, 0.5], abs=1e-10)
    shift = 1 if system(text).forced else 0
    radii = np.hypot(isola.parameter, isola.states[:, 0] - shift - 2)
    assert radii == pytest.approx(0.5, abs=1e-9)
    assert "1 more branch (2)" in searched.summary()


def test_a_box_that_holds_no_start_of_its_basin_finds_nothing():
    here = sf.response(system(FORCED_ISOLA), vary="p", span=(-1, 1), search={"x": (-1, 1)})
    there = sf.response(system(FORCED_ISOLA), vary="p", span=(-1, 1), search={"x": (3, 4)})
    assert (len(here.branches), len(there.branches)) == (1, 2)
    assert (there.searched.low, there.searched.high) == ((3,), (4,))


def test_nothing_is_found_twice_where_everything_is_connected():
    duffing = sf.built_in_models()["duffing"]
    diagram = sf.response(duffing(), vary="W", span=(0.9, 1.5), search=True)
    assert len(diagram.branches) == 1
    assert diagram.searched.found == ()
    slow = sf.response(duffing(d=1e-3, F=1e-4), vary="W", span=(1.6, 1.7), search=True)
    assert "128 of 128 starts had not settled after 256 periods" in slow.summary()
    assert "no more branches" in diagram.summary()


def test_no_orbit_run_through_twice_is_taken_for_another():
    diagram = sf.response(sf.SlidingOscillator(f=12.2), "Nd", (0, 0.3), search=True)
    assert [branch.period for branch in diagram.branches] == [1, 2]
    assert diagram.searched.found == ()


def test_the_other_wells_are_found_in_a_box():
    text = """
    name = "pitchfork beside its point"
    parameters = { a = 1.0 }
    [states]
    x = "a*x - x^3"
    """
    diagram = sf.response(system(text), vary="a", span=(0.5, 2.0), search=True)
    ends = sorted(branch.states[-1, 0] ** 2 for branch in diagram.branches)
    assert ends[0] == 0
    assert ends[1:] == pytest.approx([branch.parameter[-1] for branch in diagram.branches[1:]])
    assert len(diagram.branches) == 3


@pytest.mark.parametrize("text", [ISOLA, FORCED_ISOLA], ids=["at rest", "forced"])
def test_an_interrupted_search_keeps_the_branches_and_follows_no_more(text):
    def stop(progress):
        # The isola is found at the second of four places.
        if progress.stage == STAGE and progress.done > ATTRACTOR.search_starts + 1:
            raise KeyboardInterrupt

    found = sf.response(system(text), vary="p", span=(-1, 1), search=True, on_progress=stop)
    whole = searched_for(text)
    assert found.searched.interrupted
    assert not whole.searched.interrupted
    assert len(found.branches) < len(whole.branches)
    for branch, other in zip(found.branches, whole.branches, strict=False):
        assert np.array_equal(branch.nodes, other.nodes)


@pytest.mark.long
def test_isolas_of_cycles_are_found_beside_states_that_die_out():
    # At u = -1 the radius decays to less than 1e-160, at u = 1 there is the isola.
    model = sf.System(
        {
            "name": "isola at one of two levels",
            "parameters": {"p": -1},
            "formulas": {"g": "p^2 + (x^2 + y^2 - 4)^2/16 - 1/4 + (u - 1)^2"},
            "states": {
                "x": {"rate": "-x*g - y", "start": 2.2},
                "y": "-y*g + x",
                "u": {"rate": "u - u^3", "start": 1},
            },
        }
    )
    diagram = sf.response(model, vary="p", span=(-1, 1), search=True)
    (isola,) = (branch for branch in diagram.branches if branch.kind == "periodic")
    assert [item.type for item in isola.special] == ["LP", "LP"]
    assert isola.stopped.kind == "closed"


# Rosenzweig and MacArthur's food chain: prey, predator, and a predator of that.
FOOD_CHAIN = """
name = "food chain"
parameters = { K = 0.5 }
[states]
x = { rate = "x*(1 - x/K) - 5*x*y/(1 + 3*x)", start = 0.4 }
y = { rate = "5*x*y/(1 + 3*x) - 0.4*y - 0.1*y*z/(1 + 2*y)", start = 0.1 }
z = { rate = "0.1*y*z/(1 + 2*y) - 0.01*z", start = 5 }
"""


def test_an_orbit_far_from_the_start_is_found_at_the_value_asked_for():
    start = {"x": -0.2, "y": 0.125, "z": -35}
    diagram = sf.response(system(FOOD_CHAIN), "K", (0.3, 1), start=start)
    branch = diagram.branches[0]
    for value in (0.5625, 0.7375, 0.9125):
        (orbit,) = orbits_at(branch, value)
        x = min(np.roots([-3 / value, 3 - 1 / value, 1 - 5 / 8]))  # of (1 - x/K)(1 + 3 x) = 5/8
        assert abs(orbit.state[0] - x) < 1e-9


@pytest.mark.long
def test_a_doubled_cycle_found_again_is_on_the_branch_that_is_known():
    model = system(FOOD_CHAIN)
    start = {"K": 0.8, "x": 0.6, "y": 0.13, "z": 8.7}
    settings = sf.Settings(largest_period=2)
    diagram = sf.response(
        model, "K", (0.8, 0.93), start=start, settled=True, search=True, settings=settings
    )
    cycles = [branch for branch in diagram.branches if branch.kind == "periodic"]
    with_predator = [branch for branch in cycles if branch.nodes[0, 0, 2] > 1]
    assert sorted(branch.period for branch in with_predator) == [1, 2]


def test_an_isola_is_found_where_nothing_exists_at_the_first_value():
    # Equilibria on the circle p^2 + (x - 2)^2 = 1/4 alone: folds at p = +-1/2.
    isola = system("""
name = "circle"
parameters = { p = 0.0 }
[states]
x = { rate = "0.25 - p^2 - (x - 2)^2", start = 2.2 }
y = "x - y"
""")
    diagram = sf.response(isola, vary="p", span=(-1, 1), search=True)
    (branch,) = diagram.branches
    assert branch.stopped.kind == "closed"
    assert sorted(point.value for point in branch.special) == pytest.approx([-0.5, 0.5])
    nothing = system('name = "nothing"\nparameters = { p = 1.0 }\n[states]\nx = "1 + p^2 + x^2"\n')
    with pytest.raises(sf.InputError, match="no equilibrium of nothing was found"):
        sf.response(nothing, vary="p", span=(-1, 1), search=True)


def test_further_starts_add_the_branches_of_what_motions_settle_to():
    model, span = sf.System.from_toml(FORCED_SLIDER), (2, 0.001)
    slips = sf.response(model, "Vd", span).branches
    assert len(slips) == 1
    assert slips[0].parameter.min() > 0.8
    diagram = sf.response(model, "Vd", span, also=[{"Vd": 0.3}, {"Vd": 0.25}, {"Vd": 1}])
    known, sticks = diagram.branches
    assert np.array_equal(known.parameter, slips[0].parameter)
    assert (sticks.id, sticks.parameter.min()) == (2, 0.001)
    # What follows it from the other end of the span finds the same points.
    again = sf.response(model, "Vd", span[::-1]).branches[0]
    found = {point.type: point.value for point in again.special}
    assert {point.type: point.value for point in sticks.special} == pytest.approx(found, abs=1e-9)


def test_an_orbit_is_a_further_start():
    model = system(FORCED_ISOLA)
    orbit = sf.periodic_orbit(model, state={"x": 3.4})
    diagram = sf.response(model, vary="p", span=(-1, 1), also=[orbit])
    named = sf.response(model, vary="p", span=(-1, 1), also=[{"p": 0, "x": 3.4, "period": 1}])
    assert np.array_equal(named.branches[1].states, diagram.branches[1].states)
    assert len(diagram.branches) == 2
    assert sorted(point.value for point in diagram.branches[1].special) == pytest.approx(
        [-0.5, 0.5]
    )
    other = sf.periodic_orbit(model.replace(W=2), state={"x": 3.4})
    diagram = sf.response(model, vary="p", span=(-1, 1), also=[other, {"p": 3}, {"period": 0}])
    reasons = diagram.unfollowed
    assert [len(diagram.branches), len(reasons)] == [1, 3]
    assert "has other parameters than the response" in reasons[0]
    assert "outside the span" in reasons[1]
    assert "period = 0.0 is not a whole number" in reasons[2]
    assert reasons[1] in diagram.summary()


def test_gaps_are_filled_with_the_cycle_that_no_hopf_point_leads_to():
    model = sf.System.from_toml(RAYLEIGH)
    alone = sf.response(model, vary="omega", span=(0.5, 2))
    assert [branch.kind for branch in alone.branches] == ["equilibrium"]
    assert not alone.branches[0].stable.any()
    diagram = sf.response(model, vary="omega", span=(0.5, 2), gaps=True)
    (_, cycle) = diagram.branches
    assert cycle.stable.all()
    assert (cycle.parameter.min(), cycle.parameter.max()) == (0.5, 2)
    # The rate of its displacement is van der Pol's motion over omega t, with mu = eps/omega.
    free = sf.built_in_models()["vanderpol-free"]()
    period = sf.periodic_orbit(free.replace(mu=0.25)).duration
    assert cycle.durations[-1] == pytest.approx(period / 2, rel=1e-8)
    assert sf.response(model, "omega", (0.5, 2), gaps=True, eps=-0.5).branches[0].stable.all()


def test_a_gap_that_is_left_since_its_motion_takes_long_is_said():
    def impatient(progress):
        if progress.stage == "gaps":
            raise KeyboardInterrupt

    model = sf.System.from_toml(RAYLEIGH)
    diagram = sf.response(model, "omega", (0.5, 2), gaps=True, on_progress=impatient)
    assert [branch.kind for branch in diagram.branches] == ["equilibrium"]
    assert diagram.unfollowed == ("interrupted before a motion had settled",)


def test_a_gap_beyond_a_limit_is_left_alone(monkeypatch):
    monkeypatch.setattr("slipfold.computations.starts.attractor_from", None)
    diagram = sf.response(sf.SlidingOscillator(), "Nd", (0, 0.98), gaps=True)
    assert diagram.branches[0].stopped.kind == "limit"
