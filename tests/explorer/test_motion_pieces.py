"""Motions told piece by piece, of models that nothing forces."""

import pytest

import slipfold as sf
from helpers.dry_friction import belt, sliding
from slipfold.explorer.messages import SimulationRequest
from slipfold.explorer.trajectories import stream_simulation
from slipfold.models import model_named


def told(model, **options):
    pieces = []
    request = SimulationRequest(kind="simulation", id=1, model=model.name, **options)
    stream_simulation(model, request, pieces.append)
    assert [piece["done"] for piece in pieces] == [False] * (len(pieces) - 1) + [True]
    return pieces


@pytest.mark.parametrize("name", ["squeal", "vanderpol-free"])
def test_a_cycle_is_told_with_its_duration(name):
    model = model_named(name, mu=1.0)
    pieces = told(model, periods=600)
    motion = sf.simulate(model)
    assert pieces[-1]["verdict"].split(";")[0] == motion.settlement.message.split(";")[0]
    assert pieces[-1]["duration"] == pytest.approx(motion.settlement.duration, rel=1e-9)
    assert pieces[-1]["settled"]
    assert "forcing" not in pieces[-1]["verdict"]
    times = [t for piece in pieces for t in piece["t"]]
    assert times == sorted(times)
    assert times[-1] > 50 * motion.settlement.duration


def test_a_start_at_rest_on_an_unstable_equilibrium_is_left():
    model = model_named("squeal", mu=1.0)
    still = {item.name: 0.0 for item in model.states}
    pieces = told(model, periods=600, start=still)
    assert pieces[-1]["settled"]
    assert "pushed off" in pieces[-1]["verdict"]


def test_a_motion_that_comes_to_rest_is_told_anew():
    model = sliding(0.9, 0.02)
    pieces = told(model, periods=60)
    begins = next(i for i, piece in enumerate(pieces) if piece.get("again"))
    numbers = [k for piece in pieces[begins + 1 : -1] for k in piece["sections"]["period"]]
    assert numbers == list(range(60))
    motion = sf.simulate(model, 60)
    last = pieces[-1]
    assert last["verdict"] == motion.settlement.message
    assert pieces[-2]["states"]["x"][-1] == pytest.approx(
        motion.at((60 - 1 / 64) * motion.forcing_period)[0], rel=1e-6
    )
    (contact,) = last["contacts"]["contacts"]
    assert contact["plate"] == pytest.approx([0.01, 0.01 * 3**0.5])
    assert {piece["state"] for piece in contact["pieces"]} == {"stick", "forth"}
    assert "tip sticks" in last["contacts"]["words"]


def test_what_always_slips_says_so():
    last = told(sliding(0.02, 0.6), periods=600)[-1]
    assert last["contacts"]["words"] == "It always slips in its last round."
    assert [piece["state"] for piece in last["contacts"]["contacts"][0]["pieces"]] == ["forth"]


def test_a_belt_carries_a_mass_as_simulate_says():
    model = belt(sf.Coulomb(mu_s=1.0, mu_k=0.5))
    last = told(model, periods=600)[-1]
    motion = sf.simulate(model)
    assert last["verdict"] == motion.settlement.message
    assert last["duration"] == motion.settlement.duration
    assert last["contacts"]["words"].startswith("In its last round contact sticks once, ")
    assert told(sf.built_in_models()["duffing"](), periods=3)[-1]["contacts"] is None


def test_on_a_floor_at_rest_a_motion_ends_in_stick():
    model = belt(sf.Coulomb(mu_s=0.1, mu_k=0.1), speed=0.0)
    last = told(model, periods=600, start={"x": 1.0})[-1]
    assert last["contacts"]["words"] == "It is stuck: all contacts stick all the time."
    (contact,) = last["contacts"]["contacts"]
    assert {piece["state"] for piece in contact["pieces"]} == {"forth", "back", "stick"}
    assert contact["pieces"][-1]["slip"][0][-1] == 0
