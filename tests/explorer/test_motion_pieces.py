"""Messages of simulations, and of views of their ends."""

import json
from collections import OrderedDict

import numpy as np
import pytest

import slipfold as sf
from helpers.dry_friction import belt, sliding
from slipfold.interface.explorer.messages import MotionRequest, OrbitThrough, SimulationRequest
from slipfold.interface.explorer.motions import ROUNDS, send_motion
from slipfold.interface.explorer.settings import PAGE
from slipfold.interface.explorer.trajectories import (
    ShownOrbit,
    contacts_view,
    orbit_view,
    send_simulation,
)

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


def sent(send, model, request, solutions):
    pieces, kept = [], OrderedDict() if solutions is None else solutions
    send(model, request, pieces.append, lambda: None, kept)
    return pieces


def last_message(model, solutions=None, **options):
    request = SimulationRequest(kind="simulation", id=1, model=model.name, **options)
    pieces = sent(send_simulation, model, request, solutions)
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
    assert last["contacts"]["words"].startswith("In its last period contact sticks once, ")
    short = sf.simulate(model, 2)  # nothing forces it, and it has not come back
    words = f"In its last {short.duration:.3g}\u202fs contact sticks"
    assert contacts_view(short)["words"].startswith(words)
    assert last_message(sf.built_in_models()["duffing"](), periods=3)["contacts"] is None


@pytest.mark.long
def test_a_long_motion_is_sent_as_what_a_plot_has_columns_for():
    model, solutions = sf.Structure.from_toml(CHAIN), OrderedDict()
    last = last_message(model, solutions, periods=600)
    motion, sections = sf.simulate(model), last["sections"]
    assert motion.periods > PAGE.columns >= sections["count"] > PAGE.columns / 2
    assert sections["count"] * sections["duration"] == pytest.approx(motion.duration, rel=2e-3)
    # Nothing is missed between the samples that a column has.
    a = motion.sample()[1][:, 0]
    assert max(sections["max"]["a"]) == pytest.approx(a.max(), rel=1e-2)
    assert len(json.dumps(last)) < 1e6
    # A round holds thirty oscillations, each of which is seen in its views.
    shown = views(model, ("a", "va"), solutions, periods=600)
    frequency, amplitude = shown["spectrum"]["frequency"], shown["spectrum"]["amplitude"]["a"]
    high = [size for line, size in zip(frequency, amplitude, strict=True) if line > 1]
    assert max(high) == max(amplitude[1:])
    assert sum(amplitude[1:]) > a.max() - a.mean()
    speeds = shown["section"]["columns"]["va"]
    assert len(speeds) % (ROUNDS + 1) == 0
    assert speeds[: len(speeds) // 3] == pytest.approx(speeds[-len(speeds) // 3 :], abs=1e-3)


def test_an_orbit_with_stick_has_its_friction_everywhere():
    model = belt(sf.Coulomb(mu_s=1.0, mu_k=0.5))
    motion = sf.simulate(model)
    state = dict(zip(["x", "vx"], motion.states[-1].tolist(), strict=True))
    orbit = sf.periodic_orbit(motion.steady_model, 1, state)
    place = OrbitThrough(value=orbit.model.Vd, state=state)
    shown = orbit_view(ShownOrbit(orbit, place), "Vd")
    friction = np.array(shown["outputs"]["Fx"])
    # Friction holds the spring from nothing up to 1 while it sticks; it slips with 0.5.
    assert friction.max() == pytest.approx(1, abs=0.02)
    assert friction.min() == pytest.approx(0, abs=0.02)
    assert np.count_nonzero(np.abs(friction - 0.5) < 1e-6) > 50
    json.dumps(shown, allow_nan=False)
    lines = motion.spectrum(1)
    ours = shown["spectrum"]["amplitude"]["x"]
    assert ours[1] == pytest.approx(lines.amplitude[1, 0], rel=1e-6)


@pytest.mark.parametrize(("m", "word"), [(0.3, "neutral"), (0.6, "unstable")])
def test_an_equilibrium_that_nothing_damps_is_not_stable(m, word):
    states = {"x": "u", "u": "-2*x + m*y", "y": "v", "v": "-m*x - 3*y"}
    model = sf.System(parameters={"m": m}, states=states)
    orbit = sf.response(model, "m", (m, 1)).branches[0].orbit(0)
    place = OrbitThrough(value=m, state=dict.fromkeys(states, 0.0))
    assert orbit_view(ShownOrbit(orbit, place), "m")["stability"] == word


def test_on_a_floor_at_rest_a_motion_ends_in_stick():
    model = belt(sf.Coulomb(mu_s=0.1, mu_k=0.1), speed=0.0)
    last = last_message(model, periods=600, start={"x": 1.0})
    assert last["contacts"]["words"] == "It is stuck: all contacts stick all the time."
    (contact,) = last["contacts"]["contacts"]
    assert {piece["state"] for piece in contact["pieces"]} == {"forth", "back", "stick"}
    assert contact["pieces"][-1]["slip"][0][-1] == 0


def test_a_motion_that_goes_on_is_one_motion():
    model = sf.SlidingOscillator(f=12.5, Nd=0.06)
    whole = last_message(model, periods=150)["sections"]["max"]["x"]
    begun = last_message(model, periods=100)
    more = last_message(model, periods=50, start=begun["last"])["sections"]["max"]["x"]
    assert begun["sections"]["max"]["x"] + more == pytest.approx(whole, rel=1e-7)
    # Nothing forces this one, and a contact sticks: it ends where it repeats, or on request.
    model = belt(sf.Coulomb(mu_s=1.0, mu_k=0.5))
    begun = last_message(model, periods=600)
    interval = begun["sections"]["duration"] / begun["sections"]["periods"]
    more = last_message(model, periods=64, start=begun["last"], interval=interval)["sections"]
    assert more["count"] * more["duration"] == pytest.approx(64 * interval)
    assert max(more["max"]["x"]) == pytest.approx(max(begun["sections"]["max"]["x"][-64:]))


def views(model, outputs, solutions=None, **options):
    request = MotionRequest(kind="motion", id=1, model=model.name, outputs=outputs, **options)
    return sent(send_motion, model, request, solutions)[-1]


def test_views_of_a_response_are_those_of_simulate():
    model = sf.SlidingOscillator(f=12.2, Nd=0.15)
    start = {"y": 0.01}
    shown = views(model, ("x", "N"), periods=1000, start=start)
    motion = sf.simulate(model, 1000, start)
    assert motion.settlement.period == 2
    assert shown["periods"] == 4
    assert shown["duration"] == pytest.approx(4 / 12.2)
    assert (shown["forcing"], shown["frequency"]) == (12.2, 6.1)
    x = motion.output("x", -4, None, 256)[1]
    assert shown["columns"]["x"] == pytest.approx(x, rel=1e-6, abs=1e-7)
    assert shown["section"]["level"] is None
    section = motion.states[-2:, 0]  # a response of period 2
    assert shown["section"]["columns"]["x"] == pytest.approx(section, rel=1e-6, abs=1e-7)
    spectrum = motion.spectrum(64)
    for order in (0, 0.5, 1, 1.5, 2):
        line = shown["spectrum"]["frequency"].index(pytest.approx(order * 12.2))
        amplitude = shown["spectrum"]["amplitude"]["N"][line]
        assert amplitude == pytest.approx(spectrum.line("N", order), rel=1e-5)
    assert views(model, ("x",), periods=1000, start=start, window=1)["periods"] == 2


def test_a_cycle_has_its_section_where_it_passes_its_mean():
    model = sf.built_in_models()["vanderpol-free"]()
    shown = views(model, ("x", "v"), periods=600)
    section = shown["section"]
    assert abs(section["level"]) < 1e-3
    assert section["columns"]["x"] == pytest.approx([section["level"]] * 3, abs=1e-5)
    speed = np.array(section["columns"]["v"])
    assert speed.min() > 0
    assert np.ptp(speed) < 1e-4 * speed.min()
    assert shown["frequency"] == pytest.approx(1 / 6.663287, rel=1e-6)


def test_lines_of_a_motion_that_never_repeats_do_not_bury_each_other():
    # Undamped and forced: two lines that have no ratio, and nothing else.
    model = sf.System(
        name="two lines",
        parameters={"k": 2.0, "f": 1.0, "F": 1.0},
        states={"q": "v", "v": "F*cos(2*pi*f*t) - k*q"},
        forcing={"period": "1/f", "amplitude": "F"},
    )
    shown = views(model, ("q",), periods=512)
    assert shown["frequency"] is None
    frequency, amplitude = (
        np.array(item)
        for item in (shown["spectrum"]["frequency"], shown["spectrum"]["amplitude"]["q"])
    )
    own = 2**0.5 / (2 * np.pi)
    forced = 1 / abs(2 - (2 * np.pi) ** 2)
    assert amplitude[np.argmin(abs(frequency - 1))] == pytest.approx(forced, rel=1e-4)
    assert amplitude[np.argmin(abs(frequency - own))] == pytest.approx(forced, rel=0.16)
    between = (abs(frequency - own) > 0.2) & (abs(frequency - 1) > 0.05)
    assert amplitude[between].max() < 1e-5 * forced
