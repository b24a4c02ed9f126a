"""Extrema over the continuous orbit: against dense sampling and closed forms."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf
from helpers.toy_models import LinearOscillator
from slipfold import Settings, SlidingOscillator, Steps, periodic_orbit
from slipfold.bifurcations.branches.response import trace_response
from slipfold.orbits.extrema import find_extrema

CASES = [
    ({"f": 12.5, "Nd": 0.05}, 1),
    ({"f": 12.5, "Nd": 0.2}, 1),
    ({"f": 12.2, "Nd": 0.15}, 2),
    ({"f": 7.0, "Nd": 0.9, "mu": 0.8}, 1),
]


@pytest.mark.parametrize(("values", "period"), CASES)
def test_against_dense_sampling(values, period):
    orbit = periodic_orbit(SlidingOscillator(**values), period)
    time, states = orbit.sample(100_000)
    extrema = orbit.extrema
    for column, name in enumerate(extrema.names):
        dense = orbit.model.evaluate(name, states, time)
        swing = np.ptp(dense)
        size = max(np.abs(dense).max(), 1e-300)
        low, high = extrema.minimum[0, column], extrema.maximum[0, column]
        # The true extremum lies beyond the samples by no more than a step's parabola.
        beyond = 1e-7 * swing + 1e-11 * size
        assert dense.min() - beyond <= low <= dense.min() + 1e-11 * size
        assert dense.max() - 1e-11 * size <= high <= dense.max() + beyond


def test_linear_response_in_closed_form():
    model = LinearOscillator(f=1.1, zeta=0.03)
    amplitude = abs(model.response_amplitude())
    speed = 2 * np.pi * model.f * amplitude
    extrema = periodic_orbit(model).extrema
    assert [item[0] for item in extrema.of("x")] == pytest.approx(
        [-amplitude, amplitude], rel=1e-11
    )
    assert [item[0] for item in extrema.of("v")] == pytest.approx([-speed, speed], rel=1e-11)
    assert extrema.peak_to_peak("x")[0] == pytest.approx(2 * amplitude, rel=1e-11)
    assert extrema.modulus("v")[0] == pytest.approx(speed, rel=1e-11)
    # With c cos and s sin of one frequency, the energy swings between the squares' halves.
    w0 = 2 * np.pi * model.f0
    energies = sorted([0.5 * speed**2, 0.5 * (w0 * amplitude) ** 2])
    assert [item[0] for item in extrema.of("energy")] == pytest.approx(energies, rel=1e-10)


# At both samples beside it the taller one is 0.9996, or 0.3.
@pytest.mark.parametrize(("tall", "height", "low"), [(0.3, 0.9998, 0.1), (0.0056, 0.6, 0.05)])
def test_a_peak_between_two_samples_is_not_taken_for_a_lower_one_on_a_sample(tall, height, low):
    tall = f"exp(-(sin(pi*(t - 61.5/256))/{tall})^2)"
    low = f"{height}*exp(-(sin(pi*(t - 185/256))/{low})^2)"
    model = sf.System(
        parameters={"a": 1.0},
        states={"x": "a*cos(2*pi*t) - x"},
        outputs={"peaks": f"{tall} + {low}"},
        forcing={"period": "1"},
    )
    # With so many nodes phases of samples are exact, and these two values are equal.
    found = find_extrema(model, model.vector[None], np.zeros((1, 256, 1)), 1, ["peaks"])
    assert found.maximum[0] == pytest.approx([1.0], abs=1e-9)


def test_the_speed_of_a_relaxation_is_known_at_its_sharp_peak():
    model = sf.built_in_models()["vanderpol-free"](mu=30)
    orbit = periodic_orbit(model)

    def rates(t, y):
        return [y[1], 30 * (1 - y[0] ** 2) * y[1] - y[0]]

    def turns(t, y):
        return rates(t, y)[1]

    given = {"events": turns, "method": "DOP853", "rtol": 1e-12, "atol": 1e-12}
    found = solve_ivp(rates, (0, orbit.duration), orbit.state, **given).y_events[0]
    fastest = np.abs(found[:, 1]).max()
    assert orbit.extrema.modulus("v") == pytest.approx([fastest], rel=1e-8)


def test_branches_and_orbits_agree():
    settings = Settings(steps=Steps(largest=0.2))
    for branch in trace_response(SlidingOscillator(f=12.5), "Nd", (0, 0.3), settings=settings):
        for index in (1, len(branch) // 2, len(branch) - 1):
            alone = branch.orbit(index).extrema
            assert alone.minimum[0] == pytest.approx(branch.extrema.minimum[index], abs=1e-13)
            assert alone.maximum[0] == pytest.approx(branch.extrema.maximum[index], abs=1e-13)


def test_sharp_minimum_of_the_spring_near_collapse():
    (main, _) = trace_response(SlidingOscillator(f=12.5), "Nd", (0, 0.98))
    orbit = main.orbit(len(main) - 2)
    low = orbit.extrema.of("l")[0][0]
    time, states = orbit.sample(400_000)
    dense = orbit.model.evaluate("l", states, time).min()
    assert low <= dense * (1 + 1e-9)
    assert low == pytest.approx(dense, abs=1e-6)


def test_of_maxima_nearly_as_high_the_highest_counts():
    # x is exactly the sum whose derivative is its first term: seven maxima, 1e-4 apart, of which
    # samples miss up to 7e-3.
    wave = "sin(7*t + p)*(1 + 3e-4*cos(t))"
    slope = "7*cos(7*t + p)*(1 + 3e-4*cos(t)) - 3e-4*sin(7*t + p)*sin(t)"
    model = sf.System(
        name="maxima",
        parameters={"p": 0.0, "a": 1.0, "T": {"value": 2 * np.pi, "above": 0}},
        states={"x": f"a*({slope}) - (x - a*{wave})"},
        forcing={"period": "T", "amplitude": "a"},
    )
    shifts, times = np.linspace(0, 2 * np.pi, 24), np.linspace(0, 2 * np.pi, 100_001)

    def exact(t):
        return np.sin(7 * t + shifts[:, None]) * (1 + 3e-4 * np.cos(t))

    parameters = np.array([model.replace(p=p).vector for p in shifts])
    nodes = exact(np.arange(8) * np.pi / 4)[:, :, None]
    found = find_extrema(model, parameters, nodes, 1, ["x"])
    np.testing.assert_allclose(found.maximum[:, 0], exact(times).max(axis=1), rtol=1e-7)
    np.testing.assert_allclose(found.minimum[:, 0], exact(times).min(axis=1), rtol=1e-7)


@pytest.mark.parametrize("width", [1e-4, 1e-8])
def test_a_spike_much_shorter_than_the_distance_of_samples_is_seen_where_they_jump(width):
    ratio = f"(sin(2*pi*(t - 0.1234))/{width})"
    model = sf.System(
        parameters={"a": 1.0},
        states={"x": "a*cos(2*pi*t) - x"},
        outputs={"y": f"atan{ratio} + 10/(1 + {ratio}^2)"},
        forcing={"period": "1"},
    )
    highest = np.arctan(10 - np.sqrt(99)) + 1 / (20 - 2 * np.sqrt(99))
    assert sf.periodic_orbit(model).extrema.of("y")[1] == pytest.approx([highest], abs=1e-9)


def test_rounding_errors_of_outputs_that_are_constant_hide_no_peak():
    model = sf.System(
        parameters={"r": 0.5},
        states={"x": "r*x - 2*y - x*(x^2 + y^2)", "y": "2*x + r*y - y*(x^2 + y^2)"},
        outputs={"radius": "sqrt(x^2 + y^2)", "nothing": "((x + y)^2 - x^2 - y^2) - 2*x*y"},
    )
    found = sf.periodic_orbit(model).extrema  # closer looks at each took all memory
    assert np.ravel(found.of("radius")) == pytest.approx(np.sqrt([0.5, 0.5]), rel=1e-9)
    assert np.ravel(found.of("nothing")) == pytest.approx([0.0, 0.0], abs=1e-14)


def test_the_end_of_a_closer_look_is_no_new_extremum():
    # The maximum is two samples behind the jump, where the pieces around the jump end.
    jump = "tanh(sin(2*pi*(t - c))/1e-4)"
    model = sf.System(
        parameters={"a": 1.0, "c": 0.1},
        states={"x": "a*cos(2*pi*t) - x"},
        outputs={"y": f"{jump} + 0.3*exp(-(sin(pi*(t - c - 0.0105))/0.02)^2)"},
        forcing={"period": "1"},
    )
    parameters = np.array([model.replace(c=c).vector for c in np.linspace(0.1, 0.3, 100)])
    found = find_extrema(model, parameters, np.zeros((100, 1, 1)), 1, ["y"])
    assert found.maximum == pytest.approx(1.3, abs=1e-12)


@pytest.mark.parametrize("slope", [0.0, 0.1])
def test_no_polynomial_goes_through_a_jump_nor_is_it_examined_below_the_digits_of_a_phase(slope):
    sine = "sin(2*pi*(t - 0.1234))"
    model = sf.System(
        parameters={"a": 1.0},
        states={"x": "a*cos(2*pi*t) - x"},
        outputs={"side": f"tanh({sine}/1e-20) - {slope}*{sine}"},
        forcing={"period": "1"},
    )
    found = sf.periodic_orbit(model).extrema.of("side")
    assert np.ravel(found) == pytest.approx([-1.0, 1.0], abs=1e-12)


def test_an_output_that_is_infinite_has_no_extremum():
    creeping = sf.SlidingOscillator(sf.Regularized(sf.Coulomb(mu_k=0.3), e=0.01))
    branch = sf.response(creeping, "Vd", (0.02, 0)).branches[0]
    _, ratio = branch.extrema.of("Vrel_ratio")  # to the speed of the plate, which ends at zero
    assert ratio == pytest.approx([1] * (len(ratio) - 1) + [np.nan], nan_ok=True)
