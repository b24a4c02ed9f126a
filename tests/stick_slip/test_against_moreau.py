"""Motions from event to event against Moreau's time-stepping: they agree better as steps shrink."""

import math

import numpy as np
import pytest

import slipfold as sf
from helpers.by_hand.sticking import constant
from helpers.by_hand.sticking import sliding as planar_by_hand
from helpers.dry_friction import sliding
from helpers.moreau import Contact, System, march

END = 20.0
HALVINGS = (0.04, 0.02, 0.01)

LAWS = {
    "Coulomb": sf.Coulomb(mu_s=0.6, mu_k=0.4),
    "viscous": sf.CoulombViscous(mu_s=0.5, mu_k=0.4, s2=0.2),
    "Tustin": sf.Stribeck(mu_s=0.6, mu_k=0.3, vs=0.2),
    "rational": sf.RationalStribeck(mu_s=0.6, d=2.0),
    "cubic": sf.CubicStribeck(mu_s=0.6, mu_m=0.3, vm=1.5),
}


def coefficient(law):
    """The friction coefficient by hand."""
    p = law.values
    return {
        "Coulomb": lambda s: p["mu_k"] + 0 * s,
        "CoulombViscous": lambda s: p["mu_k"] + p["s2"] * s,
        "Stribeck": lambda s: p["mu_k"] + (p["mu_s"] - p["mu_k"]) * np.exp(-s / p["vs"]),
        "RationalStribeck": lambda s: p["mu_s"] / (1 + p["d"] * s),
        "CubicStribeck": lambda s: (
            p["mu_s"] + (p["mu_s"] - p["mu_m"]) * ((s / p["vm"]) ** 3 - 3 * s / p["vm"]) / 2
        ),
    }[type(law).__name__]


MASS = np.diag([1.0, 2.0])
DAMPING = np.array([[0.1, -0.05], [-0.05, 0.1]])
STIFFNESS = np.array([[3.0, -1.0], [-1.0, 2.0]])
RATE = 2 * np.pi * 0.15


def brakes(law):
    """Two masses, a pulsating normal force, a belt and a wall that couples them: both ways."""
    contacts = [
        sf.FrictionContact("a", law, sf.ModulatedLoad(Ns=1.0, Nd=0.4), Vd=0.3, name="belt"),
        sf.FrictionContact({"b": 1.0, "a": -0.2}, law, load=0.4, Vd=0.0, name="wall"),
    ]
    force = sf.HarmonicForce("b", F=0.6)
    model = sf.Structure(
        MASS, DAMPING, STIFFNESS, names="a b", contacts=contacts, forcing=force, f=0.15
    )

    def push(t, q):
        return np.array([0.0, 0.6 * np.cos(RATE * t)]) - q @ STIFFNESS

    def pulsating(t, _):
        return np.asarray(1 + 0.4 * np.cos(RATE * t))

    mu = coefficient(law)
    by_hand = [
        Contact(np.array([[1.0, 0.0]]), np.array([0.3]), pulsating, mu, law.stiction),
        Contact(np.array([[-0.2, 1.0]]), np.array([0.0]), constant(0.4), mu, law.stiction),
    ]
    return model, System(MASS, DAMPING, push, by_hand)


def gaps(motion, system, end, halvings, length=1.0):
    """Mean distance of the paths over the first `end` seconds, one a step, in units of `length`."""
    found = []
    for h in halvings:
        steps = round(end / h)
        n = len(motion.model.states) // 2
        start = length * motion.states[0]
        other = march(system, start[:n], start[n:], (0, end), steps)
        exact = motion.at(np.linspace(0, end, steps + 1))[:, :n]
        found.append(np.abs(other.q / length - exact).mean())
    return np.array(found)


def assert_first_order(found, most):
    """Errors at halved steps are halved each time, on the whole, and below `most` at the last."""
    assert found[-1] < most
    assert np.log2(found[0] / found[-1]) > len(found) - 1.6


OFTEN = ("Coulomb", "Tustin")
"""The others are among the random parameters of every run, and held against Moreau in long ones."""


@pytest.mark.parametrize(
    "law",
    [
        pytest.param(law, marks=[] if name in OFTEN else pytest.mark.long, id=name)
        for name, law in LAWS.items()
    ],
)
def test_two_masses_with_two_contacts(law):
    model, system = brakes(law)
    motion = sf.simulate(model, math.ceil(END * 0.15))
    assert {item.state for item in motion.sticking.intervals} == {"stick", "slip"}
    assert_first_order(gaps(motion, system, END, HALVINGS), 3e-3)


@pytest.mark.parametrize(
    ("pulsation", "speed", "static", "start"),
    [
        (0.9, 0.02, 0.5, [0.0, 0.0, 0.0, 0.0]),
        (0.9, 0.02, 0.6, [0.5, 0.0, 0.0, 5.0]),
        (0.4, 0.0, 0.6, [1.5, 0.0, 0.0, 10.0]),
    ],
)
def test_the_oscillator_in_the_plane(pulsation, speed, static, start):
    motion = sf.simulate(sliding(pulsation, speed, static), 4, start)
    states = [item.state for item in motion.sticking.intervals]
    assert states[:2] == ["slip", "stick"]
    by_hand = planar_by_hand(Nd=pulsation, Vd=speed, mu=0.5, mu_s=static, f=12.5)
    assert_first_order(gaps(motion, by_hand, 0.32, (8e-4, 4e-4, 2e-4), motion.model.L), 1e-3)
