"""Steady sliding as an equilibrium: eigenvalues, onset of squeal, the cycles that emanate there."""

import numpy as np
import pytest
from scipy.optimize import brentq

import slipfold as sf
from helpers.by_hand.sliding import BASE, end_of, rhs
from helpers.dry_friction import belt
from slipfold import Coulomb, InputError, LuGre, SlidingOscillator, Stribeck, Unforced
from slipfold.models.model import evaluation_of
from slipfold.models.registry import model_named

SINGLE = sf.Settings(largest_period=1)
FALLING = Stribeck(mu_s=0.9, mu_k=0.3, vs=0.3)
BELT = Stribeck(mu_s=1.0, mu_k=0.5, vs=0.5)


def eigenvalues(model, point=None):
    at = model.static_point() if point is None else point
    return np.linalg.eigvals(evaluation_of(model).jacobian(model, at))


def rates_by_hand(time, state, p):
    """The sliding oscillator with exponential Stribeck friction; complex steps differentiate it."""
    slip_x = p["Vd"] * np.cos(p["alpha"]) - p["L"] * state[2]
    slip_y = p["Vd"] * np.sin(p["alpha"]) - p["L"] * state[3]
    speed = np.sqrt(slip_x**2 + slip_y**2)
    mu = p["mu_k"] + (p["mu_s"] - p["mu_k"]) * np.exp(-speed / p["vs"])
    return rhs(time, state, {**p, "mu": mu, "Nd": 0.0})


def growth_by_hand(values, point):
    """Largest real part of the eigenvalues at a point, by complex steps and SciPy's solver."""
    step = 1e-30
    columns = [rates_by_hand(0, point + 1j * step * e, values).imag / step for e in np.eye(4)]
    return np.linalg.eigvals(np.transpose(columns)).real.max()


def test_the_forcing_leaves_no_parameter_behind():
    forced = SlidingOscillator(friction=FALLING, f=11.0, Nd=0.3, Vd=0.7)
    model = forced.steady()
    assert not model.forced
    assert {item.name for item in forced.parameters} - {item.name for item in model.parameters} == {
        "f",
        "Nd",
    }
    assert model.parameters[-1].name == "duration"
    assert model.states == forced.states
    assert model == forced.replace(f=12.5, Nd=0.0).steady()
    assert model.static_point() == pytest.approx(forced.static_point(), abs=1e-14)
    state, unforced = np.array([0.2, -0.1, 3.0, -5.0]), forced.replace(Nd=0.0)
    assert evaluation_of(model).rates(model, state) == pytest.approx(
        evaluation_of(unforced).rates(unforced, state, 0.3), rel=1e-14
    )
    for output in forced.outputs():
        assert model.evaluate(output.name, state) == pytest.approx(
            unforced.evaluate(output.name, state, 0.01), rel=1e-12, abs=1e-15
        )


def test_onset_of_squeal_by_falling_friction():
    diagram = sf.response(
        SlidingOscillator(friction=FALLING).steady(), "Vd", (1.5, 0.62), settings=SINGLE
    )
    [(_, hopf), *_] = diagram.special
    assert (hopf.type, hopf.criticality) == ("HB", "supercritical")

    def growth(speed):
        model = SlidingOscillator(friction=FALLING, Vd=speed)
        point, p = model.static_point(), {**BASE, **model.values}
        assert rates_by_hand(0, point, p) / [1, 1, 78, 78] == pytest.approx(np.zeros(4), abs=1e-10)
        return growth_by_hand(p, point)

    assert hopf.value == pytest.approx(brentq(growth, 0.5, 0.8, xtol=1e-13), abs=1e-9)
    found = eigenvalues(SlidingOscillator(friction=FALLING, Vd=hopf.value).steady())
    turn = np.abs(found[np.abs(found.real).argmin()])
    assert hopf.duration == pytest.approx(2 * np.pi / turn, rel=1e-9)
    # The cycle that emanates there, closed by an integrator and equations that share no code.
    cycles = diagram.branches[1]
    orbit = cycles.orbit(-1)
    p = {**BASE, **orbit.model.values}
    end = end_of(rates_by_hand, p["duration"], orbit.nodes[0], p)
    assert end == pytest.approx(orbit.nodes[0], abs=1e-8)
    # Supercritical: it lives where steady sliding is unstable, and its amplitude grows as a root.
    assert np.all(cycles.parameter[1:] < hopf.value)


def test_a_structure_under_constant_loads_is_autonomous_by_itself():
    model = belt(BELT, 1.5, 0.1)  # system 11 of the textbook as a structure
    assert not model.forced
    assert model.parameters[0].name == "duration"
    with pytest.raises(InputError, match="structure is autonomous already"):
        model.steady()


def onset(law):
    """Speed at which steady sliding loses its stability, from the eigenvalues alone."""
    model = SlidingOscillator(friction=law).steady()

    def growth(speed):
        return eigenvalues(model.replace(Vd=speed)).real.max()

    return brentq(growth, 0.5, 1.6, xtol=1e-13)


def test_friction_with_a_fast_memory_loses_stability_where_its_steady_law_does():
    falling = Stribeck(mu_s=0.9, mu_k=0.3, vs=0.5, exponent=2)
    law = LuGre(mu_s=0.9, mu_k=0.3, vs=0.5, s1=0.0, e=1e-9)
    errors = [abs(onset(law.replace(s0=s0)) - onset(falling)) for s0 in (1e4, 1e5, 1e6)]
    assert errors[0] < 0.01
    assert errors[0] / errors[1] == pytest.approx(10, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(10, rel=0.1)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Unforced(0.3), "0.3 is not a model"),
        (lambda: Unforced(model_named("lorenz")), "lorenz is autonomous already"),
        (lambda: Unforced(SlidingOscillator().steady()), "steady-sliding is autonomous already"),
        (lambda: SlidingOscillator().steady(Nd=0.1), "steady-sliding has no parameter 'Nd'"),
        (lambda: SlidingOscillator().steady(Vd=-1), "Vd must be >= 0 m/s"),
        (lambda: SlidingOscillator().steady(Vd=0).static_point(), "Vd must be > 0 m/s"),
        (lambda: SlidingOscillator().steady().replace(friction=0.3), "is not a friction law"),
        (lambda: SlidingOscillator(friction=Coulomb()).steady(mu_k=0.6), "give mu_s >= mu_k"),
    ],
)
def test_bad_input_gets_one_sentence(make, message):
    with pytest.raises(InputError) as error:
        make()
    assert message in str(error.value)
    assert "\n" not in str(error.value)
