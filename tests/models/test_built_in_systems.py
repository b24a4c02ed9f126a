"""The systems that come as files: values and sources in shared/reference/textbook.md."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import slipfold as sf
from slipfold import InputError, built_in_models
from slipfold.models.model import evaluation_of
from slipfold.models.registry import built_in_text, model_named

SYSTEMS = [name for name in built_in_models() if isinstance(model_named(name), sf.System)]


@pytest.mark.parametrize("name", SYSTEMS)
def test_files_are_complete(name):
    model = model_named(name)
    assert model.name == name
    assert model.title
    assert all(parameter.doc for parameter in model.parameters)
    assert all(state.label.startswith("$") for state in model.states)
    assert all(output.doc for output in model.outputs())
    text = built_in_text(name)
    assert text.startswith("# ")
    assert sf.System.from_toml(text) == model
    assert sf.System(model.to_toml()) == model


def test_they_are_found_by_name():
    assert {"duffing", "mathieu", "vanderpol", "lorenz"} <= set(SYSTEMS)
    assert model_named("duffing", W=1.1).W == 1.1
    with pytest.raises(InputError, match="no model 'dufing'"):
        built_in_text("dufing")
    with pytest.raises(InputError, match="sliding is written in Python"):
        built_in_text("sliding")


def test_cycle_of_the_free_van_der_pol_oscillator():
    model = model_named("vanderpol-free")

    def rates(t, state):
        return evaluation_of(model).rates(model, state)

    def turning(t, state):
        return state[1]

    turning.direction = -1
    run = solve_ivp(rates, (0, 100), [2, 0], "DOP853", rtol=1e-11, atol=1e-12, events=turning)
    assert np.diff(run.t_events[0])[-1] == pytest.approx(6.663286859323, abs=1e-8)
    assert run.y_events[0][-1, 0] == pytest.approx(2.008619860875, abs=1e-9)


def growth(model, point):
    """Largest real part of the complex eigenvalues at an equilibrium."""
    values = np.linalg.eigvals(evaluation_of(model).jacobian(model, point))
    return values[values.imag != 0].real.max()


def crossing(model, vary, low, high, point=lambda model: np.zeros(len(model.states))):
    """Value of the parameter at which an equilibrium changes stability."""

    def margin(value):
        changed = model.replace(**{vary: value})
        assert evaluation_of(changed).rates(changed, point(changed)) == pytest.approx(0, abs=1e-12)
        return growth(changed, point(changed))

    return brentq(margin, low, high, xtol=1e-13)


def routh_hurwitz_of_freire(b=0.5, g=-0.6, r=0.6):
    """Hopf point in n: with u = (b + n)/r and k = b + g, (u + k) (1 + u k - b^2/r) = u."""
    k = b + g
    u = np.roots([k, k**2 - b**2 / r, k * (1 - b**2 / r)])
    return r * u[np.abs(u).argmin()] - b


def steady_sliding(model):
    friction = model.md * (1 + (model.r - 1) * np.exp(-model.vd / model.v0))
    return np.array([friction, 0.0])


def convection(model):
    side = np.sqrt(model.beta * (model.rho - 1))
    return np.array([side, side, model.rho - 1])


@pytest.mark.parametrize(
    ("name", "vary", "span", "value", "point"),
    [
        ("lure", "a", (0.5, 1.5), 1.0, None),
        # The list of values has -0.589336512; this is the root of the Routh-Hurwitz condition.
        ("freire", "n", (-0.595, -0.585), routh_hurwitz_of_freire(), None),
        ("stribeck", "vd", (1.0, 1.5), 1.151292546497, steady_sliding),
        ("stuart-landau", "r", (-0.3, 0.4), 0.0, None),
        ("vanderpol-free", "mu", (-0.3, 0.4), 0.0, None),
        ("squeal", "mu", (0.7, 0.8), (1 + 2 * 0.05**2) * 0.75, None),
        ("lorenz", "rho", (20, 28), 10 * (13 + 8 / 3) / (9 - 8 / 3), convection),
    ],
)
def test_stability_of_equilibria(name, vary, span, value, point):
    model = model_named(name)
    found = crossing(model, vary, *span, **({} if point is None else {"point": point}))
    assert found == pytest.approx(value, abs=1e-9)


def test_slip_ends_where_the_mass_sticks():
    model = model_named("stribeck", vd=0.5)
    motion = sf.simulate(model, 100, {"x": 1.5})
    assert motion.stopped.kind == "stick"
    assert motion.stopped.reason.startswith("stick: the relative speed fell to 0.001")
