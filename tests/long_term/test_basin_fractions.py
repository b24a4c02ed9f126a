"""Fractions of starts that each attractor wins along a parameter."""

from math import sqrt

import numpy as np
import pytest

import slipfold as sf

# Rest wins inside the circle of radius r, else the cycle of radius 2.
HARD = """
name = "hard onset"
parameters = { r = 1.0 }
[states]
x = "(x^2 + y^2 - r^2)*(4 - x^2 - y^2)*x - y"
y = "(x^2 + y^2 - r^2)*(4 - x^2 - y^2)*y + x"
"""

WHOLE_BOX = {"x": (-0.5, 0.5), "y": (-0.5, 0.5), "vx": (-20, 20), "vy": (-20, 20)}

# Two mirror images that stay apart, in a box that is larger on one side.
WELLS = """
name = "double well"
parameters = { d = 0.2 }
[states]
x = "v"
v = "x - x^3 - d*v"
"""


@pytest.fixture(scope="module")
def circle():
    model, box = sf.System.from_toml(HARD), {"x": (-2, 2), "y": (-2, 2)}
    return sf.basin_fractions(model, "r", (0.4, 1.6), box, points=2, starts=64)


def kinds(found):
    """Return the number of each kind, all of which are found once."""
    return {item.kind: number for number in found.numbers for item in found.along(number).values()}


def test_shares_are_those_of_areas(circle):
    assert circle.numbers == (1, 2)
    rest = circle.fraction(kinds(circle)["equilibrium"])
    area = np.pi * circle.values**2 / 16
    assert rest.value == pytest.approx(area, abs=0.03)  # starts are spread evenly
    assert np.all((rest.low < area) & (area < rest.high))
    assert rest.value + circle.fraction(kinds(circle)["cycle"]).value == pytest.approx(1)
    inside = (circle.starts**2).sum(axis=1) < circle.values[:, None] ** 2
    assert np.array_equal(circle.labels == kinds(circle)["equilibrium"], inside)


def test_bounds_are_those_of_wilson(circle):
    number = kinds(circle)["cycle"]
    fraction, low, high = (each[1] for each in circle.fraction(number))
    n, z = len(circle.starts), 1.96
    for bound in (low, high):  # where the fraction is z standard deviations of the bound away
        assert abs(fraction - bound) == pytest.approx(z * sqrt(bound * (1 - bound) / n), rel=1e-9)


def test_each_attractor_keeps_its_number():
    model = sf.System.from_toml(WELLS)
    found = sf.basin_fractions(model, "d", (0.2, 0.6), {"x": (-3, 2)}, points=3, starts=32)
    assert found.numbers == (1, 2)
    for number in found.numbers:
        along = found.along(number)
        assert len(along) == 3
        assert len({np.sign(item.state[0]) for item in along.values()}) == 1


@pytest.mark.long
def test_period_two_wins_seven_of_ten_starts_of_the_sliding_oscillator():
    found = sf.basin_fractions(
        sf.SlidingOscillator(f=12.2), "Nd", (0.06, 0.15), WHOLE_BOX, points=10, starts=128
    )
    periods = [sorted(item.period for item in items) for items in found.attractors]
    both = (found.values > 0.0741) & (found.values < 0.1398)
    assert all((known == [1, 2]) == here for known, here in zip(periods, both, strict=True))
    assert periods[0] == [1]
    assert periods[-1] == [2]
    assert found.numbers == (1, 2)
    value, low, high = (each[4] for each in found.fraction(2))  # at 0.1 N
    assert low < 0.69 < high
    assert value == pytest.approx(0.69, abs=0.03)


def test_an_interruption_keeps_the_values_that_are_finished(tmp_path):
    told = []

    def stop(progress):
        told.append(progress)
        if progress.done >= 35:
            raise KeyboardInterrupt

    found = sf.basin_fractions(
        sf.built_in_models()["duffing"](), "W", (1, 1.4), points=4, starts=16, on_progress=stop
    )
    assert found.interrupted
    assert all(progress.total == 64 for progress in told)
    assert np.all(np.diff([progress.done for progress in told]) >= 0)
    assert np.isfinite(found.fraction(1).value).tolist() == [True, True, False, False]
    assert "2 values not finished" in found.summary()
    found.save(tmp_path / "f.nc")
    assert sf.load(tmp_path / "f.nc").to_json() == found.to_json()
