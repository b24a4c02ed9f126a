"""Branches that begin at a given orbit, and cycles found from motions."""

import pytest

import slipfold as sf
from slipfold.models.registry import model_named


def test_cycle_of_van_der_pol_is_found_from_the_motion():
    # The shared textbook values, and the period of the relaxation oscillation at mu = 20.
    cycle = sf.periodic_orbit(model_named("vanderpol-free"))
    assert cycle.duration == pytest.approx(6.663286859323, abs=1e-11)
    assert cycle.extrema.of("x")[1] == pytest.approx(2.008619860875, abs=1e-11)
    assert cycle.multipliers.real == pytest.approx([1, 8.596950640e-4], abs=1e-12)
    assert cycle.stable


@pytest.mark.parametrize("c", [2.5, 3.5, 4.0, 4.15])
def test_doubled_cycles_close_only_after_all_their_rounds(c):
    # Roessler at a = b = 0.2 doubles at c = 2.8324, 3.8373 and 4.1242.
    doublings = sum(c > value for value in (2.8324, 3.8373, 4.1242))
    cycle = sf.periodic_orbit(model_named("roessler").replace(c=c))
    assert cycle.duration == pytest.approx(2**doublings * 5.78, rel=0.02)
    assert cycle.stable


def test_an_unstable_cycle_is_found_from_a_state_on_it():
    settings = sf.Settings(largest_period=1)
    model = model_named("lure")
    near = sf.response(model, vary="a", span=(1.2, 0.62), settings=settings).branches[1].orbit(-1)
    found = sf.periodic_orbit(near.model, state=near.nodes[3])
    assert not found.stable
    assert found.duration == pytest.approx(near.duration, rel=1e-9)


def test_the_branch_through_a_cycle_meets_the_one_from_the_hopf_point():
    model = model_named("lure")
    settings = sf.Settings(largest_period=1)
    born = sf.response(model, vary="a", span=(1.2, 0.62), settings=settings)
    cycle = sf.periodic_orbit(model.replace(a=0.8))
    given = sf.response(cycle, vary="a", span=(0.8, 0.62), settings=settings)
    first, second = (
        next(point.point for point in diagram.special if point.point.type == "PD")
        for diagram in (born, given)
    )
    assert first.value == pytest.approx(second.value, abs=1e-11)
    assert first.duration == pytest.approx(second.duration, abs=1e-10)


@pytest.mark.parametrize("span", [(0.3, 0.1), (0.1, 0.3)])
def test_an_orbit_one_rounding_off_the_span_is_on_it(span):
    orbit = sf.periodic_orbit(model_named("duffing").replace(W=0.1 + 0.2))
    assert orbit.model.W > 0.3
    (branch,) = sf.response(orbit, vary="W", span=span).branches
    assert branch.parameter[0] == 0.3


def test_a_forced_orbit_of_period_two_is_followed_without_its_parent():
    model = sf.SlidingOscillator(f=12.5, Nd=0.1)
    whole = sf.response(model, vary="Nd", span=(0, 0.5))
    orbit = sf.periodic_orbit(model, period=2)
    part = sf.response(orbit, vary="Nd", span=(0.1, 0.5))
    assert part.branches[0].period == 2
    expected = [point.value for point in whole.branches[1].special if point.value > 0.1]
    assert [point.value for point in part.branches[0].special] == pytest.approx(expected, abs=1e-11)


FOLD = """
name = "fold"
parameters = { a = 0.5, F = 0.2 }
[states]
q = "a - q^2 + F*cos(t)"
[forcing]
period = "2*pi"
amplitude = "F"
"""


def test_a_state_at_a_fold_is_kept_and_beyond_it_where_it_only_nearly_closes_refused():
    model = sf.System.from_toml(FOLD)
    (fold,) = sf.response(model, "a", (0.5, 0)).branches[0].special
    assert sf.periodic_orbit(model.replace(a=fold.value), state=fold.state).state == fold.state
    beyond = model.replace(a=fold.value - 1e-8)  # it misses by 1e-8 of the period, 2 pi
    with pytest.raises(sf.InputError, match="no orbit of period 1"):
        sf.periodic_orbit(beyond, state=fold.state, tolerance=1e-6)


def test_what_does_not_fit_an_orbit_is_refused():
    cycle = sf.periodic_orbit(model_named("vanderpol-free"))
    with pytest.raises(sf.InputError, match="the span begins at mu = 2 but the orbit"):
        sf.response(cycle, vary="mu", span=(2, 3))
    with pytest.raises(sf.InputError, match="mu cannot be changed"):
        sf.response(cycle, vary="duration", span=(1, 2), mu=3)


@pytest.mark.parametrize(
    ("name", "values", "arguments", "words"),
    [
        ("lure", {"a": 2.0}, {}, "comes to rest"),
        ("vanderpol-free", {}, {"period": 2}, "counts forcing periods"),
        ("vanderpol-free", {}, {"duration": -1.0}, "duration must be > 0 s"),
        ("duffing", {}, {"duration": 1.0}, "is forced"),
        ("lure", {"a": 2.0}, {"state": [0.01, 0, 0], "duration": 6.3}, "no convergence"),
    ],
)
def test_cycles_that_cannot_be_found_are_refused_in_a_sentence(name, values, arguments, words):
    with pytest.raises(sf.InputError, match=words):
        sf.periodic_orbit(model_named(name).replace(**values), **arguments)
