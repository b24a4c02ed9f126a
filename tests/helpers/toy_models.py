"""Small models with known answers; they use nothing but what any subclass of Model may."""

import math

import heyoka as hy
import numpy as np

import slipfold as sf
from slipfold import Limit, Model, Output, Parameter, State


class LinearOscillator(Model):
    """x'' + 2 zeta w0 x' + w0^2 x = a cos(2 pi f t)."""

    name = "linear"
    forcing_amplitude = "a"
    states = (State("x", "m"), State("v", "m/s"))
    parameters = (
        Parameter("f0", 1.0, "Hz", "natural frequency", lower=0, lower_open=True),
        Parameter("zeta", 0.05, "", "damping ratio", lower=0),
        Parameter("a", 1.0, "m/s^2", "amplitude of the forcing"),
        Parameter("f", 1.3, "Hz", "forcing frequency", lower=0, lower_open=True),
    )

    def coefficients(self, p):
        w0 = 2 * math.pi * p["f0"]
        return {"stiffness": w0 * w0, "damping": 2 * p["zeta"] * w0, "a": p["a"]}

    def rates(self, q, c, phase):
        force = c["a"] * hy.cos(2 * math.pi * phase)
        return {"x": q["v"], "v": force - c["damping"] * q["v"] - c["stiffness"] * q["x"]}

    def period(self, p):
        return 1.0 / p["f"]

    def outputs(self):
        return (Output("energy", _energy, "J/kg"),)

    def exact(self, time, state=(0.0, 0.0)):
        """Closed form, shape (m, 2)."""
        w0, w, zeta = 2 * np.pi * self.f0, 2 * np.pi * self.f, self.zeta
        a = self.response_amplitude()
        t = np.asarray(time, dtype=float)
        decay, wd = zeta * w0, w0 * np.sqrt(1 - zeta**2)
        b1 = state[0] - a.real
        b2 = (state[1] - (1j * w * a).real + decay * b1) / wd
        cos, sin, fade = np.cos(wd * t), np.sin(wd * t), np.exp(-decay * t)
        turning = np.exp(1j * w * t)
        x = (a * turning).real + fade * (b1 * cos + b2 * sin)
        v = (1j * w * a * turning).real + fade * (
            (b2 * wd - decay * b1) * cos - (b1 * wd + decay * b2) * sin
        )
        return np.stack([x, v], axis=-1)

    def response_amplitude(self):
        """Complex amplitude of the steady response."""
        w0, w = 2 * np.pi * self.f0, 2 * np.pi * self.f
        return self.a / (w0**2 - w**2 + 2j * self.zeta * w0 * w)


def _energy(q, c, phase):
    return 0.5 * (q["v"] * q["v"] + c["stiffness"] * q["x"] * q["x"])


class Runaway(Model):
    """x' = x^2: singular at t = 1/x(0)."""

    name = "runaway"
    states = (State("x"),)
    parameters = (Parameter("f", 1.0, "Hz", "forcing frequency", lower=0, lower_open=True),)

    def coefficients(self, p):
        return {}

    def rates(self, q, c, phase):
        return {"x": q["x"] * q["x"]}

    def period(self, p):
        return 1.0 / p["f"]


class Falling(Model):
    """x' = v, v' = -1: valid above x = 0 only."""

    name = "falling"
    states = (State("x"), State("v"))
    parameters = (Parameter("f", 1.0, "Hz", "forcing frequency", lower=0, lower_open=True),)
    limits = (
        Limit("far", "distance", -100.0, "too far"),
        Limit("ground", "x", 0.0, "hit the ground at x = {value:.3g}"),
    )

    def coefficients(self, p):
        return {"g": 1.0}

    def rates(self, q, c, phase):
        return {"x": q["v"], "v": -c["g"] + 0.0 * q["x"]}

    def period(self, p):
        return 1.0 / p["f"]

    def outputs(self):
        return (Output("distance", lambda q, c, phase: -q["x"]),)


FLOOR = sf.System(
    name="floor",
    parameters={"F": 1.0, "W": 2.0},
    states={"x": "v", "v": "F*cos(W*t) - x - 0.1*v"},
    forcing={"period": "2*pi/W"},
    outputs={"room": "x + 1"},
    limits={"floor": {"output": "room", "bound": 0.0}},
)
"""A mass that is driven against a floor, where it stops."""


def chain(size, law, speed=0.0, damping=0.001):
    """Masses between springs: a force at one end, friction and a hardening spring at the other."""
    stiffness = 100.0 * (2 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1))
    return sf.Structure(
        np.eye(size),
        sf.ProportionalDamping(0.1, damping),
        stiffness,
        elements=sf.CubicSpring(f"q{size}", k3=10.0),
        contacts=sf.FrictionContact(f"q{size}", law, load=2.0, Vd=speed),
        forcing=sf.HarmonicForce("q1", F=2.0),
    ).replace(f=0.6)
