"""Tori of a response, from the call and the command line to figures and files."""

import csv
import importlib
import json

import numpy as np
import pytest

import slipfold as sf
from helpers.command_line import run
from helpers.tori import of_the_sliding_oscillator, of_van_der_pol
from slipfold import InputError
from slipfold.bifurcations.tori.follow import INVARIANT
from slipfold.flow.flow import flow_of
from slipfold.lines import torus_segments

SPAN = (1.0, 1.1)


@pytest.fixture(scope="module")
def model():
    return sf.built_in_models()["vanderpol"](a=0.3, e=0.2)


@pytest.fixture(scope="module")
def diagram():
    return of_van_der_pol()


@pytest.fixture(scope="module")
def tori(diagram):
    (found,) = diagram.tori
    return found


def test_they_are_born_as_the_multipliers_turn(diagram, tori):
    (birth,) = (item.point for item in diagram.special if item.point.type == "NS")
    turns = np.angle(birth.critical_multiplier) / (2 * np.pi)
    assert (tori.parameter[0], tori.rotation[0]) == pytest.approx((birth.value, turns), abs=1e-12)
    # The circles come to that, too, as they shrink.
    away = tori.parameter[1:4] - birth.value
    assert np.polyfit(away, tori.rotation[1:4], 2)[-1] == pytest.approx(turns, abs=5e-9)
    assert tori.extrema.maximum[0] == pytest.approx(birth.orbit.extrema.maximum[0], abs=1e-12)


def test_they_are_invariant_and_attract(tori):
    assert tori.truncation.max() <= INVARIANT == 1e-8
    assert tori.stable[1:].all()
    assert tori.frequency == pytest.approx(tori.rotation * tori.parameter / (2 * np.pi), rel=1e-14)
    assert tori.stopped.kind == "span"
    # shared/reference/beyond.md.
    assert tori.parameter[-1] == 1.1
    assert tori.rotation[-1] == pytest.approx(0.071825157871, abs=1e-10)


def test_their_envelope_is_that_of_a_settled_simulation(model, tori):
    at = model.replace(w=1.1)
    settled = sf.simulate(at, 4500).states[500:]

    def sampled(states, count):
        flow, zero = flow_of(at), np.zeros(len(states))
        return flow.sample(states, zero, zero + 1, count, flow.constants_of(at))[:, :, 0]

    # The highest of 4000 periods, then closely.
    highest = sampled(settled, 64).max(axis=1).argsort()[-100:]
    values = sampled(settled[highest], 2000)
    top = values[:, 1:-1].argmax(axis=1) + 1
    left, peak, right = (values[np.arange(len(top)), top + side] for side in (-1, 0, 1))
    highest = (peak - (right - left) ** 2 / (8 * (left - 2 * peak + right))).max()
    assert tori.extrema.of("x")[1][-1] == pytest.approx(highest, abs=1e-6)


def test_they_are_saved_and_listed(diagram, tori, tmp_path):
    diagram.save(tmp_path / "tori.nc")
    copy = sf.load(tmp_path / "tori.nc")
    assert copy.to_json() == diagram.to_json()
    assert copy.summary() == diagram.summary()
    (other,) = copy.tori
    for name in ("circles", "rotation", "growth_error", "angles", "omitted"):
        assert np.array_equal(getattr(other, name), getattr(tori, name), equal_nan=True)
    assert other.extrema == tori.extrema
    assert "Tori 2 of period 1 (" in diagram.summary()
    assert len(repr(tori)) < 200
    assert len(tori.circle(0)) == 1
    assert set(diagram.to_xarray().sizes) >= {"torus", "torus_point", "angle"}
    diagram.to_csv(tmp_path / "tori.csv")
    rows = list(csv.DictReader((tmp_path / "tori.csv").read_text().splitlines()))
    own = [row for row in rows if row["branch"] == "2"]
    assert [float(row["rotation"]) for row in own] == tori.rotation.tolist()
    assert all(row["rotation"] == "" for row in rows if row["branch"] == "1")


@pytest.mark.long
def test_their_line_is_what_lies_between_them(model, tori):
    lines = torus_segments(tori, "x")
    at = np.concatenate([line.parameter for line in lines])
    value = np.concatenate([line.value for line in lines])
    steps = sf.Settings(steps=sf.Steps(largest=0.01))
    (fine,) = sf.response(model, vary="w", span=SPAN, tori=True, settings=steps).tori
    assert len(fine) > 2 * len(tori)
    _, known = fine.extrema.of("x")
    off = np.abs(np.interp(fine.parameter, at, value) - known)
    assert off.max() < 0.01 * np.ptp(known)


def test_an_interruption_keeps_what_is_done(model):
    def interrupt(progress):
        if progress.stage == "tori" and progress.values["points"] == 4:
            raise KeyboardInterrupt

    found = sf.response(model, vary="w", span=SPAN, tori=True, on_progress=interrupt)
    assert found.interrupted
    assert found.tori[0].stopped.kind == "interrupted"
    assert found.branches[0].stopped.kind == "span"


COUPLED = """
name = "coupled"
parameters = { a = -0.5, w = 0.7, c = 0, e = 0, q = 0, b = -1, W = 2 }
forcing = { period = "2*pi/W" }
[states]
u = "a*u - (w + c*R)*v + b*R*u - q*R^2*u + e*cos(W*t)*(u^2 - v^2)"
v = "(w + c*R)*u + a*v + b*R*v - q*R^2*v - 2*e*cos(W*t)*u*v"
[formulas]
R = "u^2 + v^2"
"""
"""Without e the radius of tori is sqrt(a), and their rotation number (w + a c)/W."""


def coupled(span, **values):
    """Return the only branch of tori of the model above, and its diagram."""
    model = sf.System.from_toml(COUPLED).replace(**values)
    diagram = sf.response(model, vary="a", span=span, tori=True)
    (found,) = diagram.tori
    return found, diagram


@pytest.mark.parametrize("w", [0.69, 0.69 + 1e-6])  # one steps over it, the other beside it
def test_they_go_on_past_a_strong_resonance_where_nothing_happens(w):
    tori, _ = coupled((-0.1, 0.1), w=w, c=-0.5)
    assert tori.stopped.kind == "span"
    assert tori.rotation == pytest.approx((w - 0.5 * tori.parameter) / 2, abs=1e-9)
    assert [str(item.ratio) for item in tori.locked] == ["1/3"]
    assert tori.locked[0].first < (w - 2 / 3) / 0.5 < tori.locked[0].last


def test_the_strong_resonance_that_they_do_not_pass_is_named():
    tori, diagram = coupled((-0.1, 0.5), w=0.7067, c=-0.2, e=0.03)
    assert tori.rotation[-1] == pytest.approx(1 / 3, abs=3e-3)
    assert tori.stopped.kind == "resonance"
    assert "not followed past the strong resonance 1/3" in diagram.summary()
    assert not diagram.failed


def test_a_circle_may_come_to_turn_the_other_way():
    tori, diagram = coupled((-0.1, 0.3), w=0.1, c=-0.5)
    assert tori.rotation[-1] == pytest.approx((0.1 - 0.15) / 2, abs=1e-9)
    assert tori.frequency == pytest.approx(tori.rotation / np.pi, rel=1e-12)
    low, high = np.abs(tori.frequency).min(), tori.frequency.max()
    assert f"modulated at {low:.4g} to {high:.4g} Hz" in diagram.summary()


def test_circles_that_are_left_out_are_counted_and_not_drawn_across(model, tori, monkeypatch):
    module, known = importlib.import_module("slipfold.bifurcations.tori.follow"), tori.truncation
    monkeypatch.setattr(module, "INVARIANT", float(np.median(known)))
    diagram = sf.response(model, vary="w", span=SPAN, tori=True)
    (found,) = diagram.tori
    kept = np.append(True, known[1:] <= np.median(known))
    assert found.parameter.tolist() == tori.parameter[kept].tolist()
    assert (
        np.flatnonzero(kept).tolist()
        == (np.arange(len(found)) + np.append(0, found.omitted.cumsum()[:-1])).tolist()
    )
    assert len(found) + found.omitted.sum() == len(tori) > len(found)
    drawn = [(line.parameter[0], line.parameter[-1]) for line in torus_segments(found, "x")]
    pairs = zip(found.parameter[:-1], found.parameter[1:], found.omitted[:-1], strict=True)
    for first, last, omitted in pairs:
        between = (first + last) / 2
        assert any(low < between < high for low, high in drawn) == (not omitted)
    record = diagram.to_json()["branches"][-1]
    assert record["omitted"] == found.omitted.tolist()
    assert f"invariant by more than 1e-8: {found.omitted.sum()};" in diagram.summary()


STICKING = """
name = "sticking"
parameters = { a = -0.5, W = 2, mu = 0.9, Vd = 0.1 }
forcing = { period = "2*pi/W" }
[states]
u = "a*u - 0.83*v - u*(u^2 + v^2)"
v = "0.83*u + a*v - v*(u^2 + v^2)"
y = "s"
s = "F - y + cos(W*t)"
[contacts.F]
slip = "Vd - s"
normal = "1.0"
friction = { law = "Coulomb", mu_s = "mu", mu_k = "mu" }
"""


def test_of_orbits_that_stick_only_the_births_are_reported(tmp_path):
    model = sf.System.from_toml(STICKING)
    diagram = sf.response(model, vary="a", span=(-0.05, 0.05), tori=True)
    assert [(item.point.type, item.point.stuck_fraction > 0) for item in diagram.special] == [
        ("NS", True)
    ]
    (found,) = diagram.tori
    assert (len(found), found.stopped.kind) == (1, "contacts")
    assert found.parameter[0] == pytest.approx(0, abs=1e-6)
    assert "tori of such orbits are not followed" in diagram.summary()
    assert not diagram.failed
    diagram.save(tmp_path / "sticking.nc")
    assert sf.load(tmp_path / "sticking.nc").to_json() == diagram.to_json()


def test_the_command(tmp_path):
    (tmp_path / "coupled.toml").write_text(COUPLED)
    arguments = ["--vary", "a=-0.1:0.1", "--set", "w=0.1", "--tori", "--json", "-"]
    result = run("response", str(tmp_path / "coupled.toml"), *arguments)
    assert result.exit_code == 0
    torus = json.loads(result.stdout)["branches"][-1]
    assert (torus["kind"], torus["parent"], torus["period"]) == ("torus", 1, 1)
    assert len(torus["values"]) == len(torus["rotation"]) == torus["points"]
    assert torus["stopped"]["kind"] == "span"


def test_a_torus_that_a_motion_settles_on_leads_to_both_ends_of_its_branch(tmp_path):
    # At the Neimark-Sacker point it ends where the same tori are born.
    found = of_the_sliding_oscillator()
    assert found.branches == ()
    up, down = found.tori
    assert up.started.kind == down.started.kind == "settled"
    assert up.stopped.kind == "bifurcation"
    assert up.stopped.value == pytest.approx(0.1664381671, abs=1e-8)
    assert up.rotation[-1] == pytest.approx(0.11315204, abs=1e-7)
    assert down.stopped.kind == "span"
    assert up.stable[:-3].all()
    assert "begin on an attractor, at Nd = 0.155 N" in found.summary()
    found.save(tmp_path / "x.nc")
    for measure in ("rms", "max"):  # rms is not known of tori
        out = ["--out", str(tmp_path / "x.csv"), "--measure", measure]
        assert run("plot", str(tmp_path / "x.nc"), *out).exit_code == 0
    rows = [line.split(",")[1] for line in (tmp_path / "x.csv").read_text().splitlines()[1:]]
    assert [float(value) for value in rows] == [*up.parameter, *down.parameter]
    # Over two periods a simulation leads along the circle by the rotation number.
    model, circle = sf.SlidingOscillator(f=12.5, Nd=0.155), up.circle(0)
    motion = sf.simulate(model, 2, circle[0])
    turned = np.fft.irfft(
        np.fft.rfft(circle, axis=0)
        * np.exp(2j * np.pi * up.rotation[0] * np.arange(len(circle) // 2 + 1))[:, None],
        len(circle), axis=0,
    )  # fmt: skip
    assert motion.states[-1] == pytest.approx(turned[0], abs=1e-8)


@pytest.mark.long
def test_a_step_past_where_tori_vanish_ends_at_the_orbit():
    # The last step passes the NS point, at which the parameter turns since the tori have no sign.
    model = sf.SlidingOscillator(f=12.5)
    found = sf.response(model, "Nd", (0.135, 0.2), start={"Nd": 0.155}, settled=True, tori=True)
    vanishing = found.tori[0]
    assert vanishing.stopped.kind == "bifurcation"
    assert vanishing.stopped.value == pytest.approx(0.1664381671, abs=1e-8)  # NS by continuation
    assert vanishing.parameter[-1] == vanishing.stopped.value


def test_a_motion_on_no_torus_says_what_it_does():
    chaotic = sf.SlidingOscillator(f=12.5)
    with pytest.raises(InputError, match="does not settle on what could be followed"):
        sf.response(chaotic, "Nd", (0.1, 0.2), start={"Nd": 0.11}, settled=True, tori=True)


@pytest.mark.long
def test_motion_is_locked_between_the_folds_of_orbits():
    # A branch of orbits of period 20, followed by continuation, closes on itself, with these folds.
    found = of_the_sliding_oscillator((0.144, 0.156), 0.15)
    (locked,) = found.tori[-1].locked
    assert (locked.low, locked.high) == pytest.approx((0.145216792900, 0.145283732788), abs=1e-11)
    assert "locked from 0.1452167929 to 0.1452837328" in found.summary()


@pytest.mark.long
def test_motion_is_locked_between_further_folds_and_hardly_beside_a_weak_resonance():
    up, down = of_the_sliding_oscillator((0.135, 0.17)).tori
    locked = next(item for item in down.locked if str(item.ratio) == "1/11")
    assert (locked.low, locked.high) == pytest.approx((0.135606464722, 0.136221017107), abs=1e-11)
    # Beside a weaker resonance the interval is as narrow as rounding allows to see.
    (weak,) = up.locked
    assert str(weak.ratio) == "1/9"
    assert 0 <= weak.high - weak.low < 1e-6


@pytest.mark.long
def test_a_torus_has_the_rotation_number_of_the_branch_of_tori():
    circles = of_the_sliding_oscillator((0.14, 0.156), 0.15).tori[-1]
    assert (circles.parameter[-1], circles.period) == (pytest.approx(0.14), 2)
    found = sf.lyapunov(sf.SlidingOscillator(f=12.5), 16_000, Nd=0.14)
    assert found.classification.rotation == pytest.approx(circles.rotation[-1], abs=1e-7)
    assert "its rotation number is 0.0955495 +- " in found.summary()
