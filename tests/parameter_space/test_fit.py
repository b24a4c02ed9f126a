"""Fits: known truth comes back, with the errors that closed forms give."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import optimize
from scipy.stats import binom

import slipfold as sf
from slipfold.parameter_space import least_squares, stable_orbits

DUFFING = sf.built_in_models()["duffing"]
LINEAR = DUFFING(g=0.0, W=1.0, d=0.1)
FREQUENCIES = np.linspace(0.7, 1.4, 12)
COUNT = 200  # fits of noisy measurements


def amplitude(W, k, d, F):
    """Largest displacement of a linear oscillator, in closed form."""
    return F / np.sqrt((k - W**2) ** 2 + (d * W) ** 2)


def slopes(W, k, d, F):
    """Its derivatives with respect to stiffness and damping."""
    reach = amplitude(W, k, d, F)
    return np.column_stack([-(reach**3) * (k - W**2) / F**2, -(reach**3) * d * W**2 / F**2])


def measured(read, errors=np.nan, values=FREQUENCIES):
    """Measurements of the largest displacement."""
    quantity = sf.Quantity("max", "q", "")
    measurements = np.asarray(read)[:, None]
    return sf.Measurement(
        "W", "rad/s", values, (quantity,), measurements, np.full(measurements.shape, errors),
        ("",) * len(values),
    )  # fmt: skip


@pytest.fixture(scope="module")
def noisy():
    """Measurements of a linear oscillator with noise, and the noise's deviation."""
    noise = np.random.default_rng(5).standard_normal(len(FREQUENCIES)) * 0.01
    return measured(amplitude(FREQUENCIES, 1.1, 0.12, LINEAR.F) + noise, 0.01)


@pytest.fixture(scope="module")
def fitted(noisy):
    """Stiffness and damping fitted to them."""
    return sf.fit(LINEAR, noisy, {"k": (0.5, 2.0), "d": (0.02, 0.5)})


def test_a_fit_to_a_linear_oscillator_is_that_of_the_closed_form(noisy, fitted):
    F = LINEAR.F

    def away(u):
        return (amplitude(FREQUENCIES, *u, F) - noisy.measured[:, 0]) / 0.01

    known = optimize.least_squares(away, [1.0, 0.1], xtol=1e-15, ftol=1e-15, gtol=1e-15)
    found = [fitted["k"].value, fitted["d"].value]
    # Least squares leave the square root of rounding times the error of a parameter.
    assert np.allclose(found, known.x, atol=1e-6 * fitted["d"].error, rtol=0)
    exact = slopes(FREQUENCIES, *known.x, F) / 0.01
    errors = np.sqrt(np.diag(np.linalg.inv(exact.T @ exact)))
    assert np.allclose([fitted["k"].error, fitted["d"].error], errors, rtol=1e-6)
    assert fitted.residual_std == pytest.approx(np.sqrt(known.fun @ known.fun / 10), rel=1e-6)
    assert fitted.converged
    assert fitted.used.all()
    assert abs(fitted["k"].value - 1.1) < 4 * fitted["k"].error
    assert fitted["k"].low < fitted["k"].value < fitted["k"].high


def profile_end(measurements, place, rise, guess):
    """End of an interval of the linear oscillator by its profile, from the closed form."""
    bounds = [(0.5, 2.0), (0.02, 0.5)]

    def squares(u):
        return np.sum((amplitude(FREQUENCIES, *u, LINEAR.F) - measurements) ** 2)

    def profile(value):
        held = [lambda other: (value, other), lambda other: (other, value)][place]
        return optimize.minimize_scalar(
            lambda other: squares(held(other)), bounds=bounds[1 - place], options={"xatol": 1e-10}
        ).fun

    best, far = guess
    return optimize.brentq(
        lambda value: profile(value) - profile(best) - rise, best, far, xtol=1e-9
    )


def test_intervals_are_those_of_the_profile(noisy, fitted):
    measurements = noisy.measured[:, 0]
    unknown = sf.fit(
        LINEAR, replace(noisy, errors=np.full((12, 1), np.nan)), {"k": (0.5, 2), "d": (0.02, 0.5)}
    )
    assert unknown["k"].value == pytest.approx(fitted["k"].value, rel=1e-9)
    assert unknown["k"].error == pytest.approx(fitted["k"].error * fitted.residual_std, rel=1e-6)
    # Quantiles of the normal distribution, and of Student's with 12 - 2 degrees of freedom.
    rises = (1.959964 * 0.01) ** 2, (2.228139 * 0.01 * fitted.residual_std) ** 2
    for found, rise in zip((fitted, unknown), rises, strict=True):
        for place, name in enumerate("kd"):
            item = found[name]
            for end, way in ((item.low, -1), (item.high, 1)):
                guess = item.value, item.value + way * 5 * item.error
                exact = profile_end(measurements, place, rise, guess)
                assert end == pytest.approx(exact, abs=5e-3 * abs(exact - item.value))


def duffing_down(seed):
    """Measurements of Duffing's oscillator downward, which jump up at its left fold."""
    truth = DUFFING(d=0.06, g=0.9, F=0.2)
    values = np.linspace(0.8, 1.6, 9)
    return sf.measure(truth, "W", values, ["max q"], sweep="down", errors=0.05, seed=seed)


def test_what_far_from_a_resonance_is_known_of_damping_is_an_interval_to_its_bound():
    found = sf.fit(DUFFING(g=0.9, F=0.2, d=0.1), duffing_down(2), {"d": (0.01, 0.3)})
    interval = found["d"]
    assert interval.low == 0.01
    assert 0.06 < interval.high < 0.2
    best = np.sum(((found.predicted - found.measurement.measured) / 0.05) ** 2)
    rises = [
        np.sum(((at - found.measurement.measured) / 0.05) ** 2) - best
        for at in (nearest_read(found, d) for d in (0.01, 0.03, interval.high))
    ]
    assert max(rises[:2]) < 3.841
    assert rises[2] == pytest.approx(3.841, rel=0.05)


def nearest_read(fit, d):
    """What the stable responses nearest to measurements are at another damping."""
    seen = fit.measurement
    orbits = stable_orbits.stable_orbits(fit.model.replace(d=d), "W", seen.values, seen.quantities)
    pairs = zip(orbits, seen.measured, strict=True)
    given = (([o.predicted for o in row], y) for row, y in pairs)
    return np.array([min(row, key=lambda r: abs(r - y)[0]) for row, y in given])


@pytest.mark.long
def test_rows_below_a_branch_that_leaves_the_span_are_explained():
    # From g = 2.5 measurements change branches again and again, and the upper one reaches W = 1.6.
    found = sf.fit(DUFFING(g=2.5, F=0.2, d=0.06), duffing_down(1), {"g": (0.1, 3.0)})
    assert found.converged
    assert found.used.all()
    assert found["g"].low < 0.9 < found["g"].high
    assert found["g"].value == pytest.approx(0.9, abs=0.1)


def coverage(start, bounds, seen, counts):
    """Fraction of the intervals that hold the truth, of fits to measurements with noise."""
    held = [
        item.low <= start.values[item.name] <= item.high
        for seed in range(counts)
        for item in sf.fit(start, seen(seed), bounds).estimates
    ]
    # Fewer than are expected of 95 % come in one of a thousand runs of such tests.
    assert binom.cdf(sum(held), len(held), 0.95) > 1e-3
    return float(np.mean(held))


@pytest.mark.long
def test_intervals_hold_the_truth_as_often_as_they_say_where_the_model_is_linear():
    start = LINEAR.replace(k=1.1, d=0.12)
    truth = amplitude(FREQUENCIES, 1.1, 0.12, LINEAR.F)

    def seen(seed):
        noise = np.random.default_rng(seed).standard_normal(len(FREQUENCIES)) * 0.01
        return measured(truth + noise)

    assert coverage(start, {"k": (0.5, 2.0), "d": (0.02, 0.5)}, seen, COUNT) < 0.985


@pytest.mark.long
def test_intervals_hold_the_truth_where_a_response_jumps():
    truth = DUFFING(d=0.06, g=0.9, F=0.2)
    assert coverage(truth, {"g": (0.1, 3.0)}, duffing_down, COUNT) < 0.985


@pytest.mark.long
def test_intervals_hold_the_truth_of_friction_and_damping():
    truth = sf.SlidingOscillator(Nd=0.03, mu=0.46, zeta1=0.012)
    values = np.linspace(12.1, 12.9, 7)
    exact = sf.measure(truth, "f", values, ["max y"])

    def seen(seed):
        noise = np.random.default_rng(seed).standard_normal(exact.measured.shape) * 2e-3
        errors = np.full(exact.measured.shape, 2e-3)
        return replace(exact, measured=exact.measured + noise, errors=errors)

    assert coverage(truth, {"mu": (0.3, 0.7), "zeta1": (0.002, 0.05)}, seen, COUNT) < 0.985


@pytest.mark.parametrize("rounds", [2, pytest.param(8, marks=pytest.mark.long)])
def test_an_interrupted_fit_keeps_the_best_values_so_far(noisy, fitted, rounds):
    seen = []

    def interrupt(progress):
        seen.append(progress.values["distance"])
        if len(seen) == rounds:
            raise KeyboardInterrupt

    found = sf.fit(LINEAR, noisy, {"k": (0.5, 2.0), "d": (0.02, 0.5)}, on_progress=interrupt)
    assert (len(seen), found.interrupted, found.converged) == (rounds, True, False)
    freedom = (len(noisy) - 2) / len(noisy)
    assert found.residual_std == pytest.approx(min(seen) / np.sqrt(freedom), rel=1e-9)
    assert np.isnan([[item.low, item.high] for item in found.estimates]).all()
    assert "Interrupted: these are the best values so far" in found.summary()
    assert not fitted.interrupted


def test_equal_measurements_that_a_model_meets_are_not_said_to_be_far_from_it():
    reach = amplitude(1.0, 1.1, LINEAR.d, LINEAR.F)
    seen = measured([reach] * 3, values=np.full(3, 1.0))
    found = sf.fit(LINEAR, seen, {"k": (1.05, 2.0)}, k=1.2)
    assert found["k"].value == pytest.approx(1.1, rel=1e-9)
    assert found.message == ""


def test_an_interrupted_branch_is_not_taken_for_a_whole_one(monkeypatch):
    whole = stable_orbits.trace_response

    def interrupted(model, vary, span, **options):
        def stop(progress):
            raise KeyboardInterrupt

        return whole(model, vary, span, observer=stop, **options)

    monkeypatch.setattr(stable_orbits, "trace_response", interrupted)
    with pytest.raises(KeyboardInterrupt):
        sf.plan_measurement(LINEAR, "W", FREQUENCIES, ["max q"], ["k"], errors=0.01)


@pytest.fixture(scope="module")
def swept():
    """Measurements of Duffing's oscillator in both directions, across both of its folds."""
    values = np.linspace(0.9, 1.35, 7)
    return sf.measure(DUFFING(d=0.06, F=0.2), "W", values, ["max q"], sweep="both")


def test_both_sides_of_a_fold_are_explained(swept):
    up, down = (swept.select([way == each for each in swept.sweep]) for way in ("up", "down"))
    apart = np.abs(up.measured - down.measured[::-1])[:, 0]
    assert (apart > 0.3).any()  # hysteresis
    found = sf.fit(DUFFING(), swept, {"d": (0.02, 0.2), "F": (0.05, 0.5)})
    assert found.converged
    assert found.used.all()
    assert found["d"].value == pytest.approx(0.06, abs=1e-7)
    assert found["F"].value == pytest.approx(0.2, abs=1e-7)


def test_a_reading_that_nothing_explains_is_left_out_and_reported(swept):
    measurements = swept.measured.copy()
    measurements[3] += 1.0
    found = sf.fit(DUFFING(), replace(swept, measured=measurements), {"d": (0.02, 0.2)}, F=0.2)
    assert np.flatnonzero(~found.used).tolist() == [3]
    assert "1 of 14 rows are left out: row 4 (W = 1.125 rad/s: the nearest stable response is" in (
        found.message
    )
    assert "typical distances away" in found.message
    assert found["d"].value == pytest.approx(0.06, abs=1e-7)


@pytest.mark.long
def test_friction_and_damping_from_a_frequency_response_of_the_sliding_oscillator():
    truth = sf.SlidingOscillator(Nd=0.03, mu=0.46, zeta1=0.012)
    seen = sf.measure(truth, "f", np.linspace(12.1, 12.9, 7), ["max y"], errors=1e-4, seed=3)
    start = truth.replace(mu=0.5, zeta1=0.02)
    found = sf.fit(start, seen, {"mu": (0.3, 0.7), "zeta1": (0.002, 0.05)})
    for name, value in {"mu": 0.46, "zeta1": 0.012}.items():
        assert abs(found[name].value - value) < 4 * found[name].error
        assert found[name].error < 0.01 * value


@pytest.mark.parametrize(
    ("bounds", "words"),
    [
        ({}, "no parameter is fitted"),
        ({"W": (0.5, 2.0)}, "W was varied in the measurement"),
        ({"q": (0, 1)}, "duffing has no parameter 'q'"),
        ({"k": (2, 1)}, "range of k from 2 to 1 is empty"),
        ({"k": (2, 3)}, "k = 1 is outside the range from 2 to 3"),
        ({"k": 2}, "is not a pair of numbers"),
    ],
)
def test_bounds_that_cannot_be_used(noisy, bounds, words):
    with pytest.raises(sf.InputError, match=words):
        sf.fit(LINEAR, noisy, bounds)


def test_too_few_readings_and_other_things_that_are_none(noisy):
    bounds = {"k": (0.5, 2), "d": (0.02, 0.5)}
    with pytest.raises(sf.InputError, match="2 measurements are too few for 2 parameters"):
        sf.fit(LINEAR, noisy.select(slice(2)), bounds)
    three = replace(noisy.select(slice(3)), measured=noisy.measured[:3] * [[1], [100], [1]])
    with pytest.raises(sf.InputError, match="explain 2 of 3 measurements, too few for 2 param"):
        sf.fit(LINEAR, three, bounds)
    with pytest.raises(sf.InputError, match="is not a measurement"):
        sf.fit(LINEAR, [1, 2], bounds)
    errors = noisy.errors.copy()
    errors[2] = np.nan
    with pytest.raises(sf.InputError, match="11 of 12 measurements have an error"):
        sf.fit(LINEAR, replace(noisy, errors=errors), bounds)


def test_measurements_in_another_unit_are_farther_from_the_model_than_from_their_mean():
    found = sf.fit(
        LINEAR, measured(10 * amplitude(FREQUENCIES, 1.1, 0.12, LINEAR.F)), {"k": (1, 2)}
    )
    assert "lie farther from the model than from their own means; check their units" in (
        found.message
    )


def test_a_round_that_explains_less_is_not_the_result(monkeypatch):
    given = [SimpleNamespace(scale=1.0, cost=lambda scale, cost=cost: cost) for cost in (2, 1, 5)]
    start, *rounds = given
    found = iter(rounds)
    held = SimpleNamespace(model=None, measured=SimpleNamespace(explained=lambda *_: next(found)))
    monkeypatch.setattr(least_squares, "closest", lambda *_: held)
    assert least_squares.best_of_rounds(start, ()) == (rounds[0], 1.0, True)
