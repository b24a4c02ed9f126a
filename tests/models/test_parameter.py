"""Bounds of parameters, and the sentences about them."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipfold import InputError, Parameter, SlidingOscillator

FINITE = st.floats(allow_nan=False, allow_infinity=False)


@given(FINITE, FINITE, FINITE, st.booleans(), st.booleans())
def test_check_agrees_with_the_bounds(value, one, other, lower_open, upper_open):
    lower, upper = sorted((one, other))
    parameter = Parameter("q", 0.0, "N", "", lower, upper, lower_open, upper_open)
    inside = (lower < value if lower_open else lower <= value) and (
        value < upper if upper_open else value <= upper
    )
    if inside:
        assert parameter.check(value) == value
    else:
        with pytest.raises(InputError, match="outside its bounds"):
            parameter.check(value)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("parameter", SlidingOscillator.parameters, ids=lambda item: item.name)
def test_not_finite_is_refused(parameter, value):
    with pytest.raises(InputError, match="is not a finite number"):
        SlidingOscillator(**{parameter.name: value})


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"L": 0}, "L = 0 is outside its bounds; L must be > 0 m"),
        ({"Vd": "-0.1 m/s"}, "Vd must be >= 0 m/s"),
        ({"mu": -0.1}, "mu = -0.1 is outside its bounds; mu must be >= 0"),
        ({"f": 0}, "f must be > 0 Hz"),
        ({"Nd": -1e-9}, "Nd must be >= 0 N"),
        ({"Nd": 1.0}, "Nd = 1 N is not below Ns = 1 N"),
        ({"Nd": 0.7, "Ns": 0.6}, "give Nd < Ns"),
        ({"vd": 0.5}, "no parameter 'vd'; did you mean Vd?"),
        ({"viscosity": 1}, "no parameter 'viscosity'; it has k1, zeta1"),
        ({"f": "12.5 m"}, "f = '12.5 m' has the unit 'm'"),
        ({"f": "fast"}, "f = 'fast' is not a number"),
    ],
)
def test_bad_value_gets_one_sentence(values, message):
    with pytest.raises(InputError) as error:
        SlidingOscillator(**values)
    assert message in str(error.value)
    assert "\n" not in str(error.value)
