"""Gradients of thresholds: reference values, units of measurement, closed forms, differences."""

import math

import pytest
from scipy.optimize import brentq

import slipfold as sf
from helpers.dry_friction import belt, highest_after_a_touch

QUIET = sf.Settings(largest_period=1)
BUILT_IN = sf.built_in_models()


@pytest.fixture(scope="module")
def sliding():
    return sf.response(sf.SlidingOscillator(), "Nd", (0, 0.98), f=12.5, gradients=True).special


def differenced(located, step):
    """The derivative of what is located at changes of a parameter, to the fourth order."""
    near, far = located(step) - located(-step), located(2 * step) - located(-2 * step)
    return (8 * near - far) / (12 * step)


def check_by_differences(model, vary, found, names, step=2e-4, width=0.05):
    """Thresholds located again, beside the point, give its gradients."""
    for name in names:
        value = found.model.values[name]

        def located(change, name=name, value=value):
            changed = model.replace(**{name: value * (1 + change)})
            span = (found.value * (1 - width), found.value * (1 + width))
            points = sf.response(changed, vary, span, settings=QUIET).special
            same = [point for _, point in points if point.type == found.type]
            return min((point.value for point in same), key=lambda at: abs(at - found.value))

        expected = differenced(located, step) / value
        assert sf.gradients(found)[name] == pytest.approx(expected, rel=1e-6), name


def test_reference_values(sliding):
    # shared/reference/beyond.md: by two methods that share no code.
    expected = {
        "PD": {
            "f": 0.1784357997,
            "Vd": -0.041609200963,
            "alpha": -0.074329849432,
            "mu": -0.01021911064,
            "zeta1": 2.5357543997,
            "L": 6.0150151795,
        },
        "NS": {"f": 24.415581877, "Vd": 1.8151100867},
    }
    (_, doubling), _, (_, torus) = sliding
    for point in (doubling, torus):
        found = {name: point.gradients[name] for name in expected[point.type]}
        assert found == pytest.approx(expected[point.type], rel=1e-9)


@pytest.mark.parametrize("which", [0, 1, 2])
def test_other_units_change_nothing(sliding, which):
    """Euler's relations: a point is the same in other units of force, of length and of time."""
    point = sliding[which].point
    moved = {name: point.model.values[name] * by for name, by in point.gradients.items()}

    def together(*names):
        return sum(moved[name] for name in names)

    size = max(map(abs, moved.values()))
    assert together("k1", "k2", "kext", "Ns") == pytest.approx(point.value, abs=1e-9 * size)
    assert together("L", "Vd", "Ns") == pytest.approx(point.value, abs=1e-9 * size)
    assert together("f", "f1", "f2", "Vd") == pytest.approx(0, abs=1e-9 * size)


def test_sliding_oscillator_by_differences(sliding):
    point = sliding[0].point
    check_by_differences(point.model, "Nd", point, ("zeta2", "f1", "kext"))


def test_hopf_point_of_lorenz():
    diagram = sf.response(BUILT_IN["lorenz"](), "rho", (20, 28), start={"x": 7, "y": 7, "z": 19})
    (point,) = (point for _, point in diagram.special if point.type == "HB")
    sigma, beta = point.model.values["sigma"], point.model.values["beta"]
    # rho = s (s + b + 3)/(s - b - 1)
    above, below = sigma * (sigma + beta + 3), sigma - beta - 1
    expected = {
        "sigma": (2 * sigma + beta + 3) / below - above / below**2,
        "beta": sigma / below + above / below**2,
    }
    assert sf.gradients(point) == pytest.approx(expected, rel=1e-9)


def test_a_branch_point_that_a_parameter_parts_has_no_gradient():
    model = sf.System(
        name="strut",
        parameters={"r": -1.0, "s": 0.5, "h": 0.0},
        states={"x": "(r + s^2)*x - x^3 + h", "y": "-y"},
    )
    (_, point), *_ = sf.response(model, "r", (-1, 1), start={"x": 0.0}, settings=QUIET).special
    assert point.type == "BP"
    found = sf.gradients(point)
    assert found["s"] == pytest.approx(-1, rel=1e-9)
    assert math.isnan(found["h"])


def test_touch_of_stick_by_another_integrator():
    law = sf.Stribeck(mu_s=1.0, mu_k=0.5, vs=0.5)
    cycle = sf.periodic_orbit(belt(law, 1.5, damping=0.1), state={"x": 2.0})
    ((_, point),) = sf.response(cycle, "Vd", (1.5, 1.9)).special
    near = 0.99 * point.value, 1.01 * point.value

    def located(change):
        return brentq(highest_after_a_touch, *near, args=(0.5 + change,), xtol=1e-13)

    expected = differenced(located, 1e-3)
    assert sf.gradients(point)["mu_k"] == pytest.approx(expected, rel=1e-6)


def test_collocation_finds_the_same(sliding):
    settings = sf.Settings(discretization="collocation", largest_period=1)
    model = sf.SlidingOscillator(f=12.5)
    diagram = sf.response(model, "Nd", (0, 0.05), settings=settings, gradients=True)
    expected = sliding[0].point.gradients
    assert diagram.special[0].point.gradients == pytest.approx(expected, rel=1e-7)


def test_what_has_no_locus_has_no_gradients():
    event = sf.Event("Nd", 0.01, "parameter")
    model = sf.SlidingOscillator()
    diagram = sf.response(model, "Nd", (0, 0.02), events=[event], gradients=True)
    ((_, point),) = diagram.special
    assert point.gradients is None
    with pytest.raises(sf.InputError, match="type EVENT has no gradients; give one of type LP, PD"):
        sf.gradients(point)
