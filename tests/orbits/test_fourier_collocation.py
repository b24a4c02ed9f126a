"""Orbits, multipliers and a period doubling against Fourier collocation with Hill's method."""

import numpy as np
import pytest
from scipy.optimize import brentq

from helpers.fourier_collocation import FourierOrbit
from slipfold import Settings, SlidingOscillator, periodic_orbit
from slipfold.bifurcations.branches.response import trace_response

SETS = [
    ({"f": 12.5, "Nd": 0.05}, 1, 65),
    ({"f": 12.5, "Nd": 0.2}, 1, 129),
    ({"f": 9.3, "Nd": 0.6, "alpha": 0.7, "mu": 0.3, "Vd": 0.9}, 1, 65),
    ({"f": 20.0, "Nd": 0.9, "kext": 600.0, "zeta1": 0.02, "f1": 7.0}, 1, 65),
    ({"f": 13.0, "Nd": 0.5, "L": 0.008, "Ns": 1.5}, 1, 97),
    ({"f": 12.2, "Nd": 0.15}, 2, 97),
    ({"f": 12.4, "Nd": 0.3, "Vd": 0.8}, 2, 129),
    ({"f": 12.5, "Nd": 0.4, "mu": 0.45}, 2, 129),
]


def guess_from(orbit, count):
    """Trigonometric interpolation of our orbit, disturbed so that Newton has something to do."""
    _, states = orbit.sample(512)
    spectrum = np.fft.rfft(states, axis=0)[: count // 2 + 1] * (count / len(states))
    guess = np.fft.irfft(spectrum, n=count, axis=0)
    wave = np.cos(2 * np.pi * np.arange(count) / count)
    return guess + 1e-4 * wave[:, None] * orbit.model.state_scales()


@pytest.mark.parametrize(("values", "period", "count"), SETS)
def test_orbit_and_multipliers(values, period, count):
    model = SlidingOscillator(**values)
    orbit = periodic_orbit(model, period)
    other = FourierOrbit(values, period, guess_from(orbit, count))
    assert other.tail < 1e-10
    scales = model.state_scales()
    assert orbit.state / scales == pytest.approx(other.states[0] / scales, abs=1e-8)
    hill = other.multipliers()
    distance = np.abs(hill[:, None] - orbit.multipliers[None, :])
    # Eigenvalues of a matrix of some hundred rows are good to 1e-11 or so, of the largest.
    rounding = 1e-10 * max(1.0, np.abs(orbit.multipliers).max())
    known = 30 * orbit.multiplier_uncertainty + rounding  # two errors of either sign may agree
    assert np.all(distance.min(axis=0) < known)  # each of ours is one of Hill's
    assert distance.min(axis=1).max() < known.max()  # and none of Hill's is missing here


def test_location_of_the_doubling_at_12_5_hz():
    model = SlidingOscillator(f=12.5)
    (branch,) = trace_response(model, "Nd", (0.0, 0.1), settings=Settings(largest_period=1))
    (ours,) = branch.special

    def growth(Nd):
        values = {"f": 12.5, "Nd": Nd}
        guess = guess_from(periodic_orbit(SlidingOscillator(**values)), 65)
        exponents = FourierOrbit(values, 1, guess).exponents()
        odd = exponents[np.abs(np.abs(exponents.imag) - np.pi) < 1e-6]
        return odd[np.abs(odd.real).argmin()].real

    theirs = brentq(growth, 0.0430, 0.0445, xtol=1e-12)
    assert ours.value == pytest.approx(theirs, abs=1e-9)
    assert theirs == pytest.approx(0.043578911491, abs=2e-12)
