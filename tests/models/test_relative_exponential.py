"""(exp(x) - 1)/x and its derivatives, at and about its removable singularity, against decimals."""

from decimal import Decimal, localcontext

import heyoka as hy
import numpy as np
import pytest

import slipfold as sf
from slipfold.models.formulas.functions import FUNCTIONS

EXPREL = FUNCTIONS["exprel"]
PLACES = [
    *(0.0, 1e-300, -1e-300, 1e-20, 1e-8, -1e-8, 1e-3, -1e-3, 0.5, -0.7, 1.9999, -1.9999),
    *(2.0, -2.0, 2.0001, -2.1, 3.0, -4.5, 10.0, -10.0, 36.0, -37.0, 150.0, -150.0, 700.0, -700.0),
]


def derivative(x, order):
    """The integral of s^order exp(s x) over s from 0 to 1, by its series in long decimals."""
    with localcontext() as context:
        context.prec = 700  # terms up to exp(700) cancel where x is negative
        x, term, total = Decimal(x), Decimal(1), Decimal(0)
        for k in range(40 + 6 * int(abs(x))):
            total += term / (k + order + 1)
            term *= x / (k + 1)
        return float(total)


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_values_and_derivatives_are_exact_to_rounding(order):
    x = hy.expression("x")
    formula = EXPREL.symbolic(x)
    for _ in range(order):
        formula = hy.diff(formula, x)
    found = hy.cfunc([formula], [x])(np.array([PLACES]))[0]
    expected = [derivative(position, order) for position in PLACES]
    # A handful of roundings; quotients of derivatives cancel by a few at |x| = 2.
    assert found == pytest.approx(expected, rel=(1 + 2 * order) * 1e-15, abs=0)


@pytest.mark.parametrize("sign", [1, -1])
def test_orbits_are_those_of_collocation(sign):
    model = sf.System(
        name="gate",
        parameters={"a": 3.0},
        states={"m": f"1/exprel({-sign}*a*cos(2*pi*t)) - 0.5*m", "h": "m - h*exprel(sin(2*pi*t))"},
        forcing={"period": "1"},
    )
    orbit = sf.periodic_orbit(model)
    assert orbit.check().passed
    assert orbit.stable


def test_rest_of_the_axon_of_hodgkin_and_huxley():
    # Published: the space-clamped axon at 6.3 degrees begins to fire at I = 9.78.
    axon = sf.System(
        name="axon",
        parameters={"I": 0.0},
        formulas={
            "am": "1/exprel(-(V + 40)/10)",
            "bm": "4*exp(-(V + 65)/18)",
            "ah": "0.07*exp(-(V + 65)/20)",
            "bh": "1/(1 + exp(-(V + 35)/10))",
            "an": "0.1/exprel(-(V + 55)/10)",
            "bn": "0.125*exp(-(V + 65)/80)",
        },
        states={
            "V": {
                "rate": "I - 120*m^3*h*(V - 50) - 36*n^4*(V + 77) - 0.3*(V + 54.4)",
                "start": -65,
            },
            "m": {"rate": "am*(1 - m) - bm*m", "start": 0.05},
            "h": {"rate": "ah*(1 - h) - bh*h", "start": 0.6},
            "n": {"rate": "an*(1 - n) - bn*n", "start": 0.32},
        },
    )
    diagram = sf.response(axon, "I", (8, 11), settings=sf.Settings(largest_period=1))
    (hopf,) = (point for point in diagram.branches[0].special if point.type == "HB")
    assert hopf.value == pytest.approx(9.78, abs=0.005)
