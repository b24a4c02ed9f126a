"""Mode coupling of structures that slide: complex eigenvalues over the friction coefficient."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.optimize import brentq

import slipfold as sf

SIZE, STIFF, SPEED = 8, 400.0, 5.0
COUPLED = np.diag(np.full(SIZE - 1, -60.0), 1)
K = np.diag(np.linspace(150.0, 900.0, SIZE)) + COUPLED + COUPLED.T
M = np.eye(SIZE)
C = 0.02 * M + 2e-5 * K
ALONG, ACROSS = {"q1": 0.8, "q4": 0.6}, {"q2": 0.9, "q4": -0.5}


def vector(direction):
    return np.array([direction.get(f"q{place + 1}", 0.0) for place in range(SIZE)])


def sliding(reduction=None):
    load = sf.ContactLoad(ACROSS, Ns=10, kn=STIFF)
    contact = sf.FrictionContact([ALONG], sf.Coulomb(mu_k=0.2), load, Vd=SPEED)
    damping = sf.ProportionalDamping(0.02, 2e-5)
    return sf.Structure(M, damping, K, contacts=contact, reduction=reduction)


def eigenvalues(mu):
    """Of the linear structure with the stiffness that sliding adds, which is not symmetric."""
    along, across = vector(ALONG), vector(ACROSS)
    k = K + STIFF * np.outer(across + mu * along, across)
    return np.linalg.eigvals(np.block([[np.zeros((SIZE, SIZE)), M], [-k, -C]]))


def test_a_damper_is_no_rounding_of_one_a_trillion_times_as_strong():
    size, own, light = 12, 16 * np.pi, 1e-9
    mass, damping = np.eye(size + 1), np.zeros((size + 1, size + 1))
    stiffness = own**2 * (2 * np.eye(size + 1) - np.eye(size + 1, k=1) - np.eye(size + 1, k=-1))
    stiffness[size, :] = stiffness[:, size] = 0.0  # the light mass is by itself
    mass[size, size], stiffness[size, size] = light, light * own**2
    damping[0, 0], damping[size, size] = 2e3, 0.02 * own * light
    force = sf.HarmonicForce(f"q{size + 1}", F=light)
    orbit = sf.periodic_orbit(sf.Structure(mass, damping, stiffness, forcing=force, f=7.0))
    eye, none = np.eye(size + 1), np.zeros((size + 1, size + 1))
    inverse = np.linalg.inv(mass)
    system = np.block([[none, eye], [-inverse @ stiffness, -inverse @ damping]])
    exact = np.sort(np.abs(np.exp(np.linalg.eigvals(system) / 7)))
    assert np.sort(np.abs(orbit.multipliers)) == pytest.approx(exact, abs=1e-9)


@pytest.mark.parametrize(
    "reduction",
    [
        None,
        pytest.param(sf.FreeInterface(modes=8), marks=pytest.mark.long),
    ],
)
def test_squeal_begins_where_eigenvalues_say(reduction):
    span = (0.6, 0.76)
    diagram = sf.response(sliding(reduction), vary="mu_k", span=span,
                          settings=sf.Settings(largest_duration=1.0001))  # fmt: skip
    still = diagram.branches[0]
    (found,) = [point.value for point in still.special if point.type == "HB"]
    onset = brentq(lambda mu: eigenvalues(mu).real.max(), *span, xtol=1e-14)
    assert found == pytest.approx(onset, rel=1e-9)
    exact = eigenvalues(still.parameter[0])
    assert np.sort_complex(still.eigenvalues[0]) == pytest.approx(
        np.sort_complex(exact), abs=1e-8 * np.abs(exact).max()
    )
    table = diagram.to_xarray()["eigenvalues_imag"].values
    assert table[: len(still)] == pytest.approx(still.eigenvalues.imag)
    assert np.isnan(table[len(still) :]).all()  # of cycles
    shown_are_frequencies_and_dampings(diagram)


def shown_are_frequencies_and_dampings(diagram, highest=4.3):
    upper, lower = diagram.plot(kind="eigenvalues", highest=highest)
    assert lower.get_ylabel() == "damping ratio (%)"
    drawn = [[np.ravel(line.get_ydata())[-1] for line in ax.lines] for ax in (upper, lower)]
    exact = eigenvalues(diagram.span[1])
    exact = exact[(exact.imag > 0) & (exact.imag < 2 * np.pi * highest)]
    for found, expected in zip(
        drawn, (exact.imag / (2 * np.pi), -100 * exact.real / np.abs(exact)), strict=True
    ):
        numbers = [value for value in found if np.isfinite(value)]
        for value in expected:
            assert np.abs(np.array(numbers) - value).min() < 1e-7
    curves = [line.get_ydata() for line in upper.lines if len(line.get_ydata()) > 2]
    assert np.nanmin(curves) > 0.5 * exact.imag.min() / (2 * np.pi)  # what is left out is no zero
    plt.close("all")


def test_orbits_have_no_such_figure():
    diagram = sf.response(sf.SlidingOscillator(), vary="f", span=(12.0, 12.1))
    with pytest.raises(sf.InputError, match="0 of equilibria"):
        diagram.plot(kind="eigenvalues")
