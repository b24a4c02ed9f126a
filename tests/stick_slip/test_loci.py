"""Loci of orbits that stick, and of where they begin to: against branches and other integrators."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import slipfold as sf
from helpers.dry_friction import belt, highest_after_a_touch
from slipfold.results.checks.curves import check_loci

ROWS = [0, 6, -1]

CONSTANT = sf.Coulomb(mu_s=1.0, mu_k=1.0)
FALLING = sf.Stribeck(mu_s=1.0, mu_k=0.5, vs=0.5)


def worn(kinetic, speed):
    """The mass on a belt whose friction falls with speed, to some kinetic friction."""
    return belt(sf.Stribeck(mu_s=1.0, mu_k=kinetic, vs=0.5), speed, damping=0.1)


@pytest.fixture(scope="module")
def end():
    """Where a stick-slip cycle on the belt ends, over its speed."""
    cycle = sf.periodic_orbit(worn(0.5, 1.5), state={"x": 2.0})
    (point,) = sf.response(cycle, vary="Vd", span=(1.5, 1.9)).special
    return point.point


@pytest.fixture(scope="module")
def ends(end):
    """Where stick-slip cycles on the belt end, over its speed and kinetic friction."""
    return sf.locus(end, ("Vd", "mu_k"), ((1.0, 2.5), (0.2, 0.9)))


def shaken(frequency, speed, law=CONSTANT):
    """A mass on a belt that a force shakes as well."""
    return belt(law, speed, 0.1, load=0.4, force=1.0, f=frequency)


@pytest.fixture(scope="module")
def begins():
    """Where the shaken mass begins to stick, over speed and frequency."""
    (graze,) = graze_of(0.25, 1.06)
    return sf.locus(graze, ("Vd", "f"), ((0.2, 1.5), (0.05, 0.35)))


def graze_of(frequency, near):
    orbit = sf.periodic_orbit(shaken(frequency, 0.98 * near))
    found = sf.response(orbit, vary="Vd", span=(0.98 * near, 1.02 * near)).special
    return [item for item in found if item.point.type == "GRAZE"]


def doubling_of(frequency, first, last):
    """Where the shaken mass that sticks doubles its period, friction falling with speed."""
    orbit = sf.periodic_orbit(shaken(frequency, first, FALLING))
    settings = sf.Settings(largest_period=1)
    found = sf.response(orbit, vary="Vd", span=(first, last), settings=settings).special
    (point,) = [item.point for item in found if item.point.type == "PD"]
    return point


@pytest.fixture(scope="module")
def doublings():
    """That point over speed and frequency."""
    window = (0.3, 1.0), (0.0785, 0.09)
    return sf.locus(doubling_of(0.08, 0.5, 0.51), ("Vd", "f"), window, switch=False)


def test_the_end_of_stick_is_a_curve(ends):
    (locus,) = ends.loci
    assert locus.type == "GRAZE"
    assert {locus.started.kind, locus.stopped.kind} == {"window"}
    row = np.abs(locus.values[:, 1] - 0.5).argmin()
    speed, kinetic = locus.values[row]
    assert kinetic == pytest.approx(0.5, abs=1e-9)
    assert speed == pytest.approx(1.8366009722065, abs=1e-9)  # bSTAB


@pytest.mark.parametrize("row", ROWS)
def test_cycles_on_the_curve_touch_as_another_integrator_finds(ends, row):
    speed, kinetic = ends.loci[0].values[row]
    near = 0.999 * speed, 1.001 * speed
    found = brentq(highest_after_a_touch, *near, args=(kinetic,), xtol=1e-12)
    assert found == pytest.approx(speed, abs=1e-9)


@pytest.mark.parametrize("row", ROWS)
def test_branches_begin_to_stick_on_the_curve(begins, row):
    (locus,) = begins.loci
    speed, frequency = locus.values[row]
    (graze,) = graze_of(frequency, speed)
    assert graze.point.value == pytest.approx(speed, abs=1e-8)


@pytest.mark.parametrize("row", [0, 4, -1])
def test_orbits_that_stick_double_their_period_on_the_curve(doublings, row):
    (locus,) = doublings.loci
    assert (locus.stuck_fraction > 0.1).all()
    speed, frequency = locus.values[row]
    found = doubling_of(frequency, 0.99 * speed, 1.01 * speed)
    assert found.value == pytest.approx(speed, abs=1e-8)


def test_a_locus_of_orbits_that_stick_is_checked_by_other_steps(doublings):
    checked = doublings.checked
    assert checked.count
    assert {item.method for item in checked.checks} == {"other steps"}
    assert "of locus 1 at" in checked.checks[0].name
    assert checked.agree, str(checked)
    (locus,) = doublings.loci
    assert not check_loci([replace(locus, values=locus.values + 1e-6)]).agree


def test_no_orbit_on_the_curve_sticks_and_each_touches(ends):
    (locus,) = ends.loci
    assert (locus.stuck_fraction < 1e-6).all()
    for row in (0, -1):
        fastest = locus.orbit(row).extrema.maximum[0, 1]
        assert fastest == pytest.approx(locus.values[row, 0], abs=1e-9)


def test_sticking_cycles_are_known_whichever_period_they_are_counted_with(end):
    # A branch from a doubling counts two, a trajectory that settles on the same cycles one.
    twice = replace(end, period=2, model=end.model.replace(duration=end.duration / 2))
    for points in ([end, twice], [twice, end]):
        found = sf.locus(points, ("Vd", "mu_k"), ((1.8, 1.9), (0.49, 0.51)), switch=False)
        assert [(locus.type, locus.period) for locus in found.loci] == [("GRAZE", points[0].period)]
