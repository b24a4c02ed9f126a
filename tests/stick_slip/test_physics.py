"""What no motion with dry friction may violate: energy, the friction cone, rest in stick."""

import math

import numpy as np
import pytest

import slipfold as sf
from helpers.long_tests import long_except
from slipfold.flow.simulate import simulate

LAWS = {
    "Coulomb": sf.Coulomb(mu_s=0.6, mu_k=0.4),
    "viscous": sf.CoulombViscous(mu_s=0.5, mu_k=0.4, s2=0.2),
    "Tustin": sf.Stribeck(mu_s=0.6, mu_k=0.3, vs=0.2, s2=0.1),
    "Gauss": sf.Stribeck(mu_s=0.6, mu_k=0.3, vs=0.2, exponent=2),
    "rational": sf.RationalStribeck(mu_s=0.6, d=2.0),
    "cubic": sf.CubicStribeck(mu_s=0.6, mu_m=0.3, vm=1.5),
}


def brake(law):
    """Two masses with damping, pulsating normal force, a belt and a wall."""
    load = sf.ModulatedLoad(Ns=1.0, Nd=0.4)
    return sf.Structure(
        [[1.0, 0.0], [0.0, 2.0]],
        [[0.1, -0.05], [-0.05, 0.1]],
        [[3.0, -1.0], [-1.0, 2.0]],
        names="a b",
        contacts=[
            sf.FrictionContact("a", law, load=load, Vd=0.3, name="belt"),
            sf.FrictionContact({"b": 1.0, "a": -0.2}, law, load=0.4, Vd=0.0, name="wall"),
        ],
        forcing=sf.HarmonicForce("b", F=0.6),
        f=0.15,
    )


@pytest.mark.parametrize("law", long_except(LAWS, ("Tustin", "Gauss")))
def test_energy_balance_over_a_period(law):
    before, motion = (sf.simulate(brake(LAWS[law]), periods) for periods in (19, 20))
    assert motion.stopped is None
    assert {item.state for item in motion.sticking.intervals} == {"stick", "slip"}
    gained = total(motion, "work") - total(before, "work")
    # By hand: what the force puts in, and what dampers take out.
    nodes, weights = np.polynomial.legendre.leggauss(12)
    inside = [item.end for item in motion.sticking.intervals if 19 < item.end < 20]
    edges = np.unique(np.concatenate([np.linspace(19, 20, 33), inside]))
    lengths = np.diff(edges)
    points = (edges[:-1, None] + lengths[:, None] * (nodes + 1) / 2).ravel()
    v = motion.at(points * motion.forcing_period)[:, 2:]
    forced = 0.6 * np.cos(2 * math.pi * points) * v[:, 1]
    lost = np.einsum("ij,jk,ik->i", v, [[0.1, -0.05], [-0.05, 0.1]], v)
    power = ((forced - lost).reshape(-1, 12) * weights).sum(axis=1)
    gained += float(power @ lengths) / 2 * motion.forcing_period
    assert gained == pytest.approx(energy(motion.states[20]) - energy(motion.states[19]), abs=1e-9)
    assert abs(total(motion, "work") - total(before, "work")) > 0.01


def total(motion, what):
    return sum(getattr(item, what) for item in motion.sticking.intervals)


def energy(state):
    u, v = state[:2], state[2:]
    return v @ np.diag([1.0, 2.0]) @ v / 2 + u @ [[3.0, -1.0], [-1.0, 2.0]] @ u / 2


def test_what_the_belt_drives_is_what_friction_gives_and_heats():
    motion = sf.simulate(brake(LAWS["Gauss"]), 20)
    names = {item.contact for item in motion.sticking.intervals}
    assert names == {"belt", "wall"}
    for item in motion.sticking.intervals:
        assert item.heat >= 0
        if item.state == "stick":
            assert item.heat == 0
        if item.contact == "wall":
            assert item.work == pytest.approx(-item.heat, abs=1e-13)


def test_a_record_of_the_last_periods_is_the_end_of_the_whole_record():
    whole, last = (simulate(brake(LAWS["Coulomb"]), 20, kept=kept).sticking for kept in (None, 3))
    assert len(last.intervals) < len(whole.intervals) / 4
    one, other = ([i[:4] for i in s.intervals if i.begin > 17] for s in (whole, last))
    assert one == other
    assert min(item.begin for item in last.intervals) <= 17
    assert (whole.modes == last.modes).all()
