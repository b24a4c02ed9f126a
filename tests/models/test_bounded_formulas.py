"""Formulas whose parts overflow have the values and derivatives that they have by themselves."""

import heyoka as hy
import numpy as np
import pytest

import slipfold as sf
from slipfold.flow.simulate import simulate
from slipfold.models.formulas.grammar import parse_formula
from slipfold.models.formulas.values import value_of

PLACES = np.array([-1e5, -800.0, -30.0, -2.0, -1e-3, 0.0, 1e-3, 0.7, 20.0, 400.0, 900.0, 1e6])


def sech(x):
    small = np.exp(-np.abs(x))
    return 2 * small / (1 + small * small)


def logistic(x):
    return np.where(x < 0, np.exp(np.minimum(x, 0)), 1.0) / (1 + np.exp(-np.abs(x)))


FORMULAS = {
    "3/(2*cosh(x)^2)": (lambda x: 1.5 * sech(x) ** 2, lambda x: -3 * sech(x) ** 2 * np.tanh(x)),
    "sinh(x)/cosh(x)": (np.tanh, lambda x: sech(x) ** 2),
    "exp(x)/(1 + exp(x))": (logistic, lambda x: logistic(x) * logistic(-x)),
    "cosh(x)^-4": (lambda x: sech(x) ** 4, lambda x: -4 * sech(x) ** 4 * np.tanh(x)),
    "1/(2 + exp(x))": (
        lambda x: 0.5 * logistic(np.log(2) - x),
        lambda x: -0.5 * logistic(np.log(2) - x) * logistic(x - np.log(2)),
    ),
}


@pytest.mark.parametrize("formula", FORMULAS)
def test_values_and_slopes_are_finite_and_right(formula):
    x = hy.expression("x")
    tree = parse_formula(formula)
    symbolic = value_of(tree, {"x": x})
    values = hy.cfunc([symbolic, hy.diff(symbolic, x)], [x])(PLACES[None].copy())
    value, slope = FORMULAS[formula]
    assert values[0] == pytest.approx(value(PLACES), rel=1e-12, abs=1e-10)
    assert values[1] == pytest.approx(slope(PLACES), rel=1e-12, abs=1e-14)
    numbers = [value_of(tree, {"x": float(position)}) for position in PLACES]
    assert numbers == pytest.approx(list(value(PLACES)), rel=1e-12, abs=1e-10)


def model(law):
    return sf.System(
        name="bell",
        parameters={"e": {"value": 1e-3, "min": 0}},
        states={"x": "v", "v": f"2*cos(0.8*t) - x - 0.1*v - 0.5*({law})"},
        forcing={"period": "2*pi/0.8"},
    )


def test_motions_go_on_where_parts_overflow():
    """Their speeds are a thousand widths and more."""
    found, exact = simulate(model("1/cosh(v/e)^2"), 20), simulate(model("1 - tanh(v/e)^2"), 20)
    assert found.stopped is None
    assert np.abs(found.states[:, 1]).max() > 1
    assert found.states[-1] == pytest.approx(exact.states[-1], abs=1e-8)


def test_a_response_is_followed_to_where_parts_overflow():
    diagram = sf.response(model("1/cosh(v/e)^2"), "e", (1, 0.001))
    assert diagram.branches[0].stopped.kind == "span"
    assert diagram.checked.agree
