"""Plans of measurements: expected errors are those of fits, and the best points are the best."""

from itertools import combinations

import numpy as np
import pytest

import slipfold as sf

LINEAR = sf.built_in_models()["duffing"](g=0.0, k=1.1, d=0.12)
FREQUENCIES = np.linspace(0.7, 1.4, 8)


@pytest.fixture(scope="module")
def planned():
    """Measurements of a linear oscillator that would tell stiffness and damping."""
    return sf.plan_measurement(LINEAR, "W", FREQUENCIES, ["max q"], ["k", "d"], errors=0.01)


def exact():
    """The derivatives of its measurements, in closed form."""
    W, k, d, F = FREQUENCIES, LINEAR.k, LINEAR.d, LINEAR.F
    reach = F / np.sqrt((k - W**2) ** 2 + (d * W) ** 2)
    return np.column_stack([-(reach**3) * (k - W**2) / F**2, -(reach**3) * d * W**2 / F**2])


def test_derivatives_and_errors_are_those_of_the_closed_form(planned):
    assert np.allclose(planned.slopes[:, 0], exact(), rtol=1e-6, atol=1e-7)
    information = exact().T @ exact() / 0.01**2
    errors = np.sqrt(np.diag(np.linalg.inv(information)))
    assert np.allclose(planned.errors_expected, errors, rtol=1e-6)


def test_parameters_that_only_their_product_shows_have_no_error():
    # Derivatives by differences are known to 1e-8, so that their rank is not exactly one.
    product = sf.System(
        parameters={"W": 0.9, "a": 1.3, "b": 0.7, "d": 0.12},
        states={"q": "v", "v": "0.2*cos(W*t) - d*v - a*b*q"},
        forcing={"period": "2*pi/W"},
    )
    found = sf.plan_measurement(product, "W", FREQUENCIES, ["max q"], ["a", "b", "d"], errors=1e-5)
    assert np.isinf(found.errors_expected[:2]).all()
    assert np.isfinite(found.errors_expected[2])


def test_the_best_points_are_those_of_all_that_could_be_chosen(planned):
    def listed(rows):
        part = exact()[list(rows)]
        return np.linalg.det(part.T @ part)

    for count in (2, 3):
        best = max(combinations(range(8), count), key=listed)
        assert planned.best(count) == sorted(best)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"fitted": []}, "nothing is planned"),
        ({"fitted": ["W"]}, "W is varied, so it cannot be fitted"),
        ({"fitted": ["k", "k"]}, "is named twice"),
        ({"fitted": ["g"]}, "g = 0 has no size"),
        ({"errors": 0.0}, "leave nothing uncertain"),
        ({"quantities": ["max z"]}, "duffing has no output 'z'"),
    ],
)
def test_what_cannot_be_planned(change, words):
    given = {"quantities": ["max q"], "fitted": ["k"], "errors": 0.01, **change}
    with pytest.raises(sf.InputError, match=words):
        sf.plan_measurement(LINEAR, "W", FREQUENCIES, **given)
