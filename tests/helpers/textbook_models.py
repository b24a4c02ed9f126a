"""Textbook systems as models: nothing in flow, orbits and branches may know the sliding oscillator.

Their parameter `w` is the circular frequency of the forcing, so that the period is 2 pi/w.
"""

import math

import heyoka as hy

from slipfold import Model, Output, Parameter, State

OMEGA = Parameter("w", 1.0, "rad/s", "circular frequency", lower=0, lower_open=True)


class _Oscillator(Model):
    """q'' = acceleration(q, v, phase)."""

    states = (State("q"), State("v"))

    def coefficients(self, p):
        return {name: p[name] for name in p}

    def rates(self, q, c, phase):
        force = self.acceleration(q["q"], q["v"], c, hy.cos(2 * math.pi * phase))
        return {"q": q["v"], "v": force}

    def period(self, p):
        return 2 * math.pi / p["w"]


class Duffing(_Oscillator):
    """q'' + d q' + k q + g q^3 = a cos(w t)."""

    name = "duffing"
    forcing_amplitude = "a"
    parameters = (
        OMEGA,
        Parameter("d", 0.05),
        Parameter("k", 1.0),
        Parameter("g", 0.1),
        Parameter("a", 0.18),
    )

    def acceleration(self, q, v, c, wave):
        return c["a"] * wave - c["d"] * v - c["k"] * q - c["g"] * q * q * q


class Mathieu(_Oscillator):
    """x'' + 2 z x' + (1 + h cos(w t)) x + g x^3 = 0."""

    name = "mathieu"
    forcing_amplitude = "h"
    parameters = (
        Parameter("w", 2.0, "rad/s", "circular frequency", lower=0, lower_open=True),
        Parameter("z", 0.01),
        Parameter("h", 0.0),
        Parameter("g", 1.0),
    )

    def acceleration(self, q, v, c, wave):
        return -2 * c["z"] * v - (1.0 + c["h"] * wave) * q - c["g"] * q * q * q


class VanDerPol(_Oscillator):
    """x'' - e (1 - x^2) x' + x = a cos(w t)."""

    name = "vanderpol"
    forcing_amplitude = "a"
    parameters = (OMEGA, Parameter("e", 0.2), Parameter("a", 0.3))

    def acceleration(self, q, v, c, wave):
        return c["a"] * wave + c["e"] * (1.0 - q * q) * v - q


class Pitchfork(_Oscillator):
    """q'' + d q' + (k + b cos(w t)) q + q^3 = 0: at k = 0 and b = 0 rest loses stability."""

    name = "pitchfork"
    parameters = (
        Parameter("w", 5.0, "rad/s", "circular frequency", lower=0, lower_open=True),
        Parameter("d", 0.3),
        Parameter("k", 1.0),
        Parameter("b", 0.5),
    )

    def acceleration(self, q, v, c, wave):
        return -c["d"] * v - (c["k"] + c["b"] * wave) * q - q * q * q


class Decoupled(Model):
    """Two linear modes of rates r and s, pulled around by a force: multipliers exp(r T), exp(s T).

    Their product passes one where r + s = 0: a neutral saddle, which is no torus bifurcation.
    """

    name = "decoupled"
    states = (State("u"), State("w"))
    parameters = (Parameter("r", 0.5), Parameter("s", -1.0), Parameter("a", 0.2))

    def coefficients(self, p):
        return {name: p[name] for name in p}

    def rates(self, q, c, phase):
        wave = c["a"] * hy.cos(2 * math.pi * phase)
        return {
            "u": c["r"] * q["u"] + wave,
            "w": c["s"] * q["w"] + wave + 0.1 * q["u"] * q["u"],
        }

    def period(self, p):
        return 1.0 + 0.0 * p["r"]


class Torus(Model):
    """z' = (m + i v) z - n |z|^2 z, seen every second: the normal form of a torus itself."""

    name = "torus"
    states = (State("x"), State("y"))
    parameters = (Parameter("m", -0.5), Parameter("v", 1.0), Parameter("n", 1.0))

    def coefficients(self, p):
        return {name: p[name] for name in p}

    def rates(self, q, c, phase):
        size = q["x"] * q["x"] + q["y"] * q["y"]
        # The phase appears nowhere: rest is the orbit.
        return {
            "x": c["m"] * q["x"] - c["v"] * q["y"] - c["n"] * size * q["x"],
            "y": c["m"] * q["y"] + c["v"] * q["x"] - c["n"] * size * q["y"],
        }

    def period(self, p):
        return 1.0 + 0.0 * p["m"]

    def outputs(self):
        return (Output("square", lambda q, c, phase: q["x"] * q["x"] + q["y"] * q["y"]),)
