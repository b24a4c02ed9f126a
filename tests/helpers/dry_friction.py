"""Textbook systems with exact dry friction."""

import math

import numpy as np
from scipy.integrate import solve_ivp

import slipfold as sf

DUFFING_ON_BELT = """
name = "Duffing on a belt"
[parameters]
W = { value = 1.35, above = 0 }
A = 0.8
[states]
x = "v"
v = "F - x - 0.1*v - 0.3*x^3 + A*cos(W*t)"
[contacts.F]
slip = "1.0 - v"
normal = "1.0"
friction = { law = "Coulomb", mu_s = "0.4", mu_k = "0.4" }
[forcing]
period = "2*pi/W"
"""

FORCED_SLIDER = """
name = "forced slider"
parameters = { F = 0.6, W = 1.4, Vd = 1.2 }
[states]
x = "v"
v = "R - x - 0.02*v + F*sin(W*t)"
[forcing]
period = "2*pi/W"
amplitude = "F"
[contacts.R]
slip = "Vd - v"
normal = "1.0"
friction = { law = "Coulomb", mu_s = "0.6", mu_k = "0.3" }
"""
"""A forced mass on a belt; friction is less in slip, so that its responses end where it begins."""


def belt(law, speed=0.2, damping=0.0, *, load=1.0, stiffness=1.0, force=None, **others):
    """A mass of 1 on a belt, or a floor; damping is of the absolute velocity."""
    given = {"contacts": sf.FrictionContact("x", law, load=load, Vd=speed), **others}
    if force is not None:
        given["forcing"] = sf.HarmonicForce("x", F=force)
    damped = [[damping]] if damping else None
    return sf.Structure([[1.0]], damped, [[stiffness]], names="x", **given)


def den_hartog(frequency, slip, stick=None):
    """A mass on a floor, forced: x'' + x = cos(W t) - friction."""
    law = sf.Coulomb(mu_s=slip if stick is None else stick, mu_k=slip)
    return belt(law, 0.0, force=1.0, f=frequency / (2 * math.pi))


def most_load(frequency, mu):
    """The largest load of his orbit without stops, at a frequency in Hz."""
    rate = 2 * np.pi * frequency
    unforced = np.sin(np.pi / rate) / (1 + np.cos(np.pi / rate)) / rate
    return np.abs(1 / (1 - rate**2)) / np.hypot(unforced, rate**-2) / mu


def rubbing(**values):
    """A damped oscillator on a floor, forced, with formulas: its friction is a parameter."""
    return sf.System(
        name="dry oscillator",
        parameters={"W": 0.7, "F": 1.0, "mu": 0.5, **values},
        states={"x": "v", "v": "F*cos(W*t) - 0.1*v - x + R"},
        forcing={"period": "2*pi/W", "amplitude": "F"},
        contacts={
            "R": {
                "slip": "-v",
                "normal": "1",
                "friction": {"law": "Coulomb", "mu_s": "mu", "mu_k": "mu"},
            }
        },
    )


def two_masses(friction=(1.0, 1.3), speed=0.15):
    """Two masses on a belt, coupled with 1.2, under Fs/(1 + 3|v|)."""
    contacts = [
        sf.FrictionContact(name, sf.RationalStribeck(mu_s=most, d=3.0), load=1.0, Vd=speed, name=to)
        for name, most, to in zip(("x1", "x2"), friction, ("first", "second"), strict=True)
    ]
    stiffness = [[2.2, -1.2], [-1.2, 2.2]]
    return sf.Structure([[1, 0], [0, 1]], None, stiffness, names="x1 x2", contacts=contacts)


def sliding(pulsation, speed, static=0.5, **values):
    """The oscillator at 12.5 Hz with exact planar friction, mu_k = 0.5."""
    law = sf.Coulomb(mu_s=static, mu_k=0.5)
    return sf.SlidingOscillator(friction=law, f=12.5, Nd=pulsation, Vd=speed, **values)


def highest_after_a_touch(speed, kinetic):
    """The next largest velocity of the mass, over the belt's, from a touch of Vrel = 0."""

    def rates(time, state):
        x, v = state
        friction = kinetic + (1 - kinetic) * np.exp(-abs((speed - v) / 0.5))
        return v, friction - 0.1 * v - x

    def turns(time, state):
        return rates(time, state)[1]

    turns.direction, turns.terminal = -1, True
    # Friction is 1 at the touch, where the velocity stands still.
    start, exact = (1 - 0.1 * speed, speed), {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}
    first = solve_ivp(rates, (0, 1), start, **exact)
    motion = solve_ivp(rates, (1, 20), first.y[:, -1], events=turns, **exact)
    return motion.y[1, -1] - speed


def shaken_across(load, stiffness, damping, *, force, frequency):
    """A mass shaken across its belt: it swings linearly about Ns/(k + kn), and slips along."""
    contact = sf.FrictionContact(
        "x",
        sf.Coulomb(mu_s=0.5, mu_k=0.5),
        load=sf.ContactLoad("y", Ns=load, kn=stiffness),
        Vd=0.3,
    )
    return sf.Structure(
        np.eye(2),
        damping * np.eye(2),
        np.eye(2),
        names="x y",
        contacts=contact,
        forcing=sf.HarmonicForce("y", F=force),
        f=frequency,
    )
