"""Pendulums that turn round: states that are angles.

Driven: phi'' + phi'/q + sin phi = g cos(W t) (Baker and Gollub, Chaotic Dynamics, Cambridge 1996,
chapter 3: at q = 2, W = 2/3 it turns once a period, at g = 1.45 it has doubled, at 1.47 twice).
Under torque: phi'' + c phi' + sin phi = I, a shunted Josephson junction (Strogatz, Nonlinear
Dynamics and Chaos, sections 4.6 and 8.5). Other methods: SciPy's Radau and DOP853, quadrature.
"""

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp

from slipfold import (
    InputError,
    Settings,
    System,
    periodic_orbit,
    response,
    simulate,
)
from slipfold.plots import draw_phase, draw_timeseries

ROTATING = {"phi": -0.048, "w": 0.763}


def driven(g=1.35):
    return System(
        name="driven pendulum",
        parameters={"g": 1.35, "q": 2, "W": 2 / 3},
        states={
            "phi": {"rate": "w", "angle": True, "unit": "rad"},
            "w": "-w/q - sin(phi) + g*cos(W*t)",
        },
        forcing={"period": "2*pi/W"},
    ).replace(g=g)


def junction(current, damping=0.5):
    return System(
        name="junction",
        parameters={"I": 1.2, "c": 0.5},
        states={"phi": {"rate": "w", "angle": True, "unit": "rad"}, "w": "I - c*w - sin(phi)"},
    ).replace(I=current, c=damping)


def overdamped():
    return System(
        name="overdamped junction",
        parameters={"I": 1.5},
        states={"phi": {"rate": "I - sin(phi)", "angle": True}},
    )


def after(orbit, method="Radau", tolerance=1e-11):
    """The state after the orbit's time by SciPy, and the multipliers."""
    p = orbit.model.values

    def rates(t, y):
        (phi, w), around = y[:2], y[2:].reshape(2, 2)
        if orbit.model.forced:
            pull = -w / p["q"] - np.sin(phi) + p["g"] * np.cos(p["W"] * t)
        else:
            pull = p["I"] - p["c"] * w - np.sin(phi)
        damping = 1 / p["q"] if orbit.model.forced else p["c"]
        slopes = np.array([[0, 1], [-np.cos(phi), -damping]])
        return np.concatenate([[w, pull], (slopes @ around).ravel()])

    start = np.concatenate([orbit.state, [1, 0, 0, 1]])
    span = (0, orbit.duration)
    y = solve_ivp(rates, span, start, method=method, rtol=tolerance, atol=tolerance).y[:, -1]
    return y[:2], np.linalg.eigvals(y[2:].reshape(2, 2))


def test_a_driven_pendulum_turns_round_once_in_each_period():
    motion = simulate(driven(), 300, ROTATING)
    assert motion.settlement.period == 1
    assert motion.settlement.revolutions == {"phi": -1}
    assert "phi makes 1 revolution, backwards" in motion.settlement.message
    assert motion.checked.disagreeing == ()
    assert np.abs(motion.states[1:, 0]).max() <= np.pi
    orbit = periodic_orbit(driven(), state=motion.states[-1])
    assert orbit.revolutions == {"phi": -1}
    end, multipliers = after(orbit)
    assert end - orbit.state == pytest.approx([-2 * np.pi, 0], abs=1e-9)
    assert sorted(abs(multipliers)) == pytest.approx(sorted(abs(orbit.multipliers)), abs=1e-9)
    assert orbit.check().passed
    states = orbit.sample(256)[1]
    assert np.abs(np.diff(states[:, 0])).max() < 0.3  # nowhere a jump
    assert orbit.extrema.of("phi") == (-np.pi, np.pi)
    assert motion.spectrum(8).line("phi", 1) == pytest.approx(
        motion.spectrum(8).line("w", 1) / (2 / 3), rel=1e-9
    )


@pytest.mark.parametrize("method", ["automatic", "collocation"])
def test_rotations_double_where_scipy_says(method):
    settings = Settings(discretization=method, largest_period=2)
    diagram = response(driven(), vary="g", span=(1.35, 1.465), start=ROTATING, settings=settings)
    first, second = diagram.branches
    (point,), (doubled,) = first.special, second.special
    assert (point.type, doubled.type) == ("PD", "PD")
    assert (first.revolutions, second.revolutions) == ({"phi": -1}, {"phi": -2})
    for branch in (first, second):
        assert branch.orbit(1).revolutions == branch.orbit(-1).revolutions == branch.revolutions
    assert diagram.checked.disagreeing == ()
    for found in (point, doubled):
        end, multipliers = after(found.orbit, "DOP853", 1e-12)
        assert end - found.state == pytest.approx([-2 * np.pi * found.period, 0], abs=2e-9)
        assert np.abs(multipliers + 1).min() < 1e-8
    # Baker and Gollub's figures: one turn at 1.35, two doublings before 1.47
    assert 1.35 < point.value < 1.45 < doubled.value < 1.47


def test_lines_break_where_a_turn_begins_anew():
    motion = simulate(driven(), 300, ROTATING)
    for ax in (
        draw_timeseries(motion, "phi", Figure().add_subplot(), start=290),
        draw_phase(motion, "w", "phi", Figure().add_subplot(), periods=5),
        draw_phase(periodic_orbit(driven(), state=ROTATING), "w", "phi", Figure().add_subplot()),
    ):
        angle = np.asarray(ax.get_lines()[0].get_ydata(), dtype=float)
        steps = np.abs(np.diff(angle))
        assert np.isnan(angle).any()
        assert np.nanmax(steps) < 1
        assert ax.get_ylabel() == "phi (°)"


def test_equilibria_are_the_same_after_a_turn():
    pulled = System(
        name="pulled",
        parameters={"M": 0.5},
        states={"phi": {"rate": "w", "angle": True}, "w": "M*cos(phi) - w - sin(phi)"},
    )
    diagram = response(pulled, vary="M", span=(-200, 200))
    assert np.abs(diagram.branches[0].states[:, 0]).max() < 2 * np.pi
    assert diagram.branches[0].revolutions == {"phi": 0}


def test_an_overdamped_junction_runs_as_long_as_known():
    """The time of a turn is 2 pi/sqrt(I^2 - 1): it has no bound where equilibria appear."""
    model = overdamped()
    assert simulate(model).settlement.revolutions == {"phi": 1}
    cycle = periodic_orbit(model)
    assert cycle.duration == pytest.approx(2 * np.pi / np.sqrt(1.25), rel=1e-12)
    assert cycle.multipliers.tolist() == [1]
    assert cycle.check().passed
    for method in ("automatic", "collocation"):
        settings = Settings(discretization=method)
        diagram = response(model, vary="I", span=(1.5, 0.5), settled=True, settings=settings)
        (branch,) = diagram.branches
        exact = 2 * np.pi / np.sqrt(branch.parameter**2 - 1)
        assert branch.durations == pytest.approx(exact, rel=1e-8)
        assert branch.durations[-1] > 20 * branch.durations[0]
        assert branch.stopped.value > 1
        assert "saddle-node" in branch.stopped.reason
        assert branch.special == ()


def test_angles_are_declared_in_files():
    model = driven()
    again = System.from_toml(model.to_toml())
    assert [state.angle for state in again.states] == [True, False]
    assert again == driven()
    with pytest.raises(InputError, match="angle is a number; give true or false"):
        System(name="x", states={"x": {"rate": "-x", "angle": 3}})


@pytest.mark.parametrize("pull", ["-phi", "sin(1.5*phi)", "0.01*phi*cos(phi)"])
def test_what_is_no_angle_is_refused(pull):
    states = {"phi": {"rate": "w", "angle": True}, "w": f"{pull} - w"}
    with pytest.raises(InputError, match="phi is declared an angle, but the rate of w is another"):
        System(name="x", states=states)


def test_whether_it_is_an_angle_may_depend_on_a_parameter():
    states = {"phi": {"rate": "w", "angle": True}, "w": "-sin(n*phi) - w"}
    model = System(name="x", parameters={"n": 2}, states=states)
    with pytest.raises(InputError, match=r"after a revolution, phi \+ 2\*pi at n = 2\.5"):
        model.replace(n=2.5)
