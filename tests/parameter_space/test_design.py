"""Parameters chosen for thresholds: derivatives, against grids, windows, what cannot be met."""

from dataclasses import replace

import numpy as np
import pytest

import slipfold as sf
from helpers.command_line import run
from slipfold.parameter_space import optimum as confirmed
from slipfold.parameter_space.optimum import ParameterizedOrbit, ParameterizedPoint

CHOOSE = {"alpha": ("75deg", "85deg"), "Vd": (0.3, 1.0)}
LOAD = 0.02


@pytest.fixture(scope="module")
def sliding():
    return sf.response(sf.SlidingOscillator(), "Nd", (0, 0.98), f=12.5).special


@pytest.fixture(scope="module")
def found(sliding):
    return sf.design(sliding[0], CHOOSE, above="27mN", load="20mN", state="x")


def test_derivatives_of_the_vibration():
    model = sf.SlidingOscillator(f=12.5, Nd=0.04)
    orbit = ParameterizedOrbit.at(model, ("alpha", "Vd", "f", "L"))
    level, slopes = orbit.level(1)
    samples = sf.periodic_orbit(model).nodes[:, 1]  # eight phases: exact up to the third harmonic
    assert level == pytest.approx(samples.std(), rel=0.01)
    for place, name in enumerate(orbit.names):
        step = 1e-4 * model.values[name]
        near, far = (
            [orbit.moved_to({name: model.values[name] + sign * size}).level(1)[0]
             for sign in (-1, 1)] for size in (step, 2 * step)
        )  # fmt: skip
        expected = (8 * (near[1] - near[0]) - (far[1] - far[0])) / (12 * step)
        assert slopes[place] == pytest.approx(expected, rel=1e-7), name


def test_the_least_vibration_is_that_of_a_grid(sliding, found):
    placed = ParameterizedPoint.at(sliding[0].point, ("alpha", "Vd"))
    orbit = ParameterizedOrbit.at(sf.SlidingOscillator(f=12.5, Nd=LOAD), ("alpha", "Vd"))
    known = []
    for alpha in np.radians(np.linspace(75, 85, 5)):
        for speed in np.linspace(0.3, 1, 15):
            there = {"alpha": float(alpha), "Vd": float(speed)}
            known.append((placed.moved_to(there).value, orbit.moved_to(there).level(0)[0]))
    values, levels = np.array(known).T
    best = levels[values >= found.wanted[0]].min()
    assert 0.95 * best < found.levels[0] <= best
    assert found.thresholds[0, 0] == pytest.approx(0.027, rel=1e-6)


def test_designs_are_confirmed_by_responses_of_their_own(found):
    assert found.confirmed.tolist() == [True]
    model = found.model_at(0)
    diagram = sf.response(model, "Nd", (0, 0.05), settings=sf.Settings(largest_period=1))
    assert diagram.special[0].point.value == pytest.approx(found.thresholds[0, 0], rel=1e-9)


def test_what_cannot_be_met_is_said(sliding):
    found = sf.design(sliding[0], {"Vd": (0.5, 0.7)}, above=[0.042, 0.2], load=LOAD)
    assert found.reasons[0] == ""
    said = "no choice was found within the bounds that brings the PD above 0.2"
    assert found.reasons[1].startswith(said)
    assert np.isnan(found.levels[1])
    assert f"Nothing for above 0.2: {said}" in found.summary()


@pytest.mark.long
def test_a_torus_leaves_a_window_while_the_doubling_stays(sliding):
    choose = {"alpha": ("59deg", "62deg"), "Vd": (0.55, 0.65)}
    keep = {"doubling": (sliding[0], 0.0405)}
    (_, torus) = sliding[2]
    found = sf.design(torus, choose, outside=(0.15, 0.19), load=LOAD, keep=keep, state="y")
    assert found.sides in (("above",), ("below",))
    value, kept = found.thresholds[0]
    assert value >= 0.19 * (1 - 1e-6) or value <= 0.15 * (1 + 1e-6)
    assert kept >= 0.0405 * (1 - 1e-6)
    alpha, speed = found.values[0].tolist()
    special = sf.response(sf.SlidingOscillator(f=12.5, alpha=alpha, Vd=speed), "Nd", (0, 0.98))
    located = [point.value for _, point in special.special]
    assert located[0] == pytest.approx(kept, rel=1e-9)
    assert min(abs(value - each) for each in located) < 1e-9


@pytest.mark.parametrize("done", [3, 5])
def test_interruption_keeps_what_is_known(sliding, done):
    def observer(progress):
        if progress.done == done:
            raise KeyboardInterrupt

    choose = {"Vd": (0.5, 0.7)}
    found = sf.design(sliding[0], choose, above=[0.04, 0.042], load=LOAD, on_progress=observer)
    assert found.interrupted
    assert found.reasons.tolist() == ["", "interrupted before this was reached"]
    assert found.confirmed.tolist() == [True, False]


def test_a_loss_of_a_longer_period_is_confirmed_from_the_doubling_on(sliding):
    (_, doubling), (_, torus), (_, back) = sliding[0], sliding[1], sliding[2]
    assert (torus.type, torus.period) == ("NS", 2)
    assert confirmed.is_confirmed(torus, {}, torus.value, LOAD)
    assert not confirmed.is_confirmed(back, {}, back.value, LOAD)  # lost at the first one
    assert not confirmed.is_confirmed(torus, {}, torus.value * (1 + 1e-6), LOAD)
    between = 0.5 * (doubling.value + torus.value)
    assert not confirmed.is_confirmed(torus, {}, torus.value, between)  # the response is unstable


def test_what_is_confirmed_is_the_loss_of_stability_behind_the_begin_of_stick(sliding):
    # Special points of sf.response(SlidingOscillator(f=12.5, Vd=0.08), "Nd", (0.2, 0.97)).
    doubling, sticks, slow = sliding[0].point, 0.567503347943, {"Vd": 0.08}
    assert confirmed.is_confirmed(doubling, slow, 0.716439544087, 0.56)
    assert confirmed.is_confirmed(replace(doubling, type="GRAZE"), slow, sticks, 0.56)


@pytest.mark.parametrize(
    ("choose", "options", "said"),
    [
        ({}, {"above": 0.05}, "there is nothing to choose"),
        ({"Nd": (0, 1)}, {"above": 0.05}, "the threshold is a value of it"),
        ({"Vd": (1, 0.5)}, {"above": 0.05}, "give the lower value first"),
        ({"Vd": (0.5, 1)}, {}, r"give either above \(--above\)"),
        ({"Vd": (0.5, 1)}, {"above": 0.05, "state": "z"}, "no state 'z'"),
        ({"Vd": 0.5}, {"above": 0.05}, "is not a pair of numbers"),
    ],
)
def test_bad_input(sliding, choose, options, said):
    with pytest.raises(sf.InputError, match=said):
        sf.design(sliding[0], choose, load=LOAD, **options)


def test_command():
    found = run(
        "design", "sliding", "--vary", "Nd=0:0.05", "--set", "f=12.5", "--choose", "Vd=0.4:0.8",
        "--above", "50mN", "--load", "20mN", "--keep", "PD:1=45mN",
    )  # fmt: skip
    assert found.exit_code == 0
    assert "above 0.05" in found.stdout
    assert "PD:1" in found.stdout
    nothing = run(
        "design", "sliding", "--vary", "Nd=0:0.05", "--set", "f=12.5", "--choose", "Vd=0.4:0.8",
        "--above", "0.5", "--load", "20mN",
    )  # fmt: skip
    assert nothing.exit_code == 3
    wrong = run(
        "design", "sliding", "--vary", "Nd=0:0.05", "--choose", "Vd=0.4:0.8", "--load", "20mN",
        "--above", "50mN", "--keep", "PD=45mN",
    )  # fmt: skip
    assert wrong.exit_code == 2
    assert "--keep PD has no period" in wrong.stderr
