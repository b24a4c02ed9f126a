"""Nonlinear modes: frequency and damping ratio of free vibration over its amplitude."""

import numpy as np
import pytest
from scipy.special import ellipk

import slipfold as sf
from slipfold.models.nonlinear_mode import NonlinearMode
from slipfold.models.registry import model_named


def mode_of(diagram, output):
    """Amplitude, angular frequency and damping ratio along the backbone."""
    branch = diagram.branches[-1]
    assert branch.kind == "periodic"
    frequency = 2 * np.pi / branch.durations
    return branch.extrema_of(output).of(output)[1], frequency, branch.parameter / (2 * frequency)


@pytest.mark.parametrize("damping", [0.0, 0.05])
def test_cubic_spring_has_elliptic_frequencies(damping):
    # What damps in proportion to the velocity is balanced exactly, at all amplitudes.
    diagram = sf.backbone(model_named("duffing", d=damping), "q", 5)
    amplitude, frequency, ratio = mode_of(diagram, "q")
    stiff = 1 + 0.1 * amplitude**2
    exact = np.pi / 2 * np.sqrt(stiff) / ellipk(0.05 * amplitude**2 / stiff)
    assert frequency == pytest.approx(exact, rel=1e-11)
    assert 2 * ratio * frequency == pytest.approx(damping, abs=1e-12)
    assert amplitude[-1] == pytest.approx(5, rel=1e-12)
    assert diagram.branches[-1].stopped.kind == "event"
    assert diagram.checked.agree


def test_quadratic_damping_by_its_energy():
    # The negative damping puts in what the rest takes out: xi <v^2> = c <|v|^3>.
    states = {"x": "v", "v": "-x - c*v*sqrt(v^2 + 1e-12)"}
    model = sf.System(name="drag", parameters={"c": 0.02}, states=states)
    diagram = sf.backbone(model, "x", 2)
    amplitude, frequency, ratio = mode_of(diagram, "x")
    # To first order 4/(3 pi) c a w; the second order is that of the square of the damping.
    assert ratio[3:] == pytest.approx(4 / (3 * np.pi) * 0.02 * amplitude[3:], rel=2e-3)
    assert frequency == pytest.approx(1, rel=1e-4)


def test_elastic_friction_dissipates_and_softens_as_in_closed_form():
    law = sf.Jenkins(mu_k=1, kt=0.04, e=1e-3, exponent=32)
    model = sf.Structure(
        [[1.0]],
        [[0.01]],
        [[1.0]],
        names="x",
        contacts=sf.FrictionContact("x", law, load=0.01, Vd=0),
        forcing=sf.HarmonicForce("x", F=0.1),
    )
    diagram = sf.backbone(model, "x", 1.5)
    amplitude, frequency, ratio = mode_of(diagram, "x")
    for index in (-1, -2):
        a = float(amplitude[index])
        assert frequency[index] ** 2 == pytest.approx(1 + law.stiffness(a, normal=0.01), rel=1e-3)
        # Of a nearly harmonic motion the loss factor, twice the ratio, is W/(2 pi a^2 w^2 / 2).
        dissipated = law.energy(a, normal=0.01)
        exact = dissipated / (2 * np.pi * (a * frequency[index]) ** 2)
        friction = ratio[index] - 0.01 / (2 * frequency[index])
        assert friction == pytest.approx(exact, rel=3e-3)


def test_second_mode_of_two_masses():
    model = sf.System(
        name="two masses",
        parameters={"W": 1.0, "F": 0.1},
        states={
            "x": "u",
            "u": "F*cos(W*t) - 0.02*u - 2*x + y - 0.3*x^3",
            "y": "w",
            "w": "-0.02*w - 2*y + x - 0.3*y^3",
        },
        forcing={"period": "2*pi/W", "amplitude": "F"},
    )
    # Both masses in opposite phase, x = -y: a Duffing oscillator with the stiffness 3.
    amplitude, frequency, ratio = mode_of(sf.backbone(model, "x", 1, mode=2), "x")
    stiff = 3 + 0.3 * amplitude**2
    exact = np.pi / 2 * np.sqrt(stiff) / ellipk(0.15 * amplitude**2 / stiff)
    assert frequency == pytest.approx(exact, rel=1e-10)
    assert 2 * ratio * frequency == pytest.approx(0.02, abs=1e-11)


def test_a_backbone_is_saved_and_drawn(tmp_path):
    diagram = sf.backbone(model_named("duffing"), "q", 2)
    diagram.save(tmp_path / "mode.nc")
    loaded = sf.load(tmp_path / "mode.nc")
    assert loaded.model == diagram.model
    assert loaded.summary() == diagram.summary()
    heads = diagram.summary().splitlines()[2].split()
    assert heads[6:] == ["max", "q", "min", "q", "frequency", "damping_ratio", "stable"]
    frequency, ratio = diagram.plot()
    assert frequency.get_xlabel() == "frequency (Hz)"
    assert max(ratio.get_lines()[0].get_ydata()) == pytest.approx(2)
    last = diagram.to_dataframe().iloc[-1]
    assert last["max frequency"] == pytest.approx(1 / diagram.branches[-1].durations[-1])
    assert last["max damping_ratio"] == pytest.approx(0.05 / (4 * np.pi * last["max frequency"]))


@pytest.mark.parametrize(
    ("model", "given", "message"),
    [
        (model_named("duffing"), {"mode": 2}, "mode = 2, but modes-of-duffing has 1 that vibrate"),
        (model_named("duffing"), {"up_to": 0}, "up_to = 0 is no amplitude; give a finite number"),
        (model_named("duffing"), {"up_to": "1 s"}, "up_to = '1 s' has the unit 's'"),
        (model_named("duffing"), {"output": "z"}, "has no output 'z'"),
        (model_named("lorenz"), {"output": "x"}, "no state whose rate is another state"),
    ],
)
def test_what_has_no_backbone_is_refused(model, given, message):
    with pytest.raises(sf.InputError, match=message):
        sf.backbone(**{"model": model, "output": "q", "up_to": 1, **given})


def test_a_velocity_that_two_displacements_share_is_damped_once():
    states = {"x": "v", "w": "v", "v": "-x - 0.1*x^3 - 0.05*v"}
    mode = NonlinearMode(sf.System(name="two", states=states), xi=0.07)
    assert mode.jacobian([0, 0, 0])[2, 2] == pytest.approx(0.07 - 0.05)
