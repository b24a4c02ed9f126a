"""Sweeps show hysteresis where branches have it, and dots lie on the branches."""

import numpy as np
import pytest

import slipfold as sf
from helpers.dry_friction import den_hartog
from slipfold.long_term.classification import repeats_of
from slipfold.plots.trajectories import dots_of

OSCILLATOR = sf.SlidingOscillator(f=12.2)


@pytest.fixture(scope="module")
def hysteresis():
    box = {"y": (-0.4, 0.4)}
    return sf.sweep(
        OSCILLATOR, "Nd", (0.06, 0.17), points=6, starts=3, box=box, transient=300, periods=32
    )


def test_both_responses_are_seen_between_the_folds(hysteresis):
    # Both exist between 0.0741 and 0.1398 N, by continuation.
    assert hysteresis.values.tolist() == pytest.approx([0.06, 0.082, 0.104, 0.126, 0.148, 0.17])
    assert hysteresis.repeats("up").tolist() == [1, 1, 1, 1, 2, 2]
    assert hysteresis.repeats("down").tolist() == [1, 2, 2, 2, 2, 2]


def test_extremes_are_those_of_the_orbit(hysteresis):
    at, heights = dots_of(hysteresis, hysteresis.run("down"), "x", "max")
    orbit = sf.periodic_orbit(OSCILLATOR.replace(Nd=0.104), 2, hysteresis.states[1, 2, -1])
    assert at.tolist() == pytest.approx(hysteresis.values)
    assert heights[2] == pytest.approx(orbit.extrema.maximum[0, 0], abs=1e-5)


def test_of_a_torus_each_period_is_a_dot():
    own = {"state": {"y": 0.1}, "f": 12.5, "runs": ("up",), "starts": 0, "periods": 24}
    torus = sf.sweep(OSCILLATOR, "Nd", (0.16, 0.1601), points=2, **own)
    assert torus.repeats("up").tolist() == [0, 0]
    _, states = dots_of(torus, 0, "x", "stroboscopic")
    _, high = dots_of(torus, 0, "x", "max")
    assert len(states) == 2 * 24
    assert len(high) == 2 * 23
    assert high.max() <= 0.45


def test_what_repeats_is_distinguished_from_what_does_not():
    count = np.arange(64.0)
    motions = {
        1: 0.8**count,
        2: np.cos(np.pi * count) + 0.8**count,
        3: np.cos(2 * np.pi * count / 3),
        0: 0.01 * np.cos(2 * np.pi * 0.0731 * count),  # a torus
    }
    drift = 1e-4 * 0.999**count  # still far from where it goes
    states = np.array([*motions.values(), drift])[..., None] * np.ones(2)
    assert repeats_of(sf.built_in_models()["duffing"](), states).tolist() == [*motions, 0]


def test_a_sweep_down_begins_where_the_sweep_up_ended():
    found = sf.sweep(
        sf.SlidingOscillator(Vd=0.3), "Nd", (0.1, 0.4), points=2, starts=0, f=12.5, transient=1,
        periods=2,
    )  # fmt: skip
    assert (found.reasons == "").all()
    again = sf.sweep(
        sf.SlidingOscillator(Vd=0.3), "Nd", (0.1, 0.4), points=2, starts=0, runs=("down",), f=12.5,
        state=found.states[0, 1, -1], transient=1, periods=2,
    )  # fmt: skip
    assert again.states[0].tolist() == found.states[1].tolist()


def test_motions_that_stick_are_marked():
    found = sf.sweep(
        sf.SlidingOscillator(f=12.5, Vd=0.05), "Nd", (0.0, 0.3), points=2, starts=1,
        box={"y": (0, 0.01)}, transient=4, periods=4,
    )  # fmt: skip
    assert found.stuck.tolist() == [[False, True]] * 3


def test_starts_are_of_the_size_of_motions_at_a_value_that_is_sampled():
    tiny = sf.System(
        parameters={"a": 1, "W": 1}, forcing={"period": "2*pi/W"},
        states={"q": "v", "v": "1e-9*cos(W*t) - v - sqrt(a^2 - 0.5)*q"},  # none at a = 0
    )  # fmt: skip
    found = sf.sweep(tiny, "a", (-1, 1), points=2, starts=4, runs=(), transient=0, periods=2)
    assert 0 < np.abs(found.states).max() < 1e-6


def test_an_interrupt_keeps_what_is_done():
    def stop(progress):
        if progress.done >= 2 * 12:
            raise KeyboardInterrupt

    found = sf.sweep(
        OSCILLATOR, "Nd", (0.06, 0.16), points=4, starts=2, transient=8, periods=5, on_progress=stop
    )
    assert found.interrupted
    assert np.isfinite(found.states[0, :2]).all()
    assert (found.reasons[:, 3] == "not done").all()
    assert "Interrupted" in found.summary()
    assert not len(dots_of(found, found.run("start 2"), "x", "stroboscopic")[0])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"span": (0.1, 0.1)}, "is empty"),
        ({"runs": ("sideways",)}, "not of up and down"),
        ({"runs": (), "starts": 0}, "neither a sweep nor a start"),
        ({"points": 1}, "points = 1 is not a whole number"),
        ({"Nd": 0.1}, "Nd is varied"),
        ({"model": sf.built_in_models()["lorenz"](), "vary": "r"}, "nothing forces"),
    ],
)
def test_wrong_input_is_one_sentence(options, message):
    given = {"model": OSCILLATOR, "vary": "Nd", "span": (0.0, 0.1), **options}
    with pytest.raises(sf.InputError, match=message):
        sf.sweep(**given)


def test_motions_on_a_floor_at_rest_are_swept():
    floor = den_hartog(0.6, 0.2)  # over its speed, zero, slip is infinite
    found = sf.sweep(floor, "F", (0.8, 1.0), points=2, starts=1, transient=100, periods=4)
    alone = [sf.simulate(floor.replace(F=F), 300).states[-1] for F in (0.8, 1.0)]
    for run_name in ("up", "down", "start 1"):
        assert found.repeats(run_name).tolist() == [1, 1]
        assert found.states[found.run(run_name), :, -1] == pytest.approx(np.array(alone), abs=1e-7)
