"""Root mean squares and levels in dB of outputs."""

import math

import matplotlib.pyplot as plt
import numpy as np
import pytest

import slipfold as sf
from slipfold import InputError

FORCE, DAMPING = 0.3, 0.05


@pytest.fixture(scope="module")
def oscillator():
    forcing = sf.HarmonicForce("x", F=FORCE)
    return sf.Structure([[1.0]], [[DAMPING]], [[1.0]], names="x", forcing=forcing, f=0.15)


def amplitude(f):
    w = 2 * np.pi * f
    return FORCE / np.abs(1 - w**2 + 1j * w * DAMPING)


def test_a_linear_oscillator(oscillator):
    orbit = sf.periodic_orbit(oscillator)
    size = amplitude(0.15)
    assert orbit.rms("x") == pytest.approx(size / math.sqrt(2), rel=1e-10)
    assert orbit.level("x") == pytest.approx(20 * math.log10(size / math.sqrt(2) / 1e-12))
    assert orbit.level("x", "1 mm") == pytest.approx(orbit.level("x") - 180)
    speed = 2 * np.pi * 0.15 * size / math.sqrt(2)
    assert orbit.level("vx", 0.5) == pytest.approx(20 * math.log10(2 * speed))
    lost = DAMPING * speed**2
    assert orbit.level("power_damping") == pytest.approx(10 * math.log10(lost / 1e-12))
    assert sf.periodic_orbit(oscillator.replace(F=0.0)).level("x") == -math.inf


def test_harmonics_are_those_of_their_number(oscillator):
    orbit = sf.periodic_orbit(oscillator)
    assert orbit.harmonic("x") == pytest.approx(amplitude(0.15), rel=1e-10)
    for number in (64, 128):  # multiples of the numbers of samples of a mean
        assert orbit.harmonic("x", number) < 1e-10
    for number in (0, -1, 1.5):
        with pytest.raises(InputError, match="give a whole number from 1"):
            orbit.harmonic("x", number)


def test_along_a_branch_and_in_a_figure(oscillator):
    diagram = sf.response(oscillator, "f", (0.1, 0.2))
    branch = diagram.branches[0]
    exact = 20 * np.log10(amplitude(branch.parameter) / math.sqrt(2))
    np.testing.assert_allclose(branch.level("x", 1), exact, atol=1e-7)
    power = [branch.orbit(0).mean("power_damping"), branch.orbit(-1).mean("power_damping")]
    assert branch.mean("power_damping")[[0, -1]].tolist() == power
    ax = diagram.plot("x", measure="level re 1 um")
    assert ax.get_ylabel() == "level of x (dB re 1 um)"
    drawn = np.concatenate([line.get_xydata() for line in ax.lines if len(line.get_xdata()) > 9])
    np.testing.assert_allclose(
        drawn[:, 1], 120 + 20 * np.log10(amplitude(drawn[:, 0]) / math.sqrt(2)), atol=0.1
    )
    assert diagram.plot("vx", measure="level").get_ylabel() == "level of vx (dB re 1 nm/s)"
    assert diagram.plot("x", measure="rms").get_ylabel() == "rms x (m)"
    with pytest.raises(InputError, match=r"'loudness' is unknown; .*rms, harmonic, level"):
        diagram.plot("x", measure="loudness")
    plt.close("all")


MISTAKES = {
    "output": (("y",), "structure has no output 'y'; it has x, vx"),
    "unit": (("x", "1 N"), "reference = '1 N' has the unit 'N'; give a number, or a number with"),
    "zero": (("x", 0), "reference = 0 m; give a finite number > 0"),
}


@pytest.mark.parametrize(("arguments", "message"), MISTAKES.values(), ids=MISTAKES)
def test_mistakes(oscillator, arguments, message):
    with pytest.raises(InputError, match=message):
        sf.periodic_orbit(oscillator).level(*arguments)


def test_what_has_no_standard_reference():
    orbit = sf.periodic_orbit(sf.built_in_models()["duffing"](W=0.5))
    with pytest.raises(InputError, match="no standard has a reference for outputs without unit"):
        orbit.level("v")
    assert orbit.level("v", 1.0) == pytest.approx(20 * math.log10(orbit.rms("v")))
