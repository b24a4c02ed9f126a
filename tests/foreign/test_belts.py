"""Masses on belts and under contacts with memory: what moves them is steep, fast, or both."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf

STRIBECK = sf.Stribeck(mu_s=0.5, mu_k=0.3, vs=0.2)
LAWS = {
    "tanh": sf.Regularised(STRIBECK, "tanh"),
    "atan": sf.Regularised(STRIBECK, "atan"),
    "sqrt": sf.Regularised(STRIBECK, "sqrt"),
    "rational": sf.Regularised(sf.RationalStribeck(mu_s=0.5, d=3.0)),
    "cubic": sf.Regularised(sf.CubicStribeck(mu_s=0.5, mu_m=0.3, vm=0.5)),
    "LuGre": sf.LuGre(mu_s=0.5, mu_k=0.3, vs=0.2),
}
RISES = {"tanh": np.tanh, "atan": lambda s: 2 / np.pi * np.arctan(s)}
RISES["sqrt"] = lambda s: s / np.sqrt(1 + s * s)


def coefficient(law, slip):
    """Written out here once more: the formulas of the laws are what is tested."""
    v = abs(slip)
    if isinstance(law.law, sf.Stribeck):
        steady = 0.3 + 0.2 * np.exp(-v / 0.2)
    elif isinstance(law.law, sf.RationalStribeck):
        steady = 0.5 / (1 + 3 * v)
    else:
        steady = 0.5 - 0.2 * (v / 0.5) * (1.5 - 0.5 * (v / 0.5) ** 2)
    return steady * RISES[law.shape](slip / 1e-3)


def bristles(law, slip, z):
    level = 0.3 + 0.2 * np.exp(-((slip / 0.2) ** 2)) if isinstance(law, sf.LuGre) else law.mu_k
    rate = slip - law.s0 * np.hypot(slip, law.e) * z / level
    return rate, law.s0 * z + (law.s1 * rate if isinstance(law, sf.LuGre) else 0.0)


@pytest.mark.parametrize("name", LAWS)
def test_a_stick_slip_cycle_is_found_followed_and_what_an_implicit_integrator_has(name):
    law, load = LAWS[name], 4.0
    belt = sf.FrictionContact("x", law, load=load, Vd=0.3)
    model = sf.Structure([[1.0]], [[0.4]], [[100.0]], names="x", contacts=belt)
    (branch,) = sf.response(model, vary="Vd", span=(0.3, 0.2), settled=True).branches
    assert branch.stopped.kind == "span"
    last = branch.nodes[-1, 0]

    def rates(t, q):
        slip = 0.2 - q[1]
        if isinstance(law, sf.LuGre):
            rate, mu = bristles(law, slip, q[2])
            return [q[1], load * mu - 0.4 * q[1] - 100 * q[0], rate]
        return [q[1], load * coefficient(law, slip) - 0.4 * q[1] - 100 * q[0]]

    span = (0.0, branch.durations[-1])
    motion = solve_ivp(rates, span, last, method="Radau", rtol=1e-9, atol=1e-12)
    assert motion.y[:2, -1] == pytest.approx(last[:2], abs=1e-7)
    assert np.ptp(motion.y[0]) > 0.02
    sticks = np.abs(motion.y[1] - 0.2) < 0.01
    assert sticks.any()


@pytest.mark.parametrize("law", [sf.LuGre(mu_s=0.5, vs=0.2, s0=1e5), sf.Dahl(s0=1e5)])
def test_stiff_bristles_in_large_reversing_slip(law):
    # They relax two million times a second where the slip is fastest.
    contact = sf.FrictionContact("x", law, load=1.0, Vd=0.0)
    force = sf.HarmonicForce("x", F=30)
    model = sf.Structure(
        [[1.0]], [[0.1]], [[100.0]], names="x", contacts=contact, forcing=force, f=1.0
    )
    motion = sf.simulate(model, periods=1)

    def rates(t, q):
        rate, mu = bristles(law, -q[1], q[2])
        return [q[1], 30 * np.cos(2 * np.pi * t) - 0.1 * q[1] - 100 * q[0] + mu, rate]

    other = solve_ivp(rates, (0, 1), np.zeros(3), method="Radau", rtol=1e-9, atol=1e-12)
    assert motion.stopped is None
    assert motion.strobe[-1] == pytest.approx(other.y[:, -1], rel=1e-6)
    assert motion.checked.agree
