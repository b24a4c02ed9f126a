"""Lyapunov exponents against multipliers, closed forms, published and independent values."""

from fractions import Fraction

import numpy as np
import pytest
from scipy.special import ellipk

import slipfold as sf
from slipfold.flow.flow import flow_of
from slipfold.flow.settlement import Settlement
from slipfold.long_term.exponents import average, classify, rotation_of

MODELS = sf.built_in_models()

LONG = pytest.mark.long


def rates_of(orbit):
    """Return logarithms of the multipliers, the largest first, a forcing period each."""
    with np.errstate(divide="ignore"):  # what stick takes may be exactly zero
        found = np.log(np.abs(orbit.multipliers)) / orbit.period
    return np.sort(found)[::-1]


# -- periodic motions ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("model", "periods"),
    [
        pytest.param(sf.SlidingOscillator(f=12.5, Nd=0.02), 1, id="spirals in", marks=LONG),
        pytest.param(sf.SlidingOscillator(f=12.2, Nd=0.15), 2, id="period 2"),
        pytest.param(MODELS["duffing"](W=0.7), 1, id="duffing"),
    ],
)
def test_on_periodic_orbits_they_are_the_logarithms_of_multipliers(model, periods):
    found = sf.lyapunov(model)
    assert (found.classification.kind, found.classification.period) == ("periodic", periods)
    orbit = sf.periodic_orbit(model, state=found.state, period=periods)
    assert found.exponents == pytest.approx(rates_of(orbit), abs=1e-8)
    assert found.dimension == 0


@LONG
def test_what_decays_to_rounding_within_a_period_is_not_waited_for():
    # Its exponent is -1000 a second, of which no digits are left: that is stated.
    fast = "1000*(1 + cos(W*t))*(x - z)"
    states = {"x": "v", "v": "-0.8*v - x + cos(W*t)", "z": fast}
    model = sf.System(parameters={"W": 1.3}, states=states, forcing={"period": "2*pi/W"})
    found = sf.lyapunov(model)
    assert found.periods <= 2000
    assert found.exponents[:2] == pytest.approx([-0.4 * 2 * np.pi / 1.3] * 2, abs=1e-7)
    assert found.exponents[2] < -1000
    assert np.isinf(found.errors[2])
    assert found.errors[:2].max() < 1e-7
    assert found.dimension == 0


def test_of_a_cycle_one_is_zero_and_the_others_are_those_of_its_multipliers():
    found = sf.lyapunov(MODELS["vanderpol-free"](), tolerance=1e-7)
    assert found.per == "s"
    # As in tests of autonomous motions, by DOP853.
    assert found.classification.duration == pytest.approx(6.663286859323, abs=1e-8)
    assert found.exponents[0] == pytest.approx(0, abs=1e-7)
    assert found.dimension == 1


def test_through_stick_they_are_those_of_the_orbit_and_stick_takes_the_rest():
    model = sf.SlidingOscillator(f=12.5, Nd=0.3, Vd=0.05)
    found = sf.lyapunov(model, periods=100)
    assert found.classification.kind == "periodic"
    orbit = rates_of(sf.periodic_orbit(model))
    assert found.exponents[:2] == pytest.approx(orbit[:2], abs=1e-3)
    assert np.all(np.isneginf(found.exponents[2:]))
    assert "perturbations in 2 of 4 directions in finite time" in found.classification.message
    assert np.all(orbit[2:] < -30)


# -- tori and chaos ------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def torus():
    return sf.lyapunov(sf.SlidingOscillator(f=12.5, Nd=0.06), periods=16_000)


def test_a_torus_of_the_sliding_oscillator(torus):
    # shared/reference/beyond.md.
    assert torus.exponents == pytest.approx([0, -0.0050116, -0.1170780, -0.2697660], abs=1e-7)
    assert torus.errors.max() <= 1e-5
    assert torus.classification.kind == "torus"
    assert torus.dimension == 1  # of its points at phase zero


def test_their_sum_is_the_mean_divergence(torus):
    found, model = torus, torus.model
    flow, constants = flow_of(model), flow_of(model).constants_of(model)
    states = sf.simulate(model, 4000, found.state).sample(per_period=64)[1]
    phases = np.arange(len(states)) % 64 / 64
    slopes = flow.jacobians(states, phases, constants)
    mean = average(np.trace(slopes, axis1=1, axis2=2)[:, None]).values[0]
    assert found.exponents.sum() == pytest.approx(mean, abs=1e-8)


def test_chaos_of_the_sliding_oscillator():
    found = sf.lyapunov(sf.SlidingOscillator(f=12.5, Nd=0.12), periods=8000)
    assert found.classification.kind == "chaos"
    # shared/reference/beyond.md, to 3e-4.
    apart = np.abs(found.exponents - [0.0295, -0.0076, -0.0455, -0.3695])
    assert np.all(apart <= 3 * found.errors + 3e-4)


DIGIT = 5e-5
"""Half of the last digit of the values that are published."""


@pytest.mark.parametrize(
    ("model", "largest", "total", "within", "periods"),
    [
        # Sprott, Chaos and Time-Series Analysis (2003), appendix A.
        pytest.param("lorenz", 0.9056, -41 / 3, 0.01, 4000, id="Lorenz"),
        pytest.param("lorenz", 0.9056, -41 / 3, 0.01, 64_000, id="Lorenz, long", marks=LONG),
        pytest.param("roessler", 0.0714, None, 0.004, 4000, id="Roessler", marks=LONG),
        pytest.param("roessler", 0.0714, None, 0.004, 64_000, id="Roessler, long", marks=LONG),
    ],
)
def test_published_values(model, largest, total, within, periods):
    found = sf.lyapunov(MODELS[model](), periods=periods)
    assert found.classification.kind == "chaos"
    apart = abs(found.exponents[0] - largest)
    assert apart <= min(within, 3 * found.errors[0] + DIGIT)
    assert found.exponents[1] == pytest.approx(0, abs=1e-3)
    if total is not None:
        assert found.exponents.sum() == pytest.approx(total, abs=1e-8)


def test_strong_decay_keeps_its_digits():
    text = """
    parameters = { W = 0.7 }
    forcing = { period = "2*pi/W" }
    [states]
    x = "v"
    v = "-x - 0.1*v + cos(W*t)"
    w = "-40*w + x"
    """
    found = sf.lyapunov(sf.System.from_toml(text), periods=1000)
    assert found.exponents == pytest.approx(
        2 * np.pi / 0.7 * np.array([-0.05, -0.05, -40]), rel=1e-9
    )


# -- classes --------------------------------------------------------------------------------------

UNSETTLED = Settlement(False, None, 1e-3, None, "not settled")


@pytest.mark.parametrize(
    ("exponents", "error", "seconds", "kind"),
    [
        ([0.1, -0.2], 1e-3, None, "chaos"),
        ([1e-9, -0.2], 1e-8, None, "torus"),
        ([1e-3, -0.2], 1e-3, None, "undecided"),
        ([-0.1, -0.2], 1e-8, None, "periodic"),
        ([1e-9, -0.2, -0.3], 1e-8, 0.5, "periodic"),
        ([1e-9, -1e-9], 1e-8, 0.5, "periodic"),  # no torus lies in the plane
        ([-0.1, -0.2, -0.3], 1e-8, 0.5, "equilibrium"),
        ([0.1, 1e-7, -0.3], 1e-5, 0.5, "chaos"),
        ([1e-9, -0.2, -99.0], [1e-8, 1e-8, np.inf], None, "torus"),  # the last decays to rounding
    ],
)
def test_classes_follow_from_exponents(exponents, error, seconds, kind):
    errors = np.broadcast_to(error, len(exponents))
    angles = np.zeros(len(exponents))
    assert classify(np.array(exponents), errors, UNSETTLED, seconds, angles).kind == kind


FREE = {"x": {"rate": "y", "start": 1.0}, "y": "-x", "a": {"rate": "1.618 + 0.1*x", "angle": True}}
THREE = ("1 + 0.1*sin(b-a)", "1.618 + 0.1*sin(c-b)", "2.9 + 0.1*sin(a-c)")


def angles(*rates):
    return {name: {"rate": r, "angle": True} for name, r in zip("abc", rates, strict=False)}


@pytest.mark.parametrize(
    ("states", "number"),
    [
        pytest.param(FREE, "2", id="two, and an amplitude", marks=LONG),
        pytest.param(FREE | {"w": "x - 2*w"}, "at most 3", id="and one that decays"),
        pytest.param(angles("1 + 0.1*sin(b-a)", "1.618 + 0.1*sin(a-b)"), "2", marks=LONG),
        pytest.param(angles(*THREE), "at most 3", id="three angles", marks=LONG),
    ],
)
def test_zero_exponents_and_dimensions_limit_the_number_of_frequencies(states, number):
    found = sf.lyapunov(sf.System(states=states), periods=4000).classification
    assert found.message == f"quasi-periodic, on a torus of {number} frequencies"


def test_undamped_motion_beside_a_state_that_decays_is_periodic():
    # Its frequency depends on the amplitude: two exponents are zero, as on a torus.
    states = {"x": {"rate": "y", "start": 1.0}, "y": "-x - x^3", "w": "y - w"}
    found = sf.lyapunov(sf.System(states=states), periods=250).classification
    assert found.kind == "periodic"  # v^2 = cos(s)^2 (3 + sin(s)^2) / 2 where x = sin(s)
    assert found.duration == pytest.approx(4 * np.sqrt(2 / 3) * ellipk(-1 / 3), rel=1e-9)


@pytest.mark.parametrize("periods", [400, 1600])
def test_linear_growth_between_tori_is_not_chaos(periods):
    # The logarithm of the growth is that of the time, as the frequency depends on the amplitude.
    found = sf.lyapunov(MODELS["duffing"](d=0, F=0), periods, {"q": 0.5})
    assert found.exponents[0] > 0.5 / periods
    assert found.errors[0] > 0.5 * found.exponents[0]
    assert found.classification.kind != "chaos"


# -- interruption ---------------------------------------------------------------------------------


def test_an_interrupted_one_keeps_what_it_knows():
    def interrupt(progress):
        if progress.done >= 1000:
            raise KeyboardInterrupt

    found = sf.lyapunov(sf.SlidingOscillator(f=12.5, Nd=0.12), on_progress=interrupt)
    assert (found.interrupted, found.periods) == (True, 1000)
    assert "Interrupted before its exponents were known" in found.summary()


def test_what_is_interrupted_before_its_rotation_number_keeps_its_exponents(monkeypatch):
    def interrupted(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr("slipfold.long_term.exponents.rotation_of", interrupted)
    found = sf.lyapunov(sf.SlidingOscillator(f=12.5, Nd=0.06), 500)
    assert (found.interrupted, found.periods, found.classification.rotation) == (True, 500, None)


def test_rotation_numbers_of_tori_are_those_of_closed_forms():
    # A curve turned by the golden mean, and two curves visited in turn, each turned by 0.13.
    count = np.arange(6000)
    golden = 2 * np.pi * (np.sqrt(5) - 1) / 2 * count
    states = np.stack([np.cos(golden) + 0.3 * np.cos(2 * golden + 1), np.sin(golden)], axis=1)
    found = rotation_of(states, np.ones(2), np.zeros(2))
    assert found.number == pytest.approx((3 - np.sqrt(5)) / 2, abs=1e-9)
    assert (found.period, found.resonance) == (1, None)
    turned = np.pi * 0.13 * count
    other = np.cos(turned) + (-1.0) ** count * (2 + 0.1 * np.cos(turned))
    found = rotation_of(np.stack([other, np.sin(turned)], axis=1), np.ones(2), np.zeros(2))
    assert found.number == pytest.approx(0.13, abs=1e-9)
    assert found.period == 2
    near = 2 * np.pi * (2 / 7 + 1e-5) * count
    found = rotation_of(np.stack([np.cos(near), np.sin(near)], axis=1), np.ones(2), np.zeros(2))
    assert found.resonance == Fraction(2, 7)
    assert found.beat == pytest.approx(1 / 7e-5, rel=1e-3)
    noise = np.random.default_rng(0).normal(size=(4000, 2))
    assert rotation_of(noise, np.ones(2), np.zeros(2)) is None


@pytest.mark.parametrize("periods", [1, 2])
def test_one_period_decides_nothing_and_shows_no_rotation(periods):
    found = sf.lyapunov(MODELS["duffing"](), periods=periods)
    assert (found.classification.kind, found.classification.rotation) == ("undecided", None)
    for count in range(9):
        turned = np.cos(np.arange(count))[:, None]
        assert rotation_of(turned, np.ones(1), np.zeros(1)) is None


@pytest.mark.parametrize(("beat", "off"), [(25_000, 3e-4), (8000, 3e-4), (130, 1e-6)])
@pytest.mark.parametrize(("p", "q"), [(3, 8), (1, 2), (2, 5)])
def test_the_error_of_a_rotation_number_holds_near_a_resonance(beat, off, p, q):
    # Adler's equation s' = a - b sin(s) in closed form, with a mean of 2 pi/beat: beyond 3/8 of a
    # turn a return the phase lingers for most of a beat.
    returns = np.arange(4000)
    mean, a = 2 * np.pi / beat, 1.5 * 2 * np.pi / beat
    tangent = (np.sqrt(a**2 - mean**2) + mean * np.tan(mean * returns / 2)) / a
    slow = 2 * np.unwrap(np.arctan(tangent), period=np.pi)
    angle = 2 * np.pi * p / q * returns + slow / q
    states = np.stack([np.cos(angle) + 0.2 * np.sin(2 * angle), np.sin(angle)], axis=1)
    found = rotation_of(states, np.ones(2), np.zeros(2))
    if found is None:
        assert beat > len(returns)
        return
    exact = ((p + 1 / beat) / q * found.period + 0.5) % 1 - 0.5
    assert abs(found.number - abs(exact)) <= found.error + 1e-13
    assert found.error < off


@pytest.mark.long
def test_a_torus_near_a_resonance_is_followed_until_it_is_known():
    # After 32,000 periods its exponent is known to 9e-4 only: beats last thousands of periods.
    found = sf.lyapunov(sf.SlidingOscillator(), f=12.5, Nd=0.08)
    assert found.classification.kind == "torus"
    assert found.periods > 32_000
    assert found.classification.resonance == "83/168"
