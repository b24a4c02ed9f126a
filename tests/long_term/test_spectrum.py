"""Spectra against reference values, closed forms and Parseval's theorem."""

import numpy as np
import pytest
from scipy.integrate import quad

import slipfold as sf
from helpers.dry_friction import belt
from helpers.toy_models import LinearOscillator
from slipfold import InputError, PeriodicOrbit, SlidingOscillator, find_spectrum
from slipfold.flow.simulate import simulate

ORDERS = (0, 0.5, 1, 1.5)
REFERENCE = {
    (0.05, "x"): [0.1176367005, 0, 0.0081188128, 0],
    (0.05, "y"): [0.0610506146, 0, 0.0799443927, 0],
    (0.15, "x"): [0.1153731745, 0.2763272675, 0.0389868653, 0.0129595018],
    (0.15, "y"): [0.0442995394, 0.0305663721, 0.2478571373, 0.0012756126],
}


@pytest.fixture(scope="module")
def runs():
    return {Nd: simulate(SlidingOscillator(f=12.2, Nd=Nd), 1000) for Nd in (0.05, 0.15)}


def orbit_of(run, segments=1):
    """The periodic orbit that a run has settled on."""
    period = run.settlement.period
    first = run.periods - period
    times = (first + period * np.arange(segments) / segments) * run.forcing_period
    nodes = run.at(times)
    return PeriodicOrbit(run.model, period, nodes, np.zeros(4, dtype=complex), 0.0)


@pytest.mark.parametrize(("Nd", "name"), REFERENCE)
def test_reference_spectra_from_rest(runs, Nd, name):
    spectrum = find_spectrum(runs[Nd])
    assert spectrum.settled
    for order, expected in zip(ORDERS, REFERENCE[Nd, name], strict=True):
        assert spectrum.line(name, order) == pytest.approx(expected, rel=1e-7, abs=1e-14)


@pytest.mark.parametrize(("Nd", "name"), REFERENCE)
@pytest.mark.parametrize("segments", [1, 3])
def test_reference_spectra_from_the_orbit(runs, Nd, name, segments):
    spectrum = find_spectrum(orbit_of(runs[Nd], segments))
    period = runs[Nd].settlement.period
    for order, expected in zip(ORDERS, REFERENCE[Nd, name], strict=True):
        if order * period == round(order * period):
            assert spectrum.line(name, order) == pytest.approx(expected, rel=1e-7)


def test_amplitude_of_a_linear_oscillator():
    model = LinearOscillator(a=3.0)
    spectrum = find_spectrum(simulate(model, 300), 8, 16)
    line = spectrum.periods
    assert spectrum.frequency[line] == pytest.approx(model.f)
    exact = model.response_amplitude()
    assert spectrum.coefficients[line, 0] == pytest.approx(exact, abs=1e-13)
    assert spectrum.coefficients[line, 1] == pytest.approx(2j * np.pi * model.f * exact, abs=1e-12)
    others = np.delete(spectrum.of("x"), line)
    assert np.max(others) < 1e-13


def test_parseval(runs):
    spectrum = find_spectrum(runs[0.15], 8, 64)
    _, samples = runs[0.15].output("y", -8, None, 64)
    amplitude = spectrum.of("y")
    power = amplitude[0] ** 2 + np.sum(amplitude[1:-1] ** 2) / 2 + amplitude[-1] ** 2
    assert power == pytest.approx(np.mean(samples**2), rel=1e-12)


def test_harmonics_converge_exponentially_with_the_samples(runs):
    exact = find_spectrum(runs[0.15], 2, 256).line("x", 0.5)
    errors = [
        abs(find_spectrum(runs[0.15], 2, count).line("x", 0.5) - exact) for count in (4, 8, 16)
    ]
    assert errors[1] < 1e-2 * errors[0]
    assert errors[2] < 1e-3 * errors[1] + 1e-14


def test_power_balance_over_a_periodic_orbit(runs):
    for run in runs.values():
        spectrum = find_spectrum(orbit_of(run), per_period=256)
        mean = {
            name: spectrum.coefficients[0, spectrum.names.index(f"power_{name}")].real
            for name in ("plate", "friction", "damping", "structure")
        }
        assert mean["damping"] > 0
        assert mean["plate"] == pytest.approx(mean["friction"] + mean["damping"], rel=1e-12)
        assert mean["structure"] == pytest.approx(mean["damping"], rel=1e-9)


def test_bad_questions_get_one_sentence(runs):
    spectrum = find_spectrum(runs[0.05], 4, 8)
    with pytest.raises(InputError, match=r"order = 0.3 is not a line .* multiples of 1/4 up to 4"):
        spectrum.line("x", 0.3)
    with pytest.raises(InputError, match="order = 5"):
        spectrum.line("x", 5)
    with pytest.raises(InputError, match="order = -1"):
        spectrum.line("x", -1)
    with pytest.raises(InputError, match="no output 'z'"):
        spectrum.of("z")
    with pytest.raises(InputError, match="per_period = 1"):
        find_spectrum(runs[0.05], 4, 1)
    with pytest.raises(InputError, match="periods = 0"):
        find_spectrum(runs[0.05], 0)


@pytest.mark.parametrize("order", [1, 2, 7])
def test_lines_of_a_motion_that_sticks(order):
    """Its rate has corners, whose lines come back among the lower ones with too few samples."""
    spectrum = sf.simulate(belt(sf.Coulomb(mu_s=1.0, mu_k=0.5))).spectrum(4)
    # It leaves x = 1 with v = 0.2 and swings about 1/2 until it is back at that speed.
    size, first, stuck = np.hypot(0.5, 0.2), np.arctan(0.4), 5.0
    slips = np.pi + 2 * first
    period = slips + stuck

    def part(x, begin, end):
        turning = 2 * np.pi * order / period
        real = quad(lambda t: x(t) * np.cos(turning * t), begin, end, epsabs=1e-13)[0]
        imaginary = quad(lambda t: x(t) * np.sin(turning * t), begin, end, epsabs=1e-13)[0]
        return real - 1j * imaginary

    swings = part(lambda t: 0.5 + size * np.cos(t - first), 0.0, slips)
    sticks = part(lambda t: 0.2 * (t - slips), slips, period)
    exact = abs(2 / period * (swings + sticks))
    assert spectrum.frequency[spectrum.periods] == pytest.approx(1 / period, rel=1e-9)
    assert spectrum.line("x", order) == pytest.approx(exact, abs=1e-9)
    rate = 2 * np.pi * order / period * exact
    assert spectrum.line("vx", order) == pytest.approx(rate, abs=2e-7)
