"""The sliding oscillator under exact planar friction: into stick, out of it, and on a wall."""

import math

import numpy as np
import pytest

import slipfold as sf
from helpers.dry_friction import den_hartog, sliding

# Found by two methods that share no code.
ROWS = [
    pytest.param(
        (0.3, 0.05, 0.5, 1, 0.053208237, (0.1900998927, 0.0672867089, 0.1753534846, -0.0783359137)),
        marks=pytest.mark.long,
    ),
    (0.3, 0.05, 0.6, 1, 0.073909323, (0.1905840421, 0.0672596774, 0.1760634389, -0.0788106789)),
    (0.9, 0.02, 0.5, 1, 0.349134742, (0.1268751657, 0.0496066544, 0.0935858688, -0.0443746758)),
    (0.6, 0.1, 0.5, 2, 0.0, (0.3882907165, -0.1888683006, 0.2882647529, -0.2272754321)),
]


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"Nd={row[0]} Vd={row[1]} mu_s={row[2]}")
def test_published_motions(row):
    pulsation, speed, static, period, fraction, extrema = row
    motion = sf.simulate(sliding(pulsation, speed, static), 120)
    assert motion.settlement.period == period
    assert motion.regime == ("stick-slip" if fraction else "slip")
    assert motion.stuck_fraction == pytest.approx(fraction, abs=1e-9)
    assert len(motion.last_round.sticking) == (1 if fraction else 0)
    last = motion.last_round
    found = (last.maximum[0], last.minimum[0], last.maximum[1], last.minimum[1])
    assert found == pytest.approx(extrema, abs=1e-10)


def test_what_sticks_moves_with_the_plate_and_stays_in_the_cone():
    motion = sf.simulate(sliding(0.9, 0.02), 40)
    fx, fy, normal, speed = (
        motion.output(name, 30, None, 97)[1] for name in ("Fx", "Fy", "N", "Vrel")
    )
    friction, rests = np.hypot(fx, fy), speed == 0
    assert 0.3 < rests.mean() < 0.4
    assert (friction[rests] <= 0.5 * normal[rests] * (1 + 1e-12)).all()
    assert friction[~rests] == pytest.approx(0.5 * normal[~rests], rel=1e-12)
    states = motion.sample(30, None, 97)[1][rests]
    plate = 0.02 / 5e-3 * np.array([math.cos(math.pi / 3), math.sin(math.pi / 3)])
    assert np.abs(states[:, 2:] - plate).max() <= 1e-14 * plate.max()


def energy(model, state):
    x, y, vx, vy = 5e-3 * state
    stretch = math.hypot(x, model.L + y) - model.L
    moving = model.m2 * vx**2 + model.m1 * vy**2
    return (moving + model.k2 * x**2 + model.k1 * y**2 + model.kext * stretch**2) / 2


def test_a_line_in_the_plane_is_a_line():
    # Two directions, one of them at rest: the motion, its turns and stops are those on a line.
    law = sf.Coulomb(mu_s=0.8, mu_k=0.5)
    plane = sf.Structure(
        np.eye(2),
        None,
        np.eye(2),
        names="x y",
        contacts=sf.FrictionContact(("x", "y"), law, load=1.0, Vd=0.0),
        forcing=sf.HarmonicForce("x", F=1.0),
        f=0.6 / (2 * math.pi),
    )
    flat = sf.simulate(plane, 20)
    line = sf.simulate(den_hartog(0.6, 0.5, 0.8), 20)
    assert flat.states[:, [0, 2]] == pytest.approx(line.states, abs=1e-10)
    assert np.abs(flat.states[:, [1, 3]]).max() < 1e-12
    assert [item.state for item in flat.sticking.intervals].count("stick") > 20


@pytest.mark.parametrize("forced", [True, False])
def test_on_a_wall_the_oscillator_comes_to_rest(forced):
    model = sliding(0.4, 0.0, 0.6)
    start = {"x": 3.0, "vy": 20.0}
    motion = sf.simulate(model if forced else model.steady(), 12, start)
    assert motion.stopped is None
    assert motion.sticking.intervals[0].state == "slip"
    assert motion.sticking.intervals[-1].state == "stick"
    assert np.abs(motion.states[-1, 2:]).max() == 0
    assert motion.states[-1] == pytest.approx(motion.states[-2], abs=0)
    # All that was in it was turned into heat by friction and damping, but for what springs hold.
    heat = sum(item.heat for item in motion.sticking.intervals)
    work = sum(item.work for item in motion.sticking.intervals)
    assert work == pytest.approx(-heat, rel=1e-12)
    lost = energy(model, motion.states[0]) - energy(model, motion.states[-1])
    assert 0.9 * lost < heat < lost


def test_loci_and_maps_are_not_followed_on_a_wall():
    for follow in (
        lambda: sf.response(sliding(0.1, 0.6), "Vd", (0.6, 0)),
        lambda: sf.bifurcation_set(
            sliding(0.1, 0.0), ("f", "Nd"), ((12, 13), (0, 0.1)), regions=True
        ),
        lambda: sf.threshold_map(
            sliding(0.1, 0.6), "Nd", over={"Vd": [0, 1], "f": [12, 13]}, span=(0, 0.1)
        ),
        lambda: sliding(0.1, 0.0).static_point(),
    ):
        with pytest.raises(sf.InputError, match=r"^Vd = 0 is outside its bounds; Vd must be > 0"):
            follow()


@pytest.mark.long
@pytest.mark.parametrize("span", [(0.085, 0.095), (0.095, 0.085)])
def test_slip_that_begins_within_a_stop_in_the_plane_is_passed(span):
    # Next to it the equations are too stiff to be solved: the tangent leads across.
    (point,) = special_in_the_plane(0.505, 0.2855, 0.722, span)
    assert point.type == "GRAZE"
    assert point.value == pytest.approx(0.088902059946123, abs=1e-13)


@pytest.mark.long
# The last span has one step across all orbits with two stops: before and after it there is one.
@pytest.mark.parametrize("span", [(0.0935, 0.088), (0.088, 0.0935), (0.085, 0.095)])
def test_a_stop_that_begins_in_the_plane_is_passed(span):
    points = special_in_the_plane(0.54, 0.42, 1.0, span)
    assert [point.type for point in points] == ["GRAZE", "GRAZE"]
    (point,) = [item for item in points if item.value > 0.09]
    assert point.uncertainty < 1e-7
    near = point.nodes[0]
    counts = [
        len([item for item in motion.sticking.intervals if item.state == "stick"])
        for motion in (sf.simulate(point.model.replace(f=point.value + away), 20, near)
                       for away in (1e-6, -1e-6))
    ]  # fmt: skip
    assert counts == [20, 40]


def special_in_the_plane(friction, speed, force, span):
    """Special points of a mass on a moving plane, shaken along it, over the whole span."""
    law = sf.Coulomb(mu_s=friction, mu_k=friction)
    contact = sf.FrictionContact(("x", "y"), law, load=1.0, Vd=speed)
    model = sf.Structure(
        np.eye(2), 0.1 * np.eye(2), [[1.0, 0.3], [0.3, 1.5]], names="x y", contacts=contact,
        forcing=sf.HarmonicForce("x", F=force), f=span[0],
    )  # fmt: skip
    (branch,) = sf.response(model, "f", span, settings=sf.Settings(largest_period=1)).branches
    assert branch.stopped.kind == "span"
    return branch.special
