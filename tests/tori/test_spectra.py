"""Lines of tori, against those of long motions."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import slipfold as sf
from helpers.tori import of_van_der_pol
from slipfold.flow.flow import flow_of

PERIODS = 2000


@pytest.fixture(scope="module")
def diagram():
    return of_van_der_pol()


@pytest.fixture(scope="module")
def tori(diagram):
    return diagram.tori[0]


@pytest.fixture(scope="module")
def spectrum(tori):
    return tori.spectrum(-1)


def weighted_line(values, times, frequency):
    """Return the amplitude of a line of a long motion, windowed so that others leak by nothing."""
    share = (np.arange(len(times)) + 0.5) / len(times)
    weights = np.exp(-1 / (share * (1 - share)))
    return 2 * (weights / weights.sum()) @ (values * np.exp(-2j * np.pi * frequency * times))


def test_they_are_those_of_a_settled_simulation(tori, spectrum):
    model = tori.model_at(-1)
    states = sf.simulate(model, 500 + PERIODS).states[500:-1]
    flow, zero = flow_of(model), np.zeros(PERIODS)
    values = flow.sample(states, zero, zero + 1, 64, flow.constants_of(model))[:, :, 0].ravel()
    times = np.arange(len(values)) / (64 * spectrum.frequencies[0])
    for line in spectrum.of("x").argsort()[::-1][:12]:
        found = weighted_line(values, times, spectrum.frequency[line])
        assert spectrum.of("x")[line] == pytest.approx(abs(found), abs=1e-8)


def test_together_they_are_the_motion_from_the_first_state_of_the_circle(tori, spectrum):
    motion = sf.simulate(tori.model_at(-1), 7, tori.circle(-1)[0]).states
    times = np.arange(8) / spectrum.frequencies[0]
    turns = np.exp(2j * np.pi * times[:, None] * spectrum.frequency)
    assert (turns @ spectrum.coefficients).real == pytest.approx(motion, abs=1e-7)


def test_those_of_a_known_torus_are_exact():
    # u + i v turns at w with the radius sqrt(a): one line, at f2, and none of the forcing.
    text = """
    name = "even"
    parameters = { a = -0.1, w = 0.83, W = 2 }
    forcing = { period = "2*pi/W" }
    [states]
    u = "a*u - w*v - u*(u^2 + v^2)"
    v = "w*u + a*v - v*(u^2 + v^2)"
    y = "-y + cos(W*t)"
    """
    model = sf.System.from_toml(text)
    (tori,) = sf.response(model, vary="a", span=(-0.1, 0.1), tori=True).tori
    spectrum = tori.spectrum(-1)
    assert spectrum.frequencies == pytest.approx((1 / np.pi, 0.83 / (2 * np.pi)), abs=1e-10)
    assert spectrum.line("u", 0, 1) == pytest.approx(np.sqrt(0.1), abs=1e-9)
    assert spectrum.line("y", -1, 0) == pytest.approx(1 / np.sqrt(5), abs=1e-9)
    rest = (np.abs(spectrum.orders) != (0, 1)).any(axis=1)
    assert spectrum.of("u")[rest].max() < 1e-9


def test_where_tori_are_born_they_are_those_of_the_orbit(diagram, tori):
    (birth,) = (item.point for item in diagram.special if item.point.type == "NS")
    known, found = sf.find_spectrum(birth.orbit), tori.spectrum(0)
    assert not found.orders[:, 1].any()
    for order in (1, 3, 5):
        assert found.line("x", order, 0) == pytest.approx(known.line("x", order), abs=1e-9)


def test_they_are_shown(spectrum):
    assert repr(spectrum).startswith("<Spectrum of a torus of vanderpol: 2 outputs, ")
    assert len(repr(spectrum)) < 120
    assert "<th>k</th><th>l</th>" in spectrum._repr_html_()
    with pytest.raises(sf.InputError, match="k = 99, l = 0 is not a line"):
        spectrum.line("x", 99, 0)
    with pytest.raises(sf.InputError, match="no output 'q'; there are x, v"):
        spectrum.of("q")


def test_they_are_drawn(diagram, tori, spectrum):
    row = len(tori) // 2
    one = diagram.plot("v", kind="spectrum", at=tori.parameter[row] + 1e-9)
    assert one.get_title() == f"tori {tori.id}, w = {tori.parameter[row]:.6g} rad/s"
    two = spectrum.plot("v")
    assert {"$f_1$", "$f_1-f_2$", "$f_1-2f_2$"} < {item.get_text() for item in two.texts}
    dots = np.concatenate([line.get_ydata() for line in two.lines if line.get_marker() == "o"])
    assert dots.max() == spectrum.of("v").max()
    for ax in (one, two):
        assert (ax.get_xlabel(), ax.get_ylabel()) == ("frequency (Hz)", r"amplitude of $\dot x$")
        plt.close(ax.figure)
    with pytest.raises(sf.InputError, match="has no measure"):
        diagram.plot(kind="spectrum", at=1.1, measure="max")
    with pytest.raises(sf.InputError, match="has no at; it goes with kind = 'spectrum'"):
        diagram.plot(at=1.1)
