"""Tori against closed forms, published values and long simulations."""

from types import SimpleNamespace

import numpy as np
import pytest

import slipfold as sf
from slipfold import Steps
from slipfold.bifurcations.tori.circles import resampled, slopes, tail, turned, turning
from slipfold.bifurcations.tori.follow import follow_tori, resolved, resonances_passed
from slipfold.bifurcations.tori.start import first_circle
from slipfold.bifurcations.tori.surface import growth_across, surface_of
from slipfold.continuation.locate import LostCurveError
from slipfold.continuation.settings import Stepping

TWO_FREQUENCIES = """
name = "two frequencies"
parameters = { a = -0.5, w = 0.83, W = 2, F = 0.3 }
forcing = { period = "2*pi/W" }
[states]
u = "a*u - w*v - u*(u^2 + v^2)"
v = "w*u + a*v - v*(u^2 + v^2)"
x = "-x + u + F*cos(W*t)"
"""


def tori_of(model, vary, span, period=1, which=0, until=None, **settings):
    """Return tori from a Neimark-Sacker point of a diagram on."""
    diagram = sf.response(model, vary=vary, span=span)
    points = [item.point for item in diagram.special if item.point.type == "NS"]
    point = points[which]
    at = model.replace(**{vary: point.value})
    start = first_circle(at, vary, abs(span[1] - span[0]), point.orbit.state, period)
    return point, follow_tori(start, until or span, Stepping(steps=Steps(**settings)))


def last_of(tori):
    """Return the last circle's model, states and rotation number, and its point."""
    point = tori.points[-1]
    circles = point.curve
    model = circles.model.replace(**{circles.vary: circles.value(point.z)})
    return model, circles.states(point.z), circles.rotation(point.z), point


# -- harmonics -----------------------------------------------------------------------------------


def test_curves_by_their_fourier_series():
    def curve(angle):
        return np.stack([np.cos(angle), np.sin(3 * angle) / 3 + 1], axis=-1)

    angles = 2 * np.pi * np.arange(9) / 9
    points = curve(angles)
    assert turned(points, 0.2) == pytest.approx(curve(angles + 0.4 * np.pi), abs=1e-14)
    assert turning(9, 0.2) @ points == pytest.approx(turned(points, 0.2), abs=1e-14)
    expected = 2 * np.pi * np.stack([-np.sin(angles), np.cos(3 * angles)], axis=-1)
    assert slopes(points) == pytest.approx(expected, abs=1e-13)
    fine = 2 * np.pi * np.arange(21) / 21
    assert resampled(points, 21) == pytest.approx(curve(fine), abs=1e-14)
    assert resampled(resampled(points, 21), 9) == pytest.approx(points, abs=1e-14)
    assert tail(resampled(points, 21)) < 1e-15


# -- a closed form -------------------------------------------------------------------------------


def test_a_torus_in_closed_form():
    model = sf.System.from_toml(TWO_FREQUENCIES)
    point, tori = tori_of(model, "a", (-0.5, 1.0))
    assert point.value == pytest.approx(0, abs=1e-9)
    assert tori.end.kind == "span"
    at, circle, rotation, last = last_of(tori)
    assert at.values["a"] == 1
    # A circle of radius sqrt(a), turned by w T.
    assert rotation == pytest.approx(0.83 / 2, abs=1e-12)
    assert np.hypot(circle[:, 0], circle[:, 1]) == pytest.approx(1, abs=1e-10)
    surface = surface_of(at, circle, rotation, 1)
    largest = 1 / np.sqrt(1 + 0.83**2) + 0.3 / np.sqrt(1 + 2**2)
    low, high = surface.extremes()
    assert (low[2], high[2]) == pytest.approx((-largest, largest), abs=1e-10)
    # The only lines of x are at w and W.
    amplitudes = 2 * np.abs(surface.lines[:, :, 2])
    assert amplitudes[1, 0] == pytest.approx(1 / np.sqrt(1 + 0.83**2), abs=1e-10)
    assert amplitudes[0, 1] == pytest.approx(0.3 / np.sqrt(1 + 2**2), abs=1e-10)
    # Across it radii decay by exp(-2 a T), and x by exp(-T).
    across = growth_across(last.linearization.matrices, circle, rotation, at.state_scales())
    assert across.values == pytest.approx([-np.pi, -2 * np.pi], abs=1e-9)


# -- values of others ----------------------------------------------------------------------------


def test_the_torus_of_the_sliding_oscillator():
    model = sf.SlidingOscillator(f=12.5)
    point, tori = tori_of(model, "Nd", (0, 0.98), period=2, which=1, until=(0.16, 0.98))
    # shared/reference/beyond.md.
    born_with = np.abs(np.angle(point.multipliers[0])) / (2 * np.pi)
    assert born_with == pytest.approx(0.113152036028, abs=1e-9)
    # The circles come to that as they shrink: by 6e-4, 3e-3 and 4e-3 they turn less.
    found = [(item.curve.value(item.z), item.z[-2]) for item in tori.points[:3]]
    values, turns = np.array(found).T
    assert np.polyfit(values - point.value, turns, 2)[-1] == pytest.approx(born_with, abs=3e-6)
    at, circle, rotation, last = last_of(tori)
    assert at.values["Nd"] == pytest.approx(0.16, abs=1e-12)
    assert rotation == pytest.approx(0.1095918324, abs=1e-10)
    low, high = surface_of(at, circle, rotation, 2).extremes()
    assert (low[0], high[0]) == pytest.approx((-0.1469835, 0.3114585), abs=5e-8)
    across = growth_across(last.linearization.matrices, circle, rotation, at.state_scales())
    assert across.values[0] < -across.errors[0] < 0


def test_the_circle_is_invariant():
    model = sf.SlidingOscillator(f=12.5)
    _, tori = tori_of(model, "Nd", (0, 0.98), period=2, which=1, until=(0.155, 0.98))
    at, circle, rotation, _ = last_of(tori)
    motion = sf.simulate(at, 2, circle[0])
    assert motion.states[2] == pytest.approx(turned(circle, rotation)[0], abs=1e-8)


@pytest.mark.long
def test_tori_go_on_beyond_an_interval_in_which_they_are_locked():
    model = sf.SlidingOscillator(f=12.5)
    _, tori = tori_of(model, "Nd", (0, 0.98), period=2, which=1, until=(0.1335, 0.98))
    passed = list(resonances_passed(tori.points))
    assert [str(item.ratio) for item in passed] == ["1/9", "1/10", "1/11"]
    eleventh = passed[-1]
    assert last_of(tori)[2] < 1 / 11
    # Inside a motion comes to an orbit of eleven returns of two periods each, and no fewer.
    assert eleventh.last < 0.1359 < eleventh.first
    inside = model.replace(Nd=0.1359)
    orbit = sf.periodic_orbit(inside, period=22, state=sf.simulate(inside, 6000).states[-1])
    assert orbit.stable
    assert np.ptp(sf.simulate(inside, 22, orbit.state).states[:22:2], axis=0).max() > 0.1


def test_a_step_from_a_circle_onto_the_orbit_is_not_taken():
    # The orbit solves the equations of circles at any rotation number.
    circles = SimpleNamespace(
        states=lambda size: size * np.eye(2), model=SimpleNamespace(state_scales=lambda: np.ones(2))
    )
    before, point = (SimpleNamespace(curve=circles, z=size) for size in (1.0, 0.0))
    with pytest.raises(LostCurveError, match="shrinks to a periodic orbit within a step"):
        resolved(SimpleNamespace(before=before, point=point))
