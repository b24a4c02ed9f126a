"""Messages of simulations of unforced models."""

import json

import pytest

import slipfold as sf
from helpers.dry_friction import belt, sliding
from slipfold.interface.explorer.messages import SimulationRequest
from slipfold.interface.explorer.settings import PAGE
from slipfold.interface.explorer.trajectories import send_simulation

CHAIN = """
name = "chain"
[structure]
names = ["a", "b", "c"]
M = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
C = [[0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]
K = [[200, -100, 0], [-100, 200, -100], [0, -100, 200]]
""" + "".join(
    f"""
[[contacts]]
along = "{name}"
friction = {{ law = "Stribeck", mu_s = 0.6, mu_k = 0.3, vs = 0.4 }}
load = 5
Vd = "0.5 m/s"
"""
    for name in "abc"
)
"""Three masses on a belt."""


def last_message(model, **options):
    pieces = []
    request = SimulationRequest(kind="simulation", id=1, model=model.name, **options)
    send_simulation(model, request, pieces.append)
    assert [piece["done"] for piece in pieces] == [False] * (len(pieces) - 1) + [True]
    return pieces[-2] | pieces[-1]


def test_a_motion_that_sticks_is_sent_as_simulate_computes_it():
    model = sliding(0.9, 0.02)
    last = last_message(model, periods=60)
    motion = sf.simulate(model, 60)
    assert last["sections"]["count"] == 60
    assert last["sections"]["duration"] == motion.forcing_period
    x = motion.sample(per_period=64)[1][:, 0].reshape(60, 64)
    assert last["sections"]["max"]["x"] == pytest.approx(x.max(axis=1), rel=1e-6)
    assert last["sections"]["min"]["x"] == pytest.approx(x.min(axis=1), rel=1e-6, abs=1e-9)
    assert last["verdict"] == motion.settlement.message
    (contact,) = last["contacts"]["contacts"]
    assert contact["plate"] == pytest.approx([0.01, 0.01 * 3**0.5])
    assert {piece["state"] for piece in contact["pieces"]} == {"stick", "forth"}
    assert "tip sticks" in last["contacts"]["words"]


def test_a_belt_carries_a_mass_as_simulate_says():
    model = belt(sf.Coulomb(mu_s=1.0, mu_k=0.5))
    last = last_message(model, periods=600)
    motion = sf.simulate(model)
    assert last["verdict"] == motion.settlement.message
    assert last["duration"] == motion.settlement.duration
    assert last["contacts"]["words"].startswith("In its last round contact sticks once, ")
    assert last_message(sf.built_in_models()["duffing"](), periods=3)["contacts"] is None


def test_a_long_motion_is_sent_as_what_a_plot_has_columns_for():
    model = sf.Structure.from_toml(CHAIN)
    last = last_message(model, periods=600)
    motion, sections = sf.simulate(model), last["sections"]
    assert motion.periods > PAGE.columns >= sections["count"] > PAGE.columns / 2
    assert sections["count"] * sections["duration"] == pytest.approx(motion.duration, rel=2e-3)
    # Nothing is missed between the samples that a column has.
    a = motion.sample()[1][:, 0]
    assert max(sections["max"]["a"]) == pytest.approx(a.max(), rel=1e-2)
    assert len(json.dumps(last)) < 1e6


def test_on_a_floor_at_rest_a_motion_ends_in_stick():
    model = belt(sf.Coulomb(mu_s=0.1, mu_k=0.1), speed=0.0)
    last = last_message(model, periods=600, start={"x": 1.0})
    assert last["contacts"]["words"] == "It is stuck: all contacts stick all the time."
    (contact,) = last["contacts"]["contacts"]
    assert {piece["state"] for piece in contact["pieces"]} == {"forth", "back", "stick"}
    assert contact["pieces"][-1]["slip"][0][-1] == 0
