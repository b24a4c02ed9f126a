"""Orbits at a touch of Vrel = 0 in the plane: as good as none of the slip is kept."""

from dataclasses import replace

import numpy as np
import pytest

import slipfold as sf
from helpers.dry_friction import sliding
from slipfold.continuation.newton import correct
from slipfold.flow import trajectory
from slipfold.flow.contact_motion import dense_legs
from slipfold.loci.locus_equations import LocusEquations
from slipfold.orbits.grazing import GrazingShooting
from slipfold.orbits.kinds import orbits_of
from slipfold.orbits.switched_shooting import SwitchedShooting

LEVELS = [1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5]
"""Slip that is kept, over its size."""


@pytest.fixture(scope="module")
def slipping():
    """An orbit that slips as slowly as the smooth model follows it, and its discretisation."""
    branch, *_ = sf.response(sliding(0.3, 0.2), vary="Vd", span=(0.2, 0.056)).branches
    model = branch.orbit(-1).model
    orbits = orbits_of(model, {"Vd": 0.3, "Nd": 0.9}, 1, 1, by=SwitchedShooting)
    z = orbits.unknown(branch.nodes[-1][:1], model)
    by = GrazingShooting.at(orbits.by, orbits.nodes(z), orbits.constants(z), "GRAZE")
    other = orbits.described_by(by)
    return other, other.adopt(orbits, z)


def touched_with(orbits, z, level):
    """The touch with some slip left, at the same pulsation."""
    by = orbits.by
    met = replace(by.met, level=level)
    nearer = GrazingShooting(by.model, by.free, by.period, met)
    curve = LocusEquations(orbits.described_by(nearer), "GRAZE")
    row = np.eye(1, len(z), len(z) - 1)[0]
    correction = correct(curve, z, row)
    assert correction.converged
    return curve, curve.point(correction, 0.0)


def test_the_slip_that_is_kept_plays_no_part(slipping):
    (orbits, z), speeds = slipping, []
    for level in LEVELS:
        curve, point = touched_with(orbits, z, level)
        orbits, z = curve.orbits, point.z
        last = np.zeros(len(point.z))
        last[-2] = level
        row = np.eye(1, len(point.z), len(point.z) - 1)[0]
        moved = curve.linearise(point.z).bordered(row).solve(last)
        speeds.append(curve.place(point.z - moved)[0])
    exact = speeds[-1]
    assert speeds[LEVELS.index(1e-3)] == pytest.approx(exact, abs=5e-8)
    assert speeds[LEVELS.index(1e-4)] == pytest.approx(exact, abs=1e-9)


def test_its_derivatives_are_those_of_differences(slipping):
    curve, point = touched_with(*slipping, LEVELS[0])
    jacobian = curve.linearise(point.z).jacobian
    for place in range(len(point.z)):
        step = 1e-7 * np.eye(1, len(point.z), place)[0]
        apart = curve.defect(point.z + step) - curve.defect(point.z - step)
        assert jacobian[:, place] == pytest.approx(apart / 2e-7, abs=1e-4)


def test_where_the_tip_begins_to_stick_is_a_curve_in_a_plane():
    (graze,) = graze_over_speed(0.3, (0.06, 0.055))
    window = (0.05, 0.06), (0.25, 0.35)
    (locus,) = sf.locus(graze, ("Vd", "Nd"), window, switch=False).loci
    assert (locus.begun.kind, locus.stopped.kind) == ("window", "window")
    # Its ends are said to be where its table has them, all slip taken away.
    for end, values in ((locus.begun, locus.values[0]), (locus.stopped, locus.values[-1])):
        assert end.values == pytest.approx(tuple(values), abs=1e-12)
    speed, pulsation = locus.values[0]
    (again,) = graze_over_speed(pulsation, (1.05 * speed, 0.99 * speed))
    assert speed == pytest.approx(again.value, abs=1e-8)


@pytest.fixture(scope="module")
def touched():
    """The response in slip up to where the tip begins to stick, and beyond."""
    return over_speed(0.3, (0.0555, 0.0551)).branches[0]


@pytest.mark.parametrize("side", ["minimum", "maximum"])
def test_extrema_at_the_touch_go_on_from_those_in_slip(touched, side):
    (graze,) = touched.special
    n, after = graze.nodes.shape[1], int(np.searchsorted(-touched.parameter, -graze.value))
    (far, near), (before, last) = (
        values[after - 2 : after]
        for values in (touched.parameter, getattr(touched.extrema, side)[:, :n])
    )
    step = last - before
    expected = last + (graze.value - near) / (near - far) * step
    found = getattr(graze.orbit.extrema, side)[0, :n]
    # Slopes differ by a few percent between points; those of part of a round are far off.
    assert (np.abs(found - expected) < 0.05 * np.abs(step)).all()


def test_extrema_of_part_of_a_round_are_not_said(touched, monkeypatch):
    monkeypatch.setattr(trajectory, "dense_legs", lambda *args: list(dense_legs(*args))[:-1])
    extrema = replace(touched.special[0].orbit).extrema
    assert np.isnan([extrema.minimum, extrema.maximum]).all()


def graze_over_speed(pulsation, span):
    """Where the response begins to stick."""
    return [item.point for item in over_speed(pulsation, span).special]


def over_speed(pulsation, span):
    """The response of period 1 over the speed of the plate."""
    alone = sf.Settings(largest_period=1)
    return sf.response(sliding(pulsation, span[0]), vary="Vd", span=span, settings=alone)
