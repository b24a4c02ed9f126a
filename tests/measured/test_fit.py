"""Fits: known truth comes back, with the errors that closed forms give."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom

import slipfold as sf

DUFFING = sf.built_in_models()["duffing"]
LINEAR = DUFFING(g=0.0, W=1.0, d=0.1)
FREQUENCIES = np.linspace(0.7, 1.4, 12)
COUNT = 100  # fits of noisy readings


def amplitude(W, k, d, F):
    """Largest displacement of a linear oscillator, in closed form."""
    return F / np.sqrt((k - W**2) ** 2 + (d * W) ** 2)


def slopes(W, k, d, F):
    """Its derivatives with respect to stiffness and damping."""
    reach = amplitude(W, k, d, F)
    return np.column_stack([-(reach**3) * (k - W**2) / F**2, -(reach**3) * d * W**2 / F**2])


def measured(read, errors=np.nan, values=FREQUENCIES):
    """Readings of the largest displacement."""
    quantity = sf.Quantity("max", "q", "")
    readings = np.asarray(read)[:, None]
    return sf.Measurement(
        "W", "rad/s", values, (quantity,), readings, np.full(readings.shape, errors),
        ("",) * len(values),
    )  # fmt: skip


@pytest.fixture(scope="module")
def noisy():
    """Readings of a linear oscillator with noise, and the noise's deviation."""
    noise = np.random.default_rng(5).standard_normal(len(FREQUENCIES)) * 0.01
    return measured(amplitude(FREQUENCIES, 1.1, 0.12, LINEAR.F) + noise, 0.01)


@pytest.fixture(scope="module")
def fitted(noisy):
    """Stiffness and damping fitted to them."""
    return sf.fit(LINEAR, noisy, {"k": (0.5, 2.0), "d": (0.02, 0.5)})


def test_a_fit_to_a_linear_oscillator_is_that_of_the_closed_form(noisy, fitted):
    from scipy.optimize import least_squares

    F = LINEAR.F

    def away(u):
        return (amplitude(FREQUENCIES, *u, F) - noisy.readings[:, 0]) / 0.01

    known = least_squares(away, [1.0, 0.1], xtol=1e-15, ftol=1e-15, gtol=1e-15)
    found = [fitted["k"].value, fitted["d"].value]
    # Least squares leave the square root of rounding times the error of a parameter.
    assert np.allclose(found, known.x, atol=1e-6 * fitted["d"].error, rtol=0)
    exact = slopes(FREQUENCIES, *known.x, F) / 0.01
    errors = np.sqrt(np.diag(np.linalg.inv(exact.T @ exact)))
    assert np.allclose([fitted["k"].error, fitted["d"].error], errors, rtol=1e-6)
    assert fitted.scatter == pytest.approx(np.sqrt(known.fun @ known.fun / 10), rel=1e-6)
    assert fitted.converged
    assert fitted.used.all()
    assert abs(fitted["k"].value - 1.1) < 4 * fitted["k"].error
    assert fitted["k"].low < fitted["k"].value < fitted["k"].high


def half_width(estimate):
    """Half of the interval of 95 % confidence, in standard errors."""
    return (estimate.high - estimate.low) / 2 / estimate.error


def test_without_errors_what_is_left_over_gives_them(noisy, fitted):
    found = sf.fit(
        LINEAR, replace(noisy, errors=np.full((12, 1), np.nan)), {"k": (0.5, 2), "d": (0.02, 0.5)}
    )
    assert found["k"].value == pytest.approx(fitted["k"].value, rel=1e-9)
    assert found["k"].error == pytest.approx(fitted["k"].error * fitted.scatter, rel=1e-6)
    # Quantiles of the normal distribution, and of Student's with 12 - 2 degrees of freedom.
    assert half_width(fitted["k"]) == pytest.approx(1.959964, rel=1e-6)
    assert half_width(found["k"]) == pytest.approx(2.228139, rel=1e-6)


@pytest.mark.long
def test_intervals_hold_the_truth_as_often_as_they_say():
    truth = amplitude(FREQUENCIES, 1.1, 0.12, LINEAR.F)
    noise = np.random.default_rng(11)
    start = LINEAR.replace(k=1.1, d=0.12)
    held = 0
    for _ in range(COUNT):
        seen = measured(truth + noise.standard_normal(len(FREQUENCIES)) * 0.002, 0.002)
        found = sf.fit(start, seen, {"k": (0.5, 2.0), "d": (0.02, 0.5)})
        held += sum(found[name].low <= start.values[name] <= found[name].high for name in "kd")
    # 0.95 of them are expected: fewer than this come in one of a thousand runs of such tests.
    assert binom.cdf(held, 2 * COUNT, 0.95) > 1e-3


def test_a_fold_on_one_side_leaves_the_derivative_of_the_other():
    folded = DUFFING(d=0.06, F=0.2)
    fold = max(point.value for _, point in sf.response(folded, "W", (0.9, 1.4)).special)
    values = np.append(np.linspace(0.9, fold - 0.01, 5), fold - 1e-5)
    planned = sf.plan_measurement(folded, "W", values, ["max q"], ["F"], errors=0.01)
    assert np.isfinite(planned.slopes).all()
    # Beside a fold the derivative grows as one over the root of the distance.
    assert planned.slopes[-1, 0, 0] > 10 * planned.slopes[-2, 0, 0]


def test_an_interrupted_branch_is_not_taken_for_a_whole_one(monkeypatch):
    from slipfold.measured import stable_orbits

    whole = stable_orbits.trace_response

    def interrupted(model, vary, span, **options):
        def stop(progress):
            raise KeyboardInterrupt

        return whole(model, vary, span, observer=stop, **options)

    monkeypatch.setattr(stable_orbits, "trace_response", interrupted)
    with pytest.raises(KeyboardInterrupt):
        sf.plan_measurement(LINEAR, "W", FREQUENCIES, ["max q"], ["k"], errors=0.01)


def test_a_fit_is_saved_and_read_back(tmp_path, fitted):
    fitted.save(tmp_path / "fit.nc")
    again = sf.load(tmp_path / "fit.nc")
    assert again.summary() == fitted.summary()
    assert again.to_json() == fitted.to_json()
    assert fitted.to_json()["fitted"][0]["name"] == "k"
    fitted.to_csv(tmp_path / "fit.csv")
    assert (tmp_path / "fit.csv").read_text().startswith("W (rad/s),read max q,error of max q")
    assert "k = " in repr(fitted)
    labels = [text.get_text() for text in fitted.plot().get_legend().get_texts()]
    assert labels == ["fitted", "measured"]


@pytest.fixture(scope="module")
def swept():
    """Readings of Duffing's oscillator in both directions, across both of its folds."""
    values = np.linspace(0.9, 1.35, 10)
    return sf.measure(DUFFING(d=0.06, F=0.2), "W", values, ["max q"], sweep="both")


def test_both_sides_of_a_fold_are_explained(swept):
    up, down = (swept.some([way == each for each in swept.sweep]) for way in ("up", "down"))
    apart = np.abs(up.readings - down.readings[::-1])[:, 0]
    assert (apart > 0.3).any()  # hysteresis
    found = sf.fit(DUFFING(), swept, {"d": (0.02, 0.2), "F": (0.05, 0.5)})
    assert found.converged
    assert found.used.all()
    assert found["d"].value == pytest.approx(0.06, abs=1e-7)
    assert found["F"].value == pytest.approx(0.2, abs=1e-7)


def test_a_reading_that_nothing_explains_is_left_out_and_told(swept):
    readings = swept.readings.copy()
    readings[3] += 1.0
    found = sf.fit(DUFFING(), replace(swept, readings=readings), {"d": (0.02, 0.2)}, F=0.2)
    assert np.flatnonzero(~found.used).tolist() == [3]
    assert "1 of 20 rows are left out" in found.message
    assert found["d"].value == pytest.approx(0.06, abs=1e-7)


def test_friction_and_damping_from_a_frequency_response_of_the_sliding_oscillator():
    truth = sf.SlidingOscillator(Nd=0.03, mu=0.46, zeta1=0.012)
    seen = sf.measure(truth, "f", np.linspace(12.1, 12.9, 7), ["max y"], errors=1e-4, seed=3)
    start = truth.replace(mu=0.5, zeta1=0.02)
    found = sf.fit(start, seen, {"mu": (0.3, 0.7), "zeta1": (0.002, 0.05)})
    for name, value in {"mu": 0.46, "zeta1": 0.012}.items():
        assert abs(found[name].value - value) < 4 * found[name].error
        assert found[name].error < 0.01 * value


def test_what_readings_say_nothing_about_is_told():
    # Damping does not change steady sliding.
    oscillator = sf.SlidingOscillator(Nd=0.0, f=12.5)
    seen = sf.measure(oscillator, "f", [12.0, 12.5, 13.0], ["max y"])
    found = sf.fit(oscillator, seen, {"zeta1": (0.001, 0.05)})
    assert np.isinf(found["zeta1"].error)
    assert "say nothing about zeta1" in found.message


@pytest.mark.parametrize(
    ("bounds", "words"),
    [
        ({}, "no parameter is fitted"),
        ({"W": (0.5, 2.0)}, "W was varied in the measurement"),
        ({"q": (0, 1)}, "duffing has no parameter 'q'"),
        ({"k": (2, 1)}, "bounds of k from 2 to 1 leave nothing"),
        ({"k": (2, 3)}, "k = 1 lies outside its bounds 2 to 3"),
        ({"k": 2}, "is not a pair of numbers"),
    ],
)
def test_bounds_that_cannot_be_used(noisy, bounds, words):
    with pytest.raises(sf.InputError, match=words):
        sf.fit(LINEAR, noisy, bounds)


def test_too_few_readings_and_other_things_that_are_none(noisy):
    bounds = {"k": (0.5, 2), "d": (0.02, 0.5)}
    with pytest.raises(sf.InputError, match="explain 2 of 2 readings, too few for 2 parameters"):
        sf.fit(LINEAR, noisy.some(slice(2)), bounds)
    with pytest.raises(sf.InputError, match="is not a measurement"):
        sf.fit(LINEAR, [1, 2], bounds)
    errors = noisy.errors.copy()
    errors[2] = np.nan
    with pytest.raises(sf.InputError, match="11 of 12 readings have an error"):
        sf.fit(LINEAR, replace(noisy, errors=errors), bounds)
