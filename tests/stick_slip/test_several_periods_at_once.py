"""A motion through stick is the same however many of its periods are asked for at once."""

import math

import numpy as np
import pytest

import slipfold as sf
from slipfold.flow.switched_motion import SwitchedMotion

PERIODS = 24

LAW = sf.Coulomb(mu_s=0.7, mu_k=0.6)


def mass(**given):
    contact = sf.FrictionContact("x", LAW, load=1.0, Vd=given.pop("Vd", 0.0))
    return sf.Structure([[1.0]], None, [[1.0]], names="x", contacts=contact, **given)


def forced(Vd, f):
    return mass(Vd=Vd, f=f, forcing=sf.HarmonicForce("x", F=1.0))


CASES = {
    "rests where periods end": (forced(0.0, 0.35 / (2 * math.pi)), [0.0, 0.0]),
    "rests for several periods": (forced(1e-3, 1.0), [0.0, 1e-3]),
    "is carried where periods end": (forced(0.2, 0.35 / (2 * math.pi)), [0.0, 0.2]),
    "nothing forces it": (mass(Vd=0.1), [0.0, 0.1]),
}


@pytest.mark.parametrize(("model", "start"), CASES.values(), ids=CASES)
def test_at_once_or_one_by_one(model, start):
    whole, pieces = (SwitchedMotion(model, np.array(start)) for _ in range(2))
    whole.go_on(PERIODS)
    for _ in range(PERIODS):
        pieces.go_on(1)
    assert whole.modes == pieces.modes
    # Steps are other ones: their errors and those of events, which motions that stick forget.
    np.testing.assert_allclose(whole.strobe, pieces.strobe, rtol=0, atol=1e-11)
    one, other = (motion.recorder.ended(PERIODS) for motion in (whole, pieces))
    assert any(item.state == "stick" for item in one)
    assert [item.state for item in one] == [item.state for item in other]
    for name in ("begin", "end", "work", "heat"):
        values = [[getattr(item, name) for item in some] for some in (one, other)]
        np.testing.assert_allclose(*values, rtol=0, atol=1e-11)


def test_each_period_is_told_once():
    model, start = CASES["rests where periods end"]
    motion, told = SwitchedMotion(model, np.array(start)), []
    motion.go_on(PERIODS, lambda: told.append(motion.periods))
    assert told == list(range(1, PERIODS + 1))
