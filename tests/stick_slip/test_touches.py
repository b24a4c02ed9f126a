"""Orbits at a touch of Vrel = 0 in the plane: as good as none of the slip is kept."""

from dataclasses import replace

import numpy as np
import pytest

import slipfold as sf
from helpers.dry_friction import sliding
from slipfold.flow import trajectory
from slipfold.flow.contact_trajectory import dense_phases


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
    monkeypatch.setattr(trajectory, "dense_phases", lambda *args: list(dense_phases(*args))[:-1])
    extrema = replace(touched.special[0].orbit).extrema
    assert np.isnan([extrema.minimum, extrema.maximum]).all()


def graze_over_speed(pulsation, span):
    """Where the response begins to stick."""
    return [item.point for item in over_speed(pulsation, span).special]


def over_speed(pulsation, span):
    """The response of period 1 over the speed of the plate."""
    alone = sf.Settings(largest_period=1)
    return sf.response(sliding(pulsation, span[0]), vary="Vd", span=span, settings=alone)
