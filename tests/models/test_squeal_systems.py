"""Squeal by mode coupling: flutter boundaries in closed form, Hopf points and their cycles."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

import slipfold as sf
from helpers.by_hand.sliding import end_of
from slipfold.models.model import evaluation_of
from slipfold.models.registry import model_named

SINGLE = sf.Settings(largest_period=1)
UNDAMPED = model_named("pin-on-disc", c=0, C=0)


def eigenvalues(model, point=None):
    """At the origin, which is an equilibrium of the squeal model, or at another point."""
    at = np.zeros(len(model.states)) if point is None else point
    return np.linalg.eigvals(evaluation_of(model).jacobian(model, at))


def hopf_of(diagram):
    [point] = [point for _, point in diagram.special if point.type == "HB"]
    return point


# -- the minimal model of Hoffmann et al. ----------------------------------------------------------


@pytest.mark.parametrize("delta", [0.0, 0.3, 0.9])
def test_frequencies_of_hoffmanns_reference_case(delta):
    # s^2 = -2 +- sqrt(1 - delta) with delta = mu kc.
    model = model_named("squeal", c=0, mu=0.75 * delta)
    found = np.sort(eigenvalues(model).imag)[2:]
    expected = np.sqrt([2 - np.sqrt(1 - delta), 2 + np.sqrt(1 - delta)])
    assert found == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(("k1", "k2", "k12"), [(2.0, 2.0, 1.0), (2.4, 1.7, 0.6), (3.0, 2.0, 1.3)])
def test_flutter_boundary_with_unequal_stiffnesses(k1, k2, k12):
    boundary = (k12 + (k1 - k2) ** 2 / (4 * k12)) * 0.75
    model = model_named("squeal", c=0, k1=k1, k2=k2, k12=k12)
    for mu, grows in ((boundary - 1e-6, False), (boundary + 1e-6, True)):
        assert (eigenvalues(model.replace(mu=mu)).real.max() > 1e-5) == grows


def test_onset_of_squeal_is_subcritical_for_a_contact_that_hardens():
    diagram = sf.response(model_named("squeal"), "mu", (0.6, 0.8), settings=SINGLE)
    hopf = hopf_of(diagram)
    assert hopf.value == pytest.approx(0.75 * (1 + 2 * 0.05**2), abs=1e-10)
    # (s^2 + c s + 2)^2 = 1 - mu kc has the root s = i sqrt(2) there.
    assert hopf.duration == pytest.approx(2 * np.pi / np.sqrt(2), rel=1e-9)
    assert hopf.criticality == "subcritical"
    assert diagram.branches[1].parameter[1] < hopf.value


# -- the pin on a disc -----------------------------------------------------------------------------


def margin(p):
    """Discriminant of the squared frequencies without damping; flutter where it is negative."""
    s, c = np.sin(p["theta"]), np.cos(p["theta"])
    gain = p["mu"] * c - s
    pin, disc = (p["k"] - p["kc"] * s * gain) / p["m"], (p["K"] + p["kc"]) / p["M"]
    return (pin - disc) ** 2 - 4 * p["kc"] ** 2 * s * gain / (p["m"] * p["M"])


def rates_by_hand(time, state, p):
    u, w, vu, vw = state
    s, c = np.sin(p["theta"]), np.cos(p["theta"])
    closing = u * s - w
    force = p["N0"] + p["kc"] * closing + p["kn"] * closing**3
    mu = p["mu"] * (1 + (p["r"] - 1) * np.exp(-(p["V"] - vu * c) / p["vs"]))
    return np.array(
        [
            vu,
            vw,
            (force * (mu * c - s) - p["k"] * u - p["c"] * vu) / p["m"],
            (force - p["N0"] - p["K"] * w - p["C"] * vw) / p["M"],
        ]
    )


def growth_by_hand(model):
    step, p, point = 1e-30, dict(model.values), model_point(model)
    columns = [rates_by_hand(0, point + 1j * step * e, p).imag / step for e in np.eye(4)]
    return np.linalg.eigvals(np.transpose(columns)).real.max()


def model_point(model):
    """Equilibrium of the pin on a disc, by Newton's method on the equations written by hand."""
    state, p, step = np.zeros(4), dict(model.values), 1e-30
    for _ in range(30):
        columns = [rates_by_hand(0, state + 1j * step * e, p).imag / step for e in np.eye(4)]
        state = state - np.linalg.solve(np.transpose(columns), rates_by_hand(0, state, p))
    return state


def test_flutter_boundary_of_the_pin_in_closed_form():
    # A linear contact, so that the boundary does not depend on the point.
    model = UNDAMPED.replace(kn=0)
    boundary = brentq(lambda mu: margin({**model.values, "mu": mu}), 0.1, 0.3, xtol=1e-15)
    for mu, grows in ((boundary - 1e-7, False), (boundary + 1e-7, True)):
        there = model.replace(mu=mu)
        assert (eigenvalues(there, model_point(there)).real.max() > 0.1) == grows


@given(
    st.floats(-0.5, 0.5), st.floats(0, 1), st.floats(0.2, 5), st.floats(0.2, 5), st.floats(0.1, 10)
)
def test_only_a_pin_that_digs_in_squeals(theta, mu, pin, disc, contact):
    model = UNDAMPED.replace(theta=theta, mu=mu, kn=0, k=1e6 * pin, K=1e6 * disc, kc=1e6 * contact)
    found = eigenvalues(model, model_point(model))
    if found.real.max() > 10.0:  # well above the rounding of frequencies that are equal
        assert margin(model.values) < 0
        assert 0 < np.tan(theta) < mu
    else:
        # The discriminant is -(2 Im s^2)^2, and Im s^2 is twice growth times frequency.
        assert margin(model.values) > -1.01 * (4 * 10.0 * np.abs(found).max()) ** 2


def test_onset_of_squeal_of_the_pin():
    diagram = sf.response(model_named("pin-on-disc"), "mu", (0.1, 0.2), settings=SINGLE)
    hopf = hopf_of(diagram)
    expected = brentq(lambda mu: growth_by_hand(model_named("pin-on-disc", mu=mu)), 0.15, 0.2)
    assert hopf.value == pytest.approx(expected, abs=1e-9)
    assert hopf.criticality == "supercritical"
    # It squeals between the natural frequencies of the pin and of the disc with the contact.
    assert 700 < 1 / hopf.duration < 740
    orbit = diagram.branches[1].orbit(-1)
    p = dict(orbit.model.values)
    end = end_of(rates_by_hand, p["duration"], orbit.nodes[0], p, atol=1e-18)
    mismatch = (end - orbit.nodes[0]) / orbit.model.state_scales()
    assert mismatch == pytest.approx(np.zeros(4), abs=1e-8)
