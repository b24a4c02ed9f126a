"""Systems that stick and slip, written by hand for Moreau's time-stepping."""

import numpy as np

from helpers.by_hand.sliding import BASE
from helpers.moreau import Contact, System


def constant(value):
    """A load, or a coefficient, that is always the same."""
    return lambda *_: np.asarray(value)


def sliding(**given):
    """The sliding oscillator in meters, x before y; values may be arrays, a motion each."""
    p = {**BASE, "mu_s": given.get("mu", BASE["mu"]), **given}
    m1 = p["k1"] / (2 * np.pi * p["f1"]) ** 2
    m2 = p["k2"] / (2 * np.pi * p["f2"]) ** 2
    c1 = 4 * np.pi * p["zeta1"] * m1 * p["f1"]
    c2 = 4 * np.pi * p["zeta2"] * m2 * p["f2"]
    springs, pulled = np.array([p["k2"], p["k1"]]), np.array([0.0, p["L"]])

    def force(_, q):
        arm = q + pulled
        length = np.sqrt(np.sum(arm * arm, axis=-1, keepdims=True))
        return -springs * q - p["kext"] * (1 - p["L"] / length) * arm

    def load(time, _):
        return p["Ns"] + p["Nd"] * np.cos(2 * np.pi * p["f"] * time)

    direction = np.array([np.cos(p["alpha"]), np.sin(p["alpha"])])
    plate = np.asarray(p["Vd"])[..., None] * direction
    contact = Contact(np.eye(2), plate, load, constant(p["mu"]), np.asarray(p["mu_s"]))
    return System(np.diag([m2, m1]), np.diag([c2, c1]), force, [contact])


def duffing_on_belt(frequency, forces):
    """x'' + 0.1 x' + x + 0.3 x^3 = A cos(W t) + 0.4 sgn(1 - x'); the forces A run side by side."""
    forces = np.reshape(forces, (-1, 1))
    contact = Contact(np.eye(1), np.ones(1), constant(1.0), constant(0.4), 0.4)

    def force(t, q):
        return forces * np.cos(frequency * t) - q - 0.3 * q**3

    return System(np.eye(1), 0.1 * np.eye(1), force, [contact])
