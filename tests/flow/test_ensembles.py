"""Many motions at once are those that each would be by itself."""

import numpy as np
import pytest

import slipfold as sf
from helpers.toy_models import FLOOR
from slipfold.flow.ensembles import stroboscopic_samples
from slipfold.flow.simulate import simulate

OSCILLATOR = sf.SlidingOscillator(f=12.5)
UNITS = np.array([1.0, 1.0, 64.0, 64.0])


def steep(**values):
    return sf.System(
        name="switching",
        parameters={"W": 0.8, "F": 1.0, "e": {"value": 1e-3, "min": 0}},
        states={"x": "v", "v": "F*cos(W*t) - x - 0.5*tanh(v/e)"},
        forcing={"period": "2*pi/W"},
    ).replace(**values)


def test_each_has_its_own_start_and_parameters():
    rng = np.random.default_rng(3)
    starts = np.zeros((40, 4))
    starts[:, 1] = rng.uniform(-0.3, 0.3, 40)
    values = {"Nd": rng.uniform(0.0, 0.05, 40), "f": rng.uniform(11, 13, 40)}
    points = stroboscopic_samples(OSCILLATOR, starts, values, 30)
    assert points.states.shape == (40, 31, 4)
    for row in (0, 7, 39):
        model = OSCILLATOR.replace(**{name: float(column[row]) for name, column in values.items()})
        alone = simulate(model, 30, starts[row]).states
        assert points.states[row] / UNITS == pytest.approx(alone / UNITS, abs=2e-9)


@pytest.mark.parametrize(
    ("values", "sticks"), [({"Nd": 0.3, "Vd": 0.05}, True), ({"Nd": 0.6, "Vd": 0.1}, False)]
)
def test_motions_go_on_through_stick(values, sticks):
    model = OSCILLATOR.replace(**values)
    exact = simulate(model, 20)
    points = stroboscopic_samples(model, np.zeros((2, 4)), None, 20)
    assert points.stopped == (None, None)
    assert points.states[1] / UNITS == pytest.approx(exact.states / UNITS, abs=1e-8)
    assert bool(points.stuck[1, -1]) is sticks


@pytest.mark.parametrize(("e", "x"), [(1e-3, 1.86016491), (1e-5, 1.86045068)])
def test_no_step_leads_past_a_sharp_turn(e, x):
    # Radau at 1e-10.
    points = stroboscopic_samples(steep(), np.zeros((2, 2)), {"e": [e, 0.05]}, 60)
    assert points.states[:, -1, 0] == pytest.approx([x, 1.84688889], abs=2e-8)


def test_a_narrow_hill_is_not_missed():
    w = 10.0 ** np.linspace(-6, 0, 7)
    turning = sf.System(
        name="turning",
        parameters={"w": {"value": 1.0, "min": 0}, "T": {"value": 1.0, "min": 0}},
        states={"x": "-2*pi*y", "y": "2*pi*x", "z": "1/(1 + (x/w)^2)"},
        forcing={"period": "T"},
    )
    points = stroboscopic_samples(turning, np.tile([1.0, 0.0, 0.0], (7, 1)), {"w": w}, 1)
    # Forty calls or more, of which each may be wrong by 1e-9.
    assert points.states[:, 1, 2] == pytest.approx(w / np.sqrt(1 + w**2), abs=4e-8)


def test_a_motion_that_meets_a_limit_stops_and_the_others_go_on():
    points = stroboscopic_samples(FLOOR, np.zeros((3, 2)), {"F": [1.0, 4.0, 1.0]}, 8)
    stops = [stop and stop.kind for stop in points.stopped]
    assert stops == [None, "floor", None]
    alone = simulate(FLOOR.replace(F=4.0), 8)
    assert points.stopped[1].time == pytest.approx(alone.stopped.time, rel=1e-9)
    whole = len(alone.states)
    assert np.isfinite(points.states[1, :whole]).all()
    assert np.isnan(points.states[1, whole:]).all()
    assert np.isfinite(points.states[[0, 2]]).all()


def test_angles_lose_whole_turns():
    wheel = sf.System(
        name="wheel",
        parameters={"w": 3.0},
        states={"a": {"rate": "w + 0.1*cos(t)", "angle": True}},
        forcing={"period": "2*pi"},
    )
    points = stroboscopic_samples(wheel, np.zeros((1, 1)), {"w": [3.25]}, 4)
    assert points.states[0, :, 0] == pytest.approx(np.pi * np.array([0, 0.5, 1, -0.5, 0]), abs=1e-8)


def test_an_interrupt_keeps_what_is_done():
    seen = []

    def stop(progress):
        seen.append((progress.done, progress.total))
        if progress.done == 6:
            raise KeyboardInterrupt

    points = stroboscopic_samples(OSCILLATOR, np.zeros((2, 4)), None, 9, stop)
    assert seen == [(2, 18), (4, 18), (6, 18)]
    assert points.interrupted
    assert np.isfinite(points.states[:, :3]).all()
    assert np.isnan(points.states[:, 4:]).all()
