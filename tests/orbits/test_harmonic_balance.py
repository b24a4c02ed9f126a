"""Orbits by harmonic balance beside those by shooting and collocation, and beside closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import mathieu_a, mathieu_b

import slipfold as sf
from helpers.toy_models import chain
from slipfold.models.registry import model_named
from slipfold.orbits import harmonic_balance
from slipfold.orbits.periodic_orbit import PeriodicOrbit


def creeping(rise):
    return sf.Regularized(sf.Coulomb(mu_k=0.3), e=rise)


@pytest.mark.parametrize(
    ("model", "period"),
    [
        (model_named("sliding", f=12.5, Nd=0.05), 1),
        (model_named("sliding", f=12.5, Nd=0.05), 2),
        (model_named("vanderpol"), 1),
        (model_named("vanderpol-free", mu=1), 1),
        (model_named("lure", a=0.7), 1),
        (model_named("roessler", a=0.1, c=4), 1),
        (chain(10, creeping(0.03)), 1),
        (chain(6, creeping(0.3), damping=0.1), 1),  # most multipliers are nearly zero
        (chain(3, sf.Jenkins()), 1),
        (chain(3, sf.LuGre(), speed=1.0), 1),
    ],
    ids=lambda item: str(getattr(item, "name", item)),
)
def test_orbits_agree(model, period):
    orbit = sf.periodic_orbit(model, period)
    found = orbit.harmonic_balance()
    assert found.passed, found
    assert found.states < 1e-12
    assert found.duration < 1e-12
    assert found.multipliers < 1e-10
    count = 8 * len(orbit.nodes)
    sampled = found.sample(count) - orbit.sample(count)[1]
    assert np.abs(sampled / model.state_scales()).max() < 1e-8


@pytest.mark.parametrize(
    ("name", "vary", "span"),
    [
        ("duffing", "W", (0.9, 1.4)),
        ("sliding", "Nd", (0.0, 0.1)),
        ("freire", "n", (-0.56, -0.62)),
    ],
)
def test_bifurcations_agree(name, vary, span):
    values = {"f": 12.5} if name == "sliding" else {}
    settings = sf.Settings(largest_period=2)
    diagram = sf.response(model_named(name, **values), vary, span, settings=settings)
    points = [one for branch in diagram.branches for one in branch.special]
    moving = [one for one in points if np.ptp(one.orbit.nodes, axis=0).max() > 0]
    assert len(moving) > 1
    for point in moving:
        found = point.orbit.harmonic_balance()
        assert found.passed, (point.type, found)
        assert np.abs(found.floquet - point.critical_multiplier).min() < 1e-7, point.type


def test_a_linear_orbit_is_one_harmonic():
    model = sf.Structure([[2.0]], [[0.3]], [[50.0]], forcing=sf.HarmonicForce("q1", F=4.0), f=0.7)
    found = sf.periodic_orbit(model).harmonic_balance()
    omega = 2 * np.pi * 0.7
    amplitude = 4.0 / (50.0 - 2.0 * omega**2 + 0.3j * omega)
    assert found.harmonics[1, 0] == pytest.approx(amplitude / 2, rel=1e-12)
    assert np.abs(found.harmonics[[0, *range(2, 5)]]).max() < 1e-12
    decay = (-0.3 + np.sqrt(0.3**2 - 8 * 50 + 0j)) / 4
    assert np.abs(found.floquet - np.exp(decay / 0.7)).min() < 1e-12


@pytest.mark.parametrize(("order", "function"), [(1, mathieu_b), (1, mathieu_a), (2, mathieu_a)])
def test_hill_s_determinant_on_the_boundaries_of_mathieu_s_equation(order, function):
    # McLachlan, Theory and Application of Mathieu Functions (1947): y'' + (a - 2 q cos 2t) y = 0.
    # With damping y = exp(-c t/2) times a solution of the equation with a less c^2/4.
    q, c = 0.8, 0.02
    a = function(order, q) + c * c / 4
    model = sf.System(
        name="Mathieu's equation",
        parameters={"a": a, "q": q, "c": c},
        states={"y": "v", "v": "-c*v - (a - 2*q*cos(2*t))*y"},
        forcing={"period": "pi"},
    )
    found = sf.periodic_orbit(model).harmonic_balance(1e-6)
    assert found.passed, found
    expected = (-1) ** order * np.exp(-c * np.pi / 2)
    # At the boundary two multipliers coincide, where errors enter by their square root.
    assert np.abs(found.floquet - expected).max() < 1e-6


def test_what_is_wrong_is_seen():
    orbit = sf.periodic_orbit(chain(3, creeping(0.3)))
    multipliers = orbit.multipliers.copy()
    multipliers[:2] *= 1 + 1e-6
    found = replace(orbit, multipliers=multipliers).harmonic_balance()
    assert found.multipliers == pytest.approx(1e-6 * abs(multipliers[0]), rel=1e-3)
    assert not found.passed
    moved = replace(orbit, nodes=orbit.nodes + 1e-6 * orbit.model.state_scales())
    assert moved.harmonic_balance().states == pytest.approx(1e-6, rel=1e-3)
    # A multiplier that is there is not missed, and none is found twice.
    for wrong in (1e-12, multipliers[2]):
        lost = orbit.multipliers.copy()
        lost[:2] = wrong, np.conj(wrong)
        assert not replace(orbit, multipliers=lost).harmonic_balance().passed
    far = replace(orbit, nodes=orbit.nodes + 1e3)
    assert not far.harmonic_balance(largest=101).passed


def test_harmonics_that_are_left_out_are_counted():
    # The sharper the law, the more harmonics it takes; few of them say how few digits they have.
    orbit = sf.periodic_orbit(chain(1, creeping(0.05)))
    full = orbit.harmonic_balance()
    assert full.passed
    few = orbit.harmonic_balance(largest=21)
    assert len(few.harmonics) - 1 <= 10
    assert not few.passed
    assert few.truncation > 1e-8
    assert few.states < few.truncation
    assert "not within" in str(few)
    # Its derivatives jump within a ten thousandth of the largest speed, between two samples.
    law = sf.LuGre(mu_s=0.4, mu_k=0.3, vs=0.1, s0=200)
    for found in (sf.periodic_orbit(chain(1, law)).harmonic_balance(largest=n) for n in (201, 301)):
        assert 1e-6 < found.multipliers < found.truncation


def test_multipliers_that_fewer_harmonics_do_not_give_leave_the_truncation_unknown(monkeypatch):
    known, calls = harmonic_balance._multipliers, []

    def of_the_finer_alone(*given):
        calls.append(given)
        found = known(*given)
        return found if len(calls) % 2 == 0 else np.full_like(found, np.nan)

    orbit = sf.periodic_orbit(chain(1, creeping(0.3)))
    monkeypatch.setattr(harmonic_balance, "_multipliers", of_the_finer_alone)
    found = orbit.harmonic_balance()
    assert found.multipliers < 1e-10
    assert np.isnan(found.truncation)
    assert not found.passed


def test_what_is_no_series_is_refused():
    pendulum = sf.System(
        name="pendulum",
        parameters={"I": 2.0, "c": 0.5, "a": 0.1},
        states={
            "phi": {"rate": "w", "angle": True},
            "w": "I - c*w - sin(phi) + a*cos(t)",
        },
        forcing={"period": "2*pi"},
    )
    turning = PeriodicOrbit(pendulum, 1, np.array([[0.0, 4.0]]), np.ones(2, complex), 1.0)
    with pytest.raises(sf.InputError, match="revolves"):
        turning.harmonic_balance()
    sticking = chain(1, sf.Coulomb(mu_k=0.3)).replace(F=60.0)
    with pytest.raises(sf.InputError, match="forces that jump"):
        sf.periodic_orbit(sticking).harmonic_balance()


class WithFastMode:
    """Two multipliers whose perturbations are slow; nearest to one is the pole of a fast mode."""

    converged, inputs, exact = True, np.ones((2, 1)), np.array([0.5, 0.2])
    exponents = np.log([0.45, 0.25]) + 2j * np.pi * np.arange(2)

    def slope(self, shift):
        value = np.exp(shift)
        apart, poles = (value / (value - item) for item in (self.exact, np.exp(self.exponents)))
        if abs(shift.imag) < 1:
            return apart.sum() - poles.sum()
        return -2e4 - poles.sum() + np.delete(apart, np.abs(apart).argmax()).sum()


def test_harmonics_about_another_mode_give_no_spurious_multiplier():
    """Their steps are small as well, but do not shrink."""
    found = harmonic_balance._multipliers(WithFastMode(), WithFastMode.exact + 1e-5 + 0j, 0.0)
    np.testing.assert_allclose(found, WithFastMode.exact, atol=1e-12)


def test_a_spring_a_billionth_as_stiff_beside_another_does_no_harm():
    cubes = "(x + 0.7*y)^3", "1e-9*(0.3*x - y)^3"
    model = sf.System(
        parameters={"W": 0.7},
        forcing={"period": "2*pi/W"},
        states={
            "x": "u",
            "u": f"-0.2*u - x - 0.31*{cubes[0]} - 0.77*{cubes[1]} + 0.8*cos(W*t)",
            "y": "v",
            "v": f"-0.3*v - 2.3*y - 0.57*{cubes[0]} + 0.43*{cubes[1]}",
        },
    )
    assert sf.periodic_orbit(model).harmonic_balance().passed
