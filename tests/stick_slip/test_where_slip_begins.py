"""The instant at which a contact lets go, where motions end on it and in its first moments."""

import math

import numpy as np
import pytest

import slipfold as sf
from helpers.dry_friction import belt, sliding
from slipfold.flow.contact_trajectory import sample_hybrid

LAW = sf.Coulomb(mu_s=0.5, mu_k=0.25)


def on_a_belt(Vd=0.25):
    """A mass on a belt that lets go when the spring is stretched by half a meter."""
    return belt(LAW, Vd, length_scale=1.0)


@pytest.mark.parametrize("after", [-2e-14, -2e-15, 0.0, 2e-15, 2e-14])
def test_a_motion_that_ended_on_a_release_slips_when_it_goes_on(after):
    model = on_a_belt().replace(duration=1.0)
    first = sf.simulate(model, 2, [0.0, 0.25])
    assert first.states[-1] == pytest.approx([0.5, 0.25], abs=1e-13)
    again = sf.simulate(model, 2, [0.5 + after, 0.25])
    # By hand: x = mu_k + (mu_s - mu_k) cos t + Vd sin t
    for t, state in enumerate(again.states):
        x = 0.25 + 0.25 * math.cos(t) + 0.25 * math.sin(t)
        v = 0.25 * math.cos(t) - 0.25 * math.sin(t)
        assert state == pytest.approx([x, v], abs=1e-12)
    assert [item.state for item in again.sticking.intervals] == ["slip"]
    assert again.sticking.intervals[0].begin == pytest.approx(0, abs=1e-13)


def test_a_force_at_its_limit_that_falls_again_holds():
    """Friction is all that the belt needs at once, and less later: it sticks."""
    model = on_a_belt(Vd=0.0).replace(duration=1.0)
    assert np.abs(sf.simulate(model, 3, [0.5, 0.0]).states - [0.5, 0.0]).max() == 0
    moving = on_a_belt(Vd=0.25).replace(duration=1.0)
    # From the other side the belt brings the mass nearer to where its spring is not stretched.
    states = sf.simulate(moving, 3, [-0.5, 0.25]).states
    assert states == pytest.approx(np.array([[-0.5 + 0.25 * t, 0.25] for t in range(4)]), abs=1e-13)


def test_friction_stays_in_its_cone_while_slip_in_the_plane_begins():
    motion = sf.simulate(sliding(0.9, 0.02), 4)
    begin = next(item.end for item in motion.sticking.intervals if item.state == "stick")
    period = int(begin)
    after = np.concatenate([[0.0], np.geomspace(1e-9, 3e-4, 300)])
    phases = begin - period + after
    mode = motion.sticking.mode(period)
    samples = sample_hybrid(motion.model, motion.states[period], mode, phases)
    names = [item.name for item in motion.model.outputs()]
    rows = dict(zip(names, samples.outputs().T[-len(names) :], strict=True))
    friction = np.hypot(rows["Fx"], rows["Fy"])
    assert np.abs(friction - 0.5 * rows["N"]).max() < 1e-12
    plate = 0.02 / 5e-3 * np.array([math.cos(math.pi / 3), math.sin(math.pi / 3)])
    speed = np.hypot(*(plate - samples.states[:, 2:]).T)
    # From nothing, and never back
    assert speed[0] < 1e-9
    assert (np.diff(speed) >= 0).all()
    # With the square of the time at first, and without a jump where that beginning is at an end
    early = (after > 1e-5) & (after < 2e-4)
    growth = speed[early] / after[early] ** 2
    assert growth.max() / growth.min() < 1.01
    assert np.abs(np.diff(np.log(growth))).max() < 1e-4
