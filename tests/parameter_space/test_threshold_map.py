"""Maps of thresholds: every point agrees with its own response, every failure has a name."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from helpers.textbook_models import Duffing, Mathieu, Torus
from slipfold import InputError, Settings, SlidingOscillator, threshold_map
from slipfold.bifurcations.branches.response import trace_response

ALONE = Settings(largest_period=1)

SPEEDS = np.linspace(0.4, 1.0, 13)
ANGLES = np.radians(np.linspace(30, 75, 10))

PUBLISHED = [
    (0.4, 60, 0.0573062376),
    (0.6, 60, 0.043578911491),
    (1.0, 60, 0.0342977605),
    (0.6, 30, 0.0986440104),
    (0.6, 75, 0.0293620845),
]


def sliding_map(speeds, angles, span=(0, 0.9), **values):
    over = {"Vd": speeds, "alpha": angles}
    return threshold_map(SlidingOscillator(**values), "Nd", over=over, span=span)


@pytest.fixture(scope="module")
def base():
    return sliding_map(SPEEDS, ANGLES)


def first_of(model, vary, span):
    """First bifurcation of the response and why the branch stopped, by following it."""
    branch = trace_response(model, vary, span, settings=ALONE)[0]
    return (branch.special[0] if branch.special else None), branch


# -- right values ------------------------------------------------------------------------------


@pytest.mark.parametrize(("speed", "angle", "expected"), PUBLISHED)
def test_known_thresholds(base, speed, angle, expected):
    i = np.abs(SPEEDS - speed).argmin()
    j = np.abs(ANGLES - math.radians(angle)).argmin()
    assert base.values[i, j] == pytest.approx(expected, abs=1e-10)


def test_agrees_with_responses_of_single_points(base):
    alone = np.argwhere(~base.followed)
    for i, j in np.random.default_rng(5).permutation(alone)[:12]:
        point, _ = first_of(base.model_at(i, j), "Nd", (0, 0.9))
        assert point.type == "PD"
        assert base.values[i, j] == pytest.approx(point.value, abs=1e-10)
        assert base.states[i, j] == pytest.approx(point.state, abs=1e-7)
        assert np.abs(base.multipliers[i, j] - point.multipliers).max() < 1e-6


def test_every_threshold_is_proved(base):
    assert base.failures == {}
    assert not base.followed.any()  # no point needed its whole response
    assert base.residuals.max() < 1e-10
    critical = np.abs(base.multipliers + 1).argmin(axis=2)[..., None]
    assert np.abs(np.take_along_axis(base.multipliers, critical, 2) + 1).max() < 1e-7
    others = np.abs(base.multipliers)
    np.put_along_axis(others, critical, 0, 2)
    assert others.max() < 1


def test_directions_mirrored_in_the_vertical_are_equal():
    angles = np.radians([60, 67, 74, 80, 85, 90, 95, 100, 106, 113, 120])
    found = sliding_map([0.5, 0.6, 0.8], angles)
    assert found.failures == {}
    assert found.values == pytest.approx(found.values[:, ::-1], abs=1e-11)
    assert not found.followed[1, 5]  # there x = 0 is invariant, and PD leaves it
    point, _ = first_of(SlidingOscillator(Vd=0.6, alpha=math.pi / 2), "Nd", (0, 0.9))
    assert found.values[1, 5] == pytest.approx(point.value, abs=1e-11)
    assert np.abs(found.states[:, 5, [0, 2]]).max() < 1e-9


def test_a_mathieu_equation_loses_stability_where_its_own_multiplier_says():
    over = {"w": np.linspace(1.8, 2.2, 9), "z": np.linspace(0.005, 0.05, 8)}
    found = threshold_map(Mathieu(), "h", over=over, span=(0, 1))
    assert found.failures == {}
    for i, j in [(1, 1), (3, 6), (4, 2), (7, 3)]:
        w, z, h = over["w"][i], over["z"][j], found.values[i, j]
        assert np.abs(hill_multipliers(w, z, h) + 1).min() < 1e-8
        assert np.abs(hill_multipliers(w, z, 0.99 * h)).max() < 1


def hill_multipliers(w, z, h):
    """Multipliers of x'' + 2 z x' + (1 + h cos(w t)) x = 0, integrated by SciPy."""
    columns = [
        solve_ivp(
            lambda t, x: [x[1], -2 * z * x[1] - (1 + h * math.cos(w * t)) * x[0]],
            (0, 2 * math.pi / w),
            start,
            "DOP853",
            rtol=1e-12,
            atol=1e-13,
        ).y[:, -1]
        for start in np.eye(2)
    ]
    return np.linalg.eigvals(np.array(columns).T)


# -- failures have names -----------------------------------------------------------------------


def test_thresholds_beyond_the_span_are_named():
    speeds, angles = np.linspace(0.3, 1.2, 11), np.radians(np.linspace(20, 80, 11))
    whole = sliding_map(speeds, angles)
    part = sliding_map(speeds, angles, span=(0, 0.08))
    beyond = whole.values > 0.08
    assert 20 < beyond.sum() < 101
    assert part.failures == {"no PD in the span": beyond.sum()}
    assert np.array_equal(np.isnan(part.values), beyond)
    assert part.values[~beyond] == pytest.approx(whole.values[~beyond], abs=1e-11)
    assert part.followed.sum() < 60  # the edge is not walked along point by point
    (reason,) = set(part.reasons[beyond])
    assert "stable up to the end of the span, Nd = 0.08" in reason


def test_limits_of_the_model_are_named():
    over = {"f": [8.8, 9.0], "Vd": [0.9, 1.0, 1.1]}
    found = threshold_map(SlidingOscillator(), "Nd", over=over, span=(0, 1.5))
    assert found.failures == {"limit: lost contact": 6}
    assert "lost contact" in found.reasons[0, 0]
    assert "Nd = 1;" in found.reasons[0, 0] or "Nd = 0.99" in found.reasons[0, 0]


def test_other_bifurcations_are_named():
    over = {"w": [1.3, 1.35], "d": [0.05, 0.06]}
    found = threshold_map(Duffing(), "a", over=over, span=(0, 2))
    assert found.failures == {"LP comes first": 4}
    point, _ = first_of(Duffing(w=1.35, d=0.06), "a", (0, 2))
    assert f"a = {point.value:.9g}" in found.reasons[1, 1]
    over = {"v": [1.0, 1.1], "n": [1.0]}
    found = threshold_map(Torus(), "m", over=over, span=(-0.5, 0.5))
    assert found.failures == {"NS comes first": 2}


def test_an_unstable_start_is_named():
    found = threshold_map(Torus(), "v", over={"m": [-0.1, 0.1], "n": [1.0, 2.0]}, span=(0.8, 1.2))
    assert found.kinds[1].tolist() == ["unstable at the start of the span"] * 2
    assert found.kinds[0].tolist() == ["no PD in the span"] * 2


def test_an_interrupted_map_says_what_is_missing():
    seen = []

    def watch(progress):
        seen.append(progress)
        if len(seen) == 3:
            raise KeyboardInterrupt

    over = {"Vd": SPEEDS, "alpha": ANGLES}
    found = threshold_map(SlidingOscillator(), "Nd", over=over, span=(0, 0.9), on_progress=watch)
    done = [progress.done for progress in seen]
    assert done == sorted(done)
    assert found.interrupted
    assert found.failures == {"interrupted": 130 - seen[-1].done}
    assert np.isfinite(found.values).sum() == seen[-1].done > 36
    assert repr(found).endswith(f"{seen[-1].done} thresholds, {130 - seen[-1].done} interrupted>")


# -- bad input ---------------------------------------------------------------------------------

GOOD = {"Vd": [0.5, 0.6], "alpha": [1.0, 1.1]}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"threshold": "nd"}, "did you mean Nd"),
        ({"over": {"Vd": [0.5], "alfa": [1.0]}}, "did you mean alpha"),
        ({"over": {"Vd": [0.5], "Nd": [0.1]}}, "Nd is the threshold that is sought"),
        ({"over": {"Vd": [0.5]}}, "does not name two parameters"),
        ({"over": [0.5, 0.6]}, "does not name two parameters"),
        ({"over": {"Vd": ["5mm"], "alpha": [1.0]}}, "Vd = '5mm' has the unit 'mm'"),
        ({"over": {**GOOD, "f": [12.0]}}, "does not name two parameters"),
        ({"over": {"Vd": [0.5, -1.0], "alpha": [1.0]}}, "Vd = -1 is outside its bounds"),
        ({"over": {"Vd": [0.5, math.nan], "alpha": [1.0]}}, "not a finite number"),
        ({"over": {"Vd": np.ones((1, 2)), "alpha": [1.0]}}, "is not a number; give a number"),
        ({"over": {"Vd": [], "alpha": [1.0]}}, "no value of Vd is given"),
        ({"over": {"Vd": [0.5, 0.6, 0.5], "alpha": [1.0]}}, "Vd = 0.5 occurs twice"),
        ({"span": (0.3, 0.3)}, "is empty; give two different values"),
        ({"span": (-0.1, 0.3)}, "Nd = -0.1 is outside its bounds"),
        ({"span": ("0", "90deg")}, "Nd = '90deg' has the unit 'deg'"),
        ({"span": 0.3}, "is not a pair of numbers"),
        ({"Vd": 0.7}, "Vd is varied, so it cannot be set to 0.7"),
        ({"Nd": 0.7}, "Nd is varied"),
        ({"model": "sliding"}, "is not a model"),
        ({"type": "NS"}, "type = 'NS' cannot be mapped; give 'PD'"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(changes, message):
    given = {"threshold": "Nd", "type": "PD", "over": GOOD, "span": (0, 0.9), **changes}
    with pytest.raises(InputError, match=message):
        threshold_map(given.pop("model", SlidingOscillator()), **given)
