"""The search for the response of stiff motion: it tells how far it is, and comes to an end."""

import pytest

import slipfold as sf
from helpers.dry_friction import belt
from slipfold.bifurcations.branches.progress import SEARCHING
from slipfold.orbits import first_orbits


@pytest.fixture(scope="module")
def slider():
    # It gives way within a millionth of the period.
    return belt(sf.Jenkins(kt=1e5), 0.0, 0.1, stiffness=100.0, force=30, f=1.0)


def test_a_search_tells_of_every_period_and_may_be_stopped_there(slider):
    told = []

    def observe(progress):
        told.append(progress)
        if progress.done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sf.response(slider, vary="f", span=(1.0, 1.05), on_progress=observe)
    assert [item.done for item in told] == [0, 1, 2]
    assert {(item.stage, item.values["points"], item.values["parameter"]) for item in told} == {
        (SEARCHING, 0, 1.0)
    }


def test_a_search_that_takes_too_long_is_given_up_and_said_so(slider, monkeypatch):
    monkeypatch.setattr(first_orbits.FIRST, "stiff_steps", 1)
    with pytest.raises(sf.InputError, match=r"stiff, .* it comes near no orbit; give a start"):
        sf.response(slider, vary="f", span=(1.0, 1.05))


def test_a_motion_that_is_to_settle_tells_how_far_it_is_and_may_be_stopped_there():
    told = []

    def observe(progress):
        told.append(progress)
        raise KeyboardInterrupt

    model = sf.built_in_models()["duffing"]()
    with pytest.raises(KeyboardInterrupt):
        sf.response(model, vary="W", span=(0.5, 0.6), settled=True, on_progress=observe)
    assert [item.stage for item in told] == [SEARCHING]
