"""Motions told piece by piece, of models that nothing forces."""

import pytest

import slipfold as sf
from slipfold.explorer.messages import SimulationRequest
from slipfold.explorer.views.simulation import stream_simulation
from slipfold.models import model_named


def told(model, **options):
    pieces = []
    request = SimulationRequest(kind="simulation", id=1, model=model.name, **options)
    stream_simulation(model, request, pieces.append)
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
