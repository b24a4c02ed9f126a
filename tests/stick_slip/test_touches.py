"""Orbits at a touch of Vrel = 0 in the plane: as good as none of the slip is kept."""

from dataclasses import replace

import numpy as np
import pytest

import slipfold as sf
from helpers.dry_friction import sliding
from slipfold.flow import trajectory
from slipfold.flow.contact_trajectory import dense_phases


@pytest.fixture(scope="module")
def touched():
    """The response in slip up to where the tip begins to stick, and beyond."""
    return over_speed(0.3, (0.0555, 0.0551)).branches[0]


@pytest.mark.long
def test_where_the_tip_begins_to_stick_is_a_curve_in_a_plane(touched):
    (graze,) = touched.special
    window = (0.05, 0.06), (0.25, 0.35)
    (locus,) = sf.locus(graze, ("Vd", "Nd"), window, switch=False).loci
    assert (locus.started.kind, locus.stopped.kind) == ("window", "window")
    # Its ends are said to be where its table has them, all slip taken away.
    for end, values in ((locus.started, locus.values[0]), (locus.stopped, locus.values[-1])):
        assert end.values == pytest.approx(tuple(values), abs=1e-12)
    speed, pulsation = locus.values[0]
    (again,) = over_speed(pulsation, (1.01 * speed, 0.99 * speed)).branches[0].special
    assert speed == pytest.approx(again.value, abs=1e-8)


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


def test_a_touch_moves_with_the_load_as_touches_beside_it_do(touched):
    (graze,) = touched.special
    change = 1e-5
    after = over_speed(0.3 + change, (0.05527, 0.05524)).branches[0].special[0].value
    # The square of slip is left to a ten-thousandth of its size.
    expected = (after - graze.value) / change
    assert sf.gradients(graze)["Nd"] == pytest.approx(expected, rel=1e-4)


def test_extrema_of_part_of_a_round_are_not_said(touched, monkeypatch):
    monkeypatch.setattr(trajectory, "dense_phases", lambda *args: list(dense_phases(*args))[:-1])
    extrema = replace(touched.special[0].orbit).extrema
    assert np.isnan([extrema.minimum, extrema.maximum]).all()


@pytest.mark.parametrize("span", [(0.56, 0.53), pytest.param((0.53, 0.56), marks=pytest.mark.long)])
def test_an_orbit_that_grazes_twice_by_symmetry_grazes_once(span):
    # Shaken across the belt, it comes nearest to the belt's speed twice in a period.
    law = sf.Coulomb(mu_s=0.8, mu_k=0.8)
    model = sf.Structure(
        np.eye(2),
        0.02 * np.eye(2),
        np.diag([4.4 * (0.2 * np.pi) ** 2, 1.0]),
        names="x y",
        contacts=sf.FrictionContact(("x", "y"), law, load=1.0, Vd=span[0]),
        forcing=sf.HarmonicForce("y", F=0.6),
        f=0.1,
    )
    alone = sf.Settings(largest_period=1)
    (branch,) = sf.response(model, vary="Vd", span=span, settings=alone).branches
    assert branch.stopped.kind == "span"
    (graze,) = branch.special
    assert graze.type == "GRAZE"
    assert graze.value == pytest.approx(0.5482601953589, abs=1e-11)
    assert graze.uncertainty < 1e-9
    extrema = graze.orbit.extrema
    assert np.isfinite([extrema.minimum, extrema.maximum]).all()


def over_speed(pulsation, span):
    """The response of period 1 over the speed of the plate."""
    alone = sf.Settings(largest_period=1)
    return sf.response(sliding(pulsation, span[0]), vary="Vd", span=span, settings=alone)
