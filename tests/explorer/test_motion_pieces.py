"""Motions told piece by piece, of models that nothing forces."""

import pytest

import slipfold as sf
from helpers.dry_friction import belt, sliding
from slipfold.interface.explorer.messages import SimulationRequest
from slipfold.interface.explorer.trajectories import stream_simulation


def told(model, **options):
    pieces = []
    request = SimulationRequest(kind="simulation", id=1, model=model.name, **options)
    stream_simulation(model, request, pieces.append)
    assert [piece["done"] for piece in pieces] == [False] * (len(pieces) - 1) + [True]
    return pieces


def test_a_motion_that_sticks_is_sent_as_simulate_computes_it():
    model = sliding(0.9, 0.02)
    pieces = told(model, periods=60)
    numbers = [k for piece in pieces[:-1] for k in piece["sections"]["period"]]
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
