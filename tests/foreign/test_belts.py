"""Masses on belts and under contacts with memory: what moves them is steep, fast, or both."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf
from helpers.dry_friction import belt
from slipfold import PeriodicOrbit

STRIBECK = sf.Stribeck(mu_s=0.5, mu_k=0.3, vs=0.2)
LAWS = {
    "tanh": sf.Regularized(STRIBECK, "tanh"),
    "atan": sf.Regularized(STRIBECK, "atan"),
    "sqrt": sf.Regularized(STRIBECK, "sqrt"),
    "rational": sf.Regularized(sf.RationalStribeck(mu_s=0.5, d=3.0)),
    "cubic": sf.Regularized(sf.CubicStribeck(mu_s=0.5, mu_m=0.3, vm=0.5)),
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
    if isinstance(law, sf.Jenkins):
        along, width = law.kt / law.mu_k * slip * z, law.kt / law.mu_k * law.e
        knee = (abs(z) ** (law.exponent - 2) + 1e-4) / (1 + 1e-4)
        loading = 0.5 * (along + np.hypot(along, width)) * knee
        return law.kt / law.mu_k * slip - loading * z, law.mu_k * z
    level = 0.3 + 0.2 * np.exp(-((slip / 0.2) ** 2)) if isinstance(law, sf.LuGre) else law.mu_k
    rate = slip - law.s0 * np.hypot(slip, law.e) * z / level
    return rate, law.s0 * z + (law.s1 * rate if isinstance(law, sf.LuGre) else 0.0)


RARELY = ("atan", "sqrt", "rational", "cubic")


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.long] * (name in RARELY)) for name in LAWS],
)
def test_a_stick_slip_cycle_is_found_followed_and_what_an_implicit_integrator_has(name):
    law, load = LAWS[name], 4.0
    model = belt(law, 0.3, 0.4, load=load, stiffness=100.0)
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


@pytest.mark.long
@pytest.mark.parametrize(
    "law", [sf.Jenkins(kt=1e5), sf.LuGre(mu_s=0.5, vs=0.2, s0=1e5), sf.Dahl(s0=1e5)]
)
def test_the_response_of_stiff_friction_in_large_reversing_slip_is_found_and_followed(law):
    # The slider of the first gives way within a millionth of the period: no response was found.
    model = belt(law, 0.0, 0.1, stiffness=100.0, force=30, f=1.0)
    diagram = sf.response(model, vary="f", span=(1.0, 1.05))
    (branch,) = diagram.branches
    assert (branch.stopped.kind, diagram.checked.agree) == ("span", True)

    def rates(t, q):
        rate, mu = bristles(law, -q[1], q[2])
        push = 30 * np.cos(2 * np.pi * 1.05 * t)
        return [q[1], push - 0.1 * q[1] - 100 * q[0] + mu, rate]

    first = branch.nodes[-1, 0]
    end = solve_ivp(rates, (0, 1 / 1.05), first, method="Radau", rtol=1e-10, atol=1e-12).y[:, -1]
    assert end == pytest.approx(first, rel=1e-6)
    assert branch.extrema.of("vx")[1][-1] > 3


@pytest.mark.long
def test_a_cycle_with_stiff_bristles_is_settled_on():
    # Ten thousand Taylor steps are a round: too few rounds were seen to tell.
    law, load, speed = sf.LuGre(mu_s=0.5, mu_k=0.3, vs=0.2, s0=1e5), 4.0, 0.3
    motion = sf.simulate(belt(law, speed, 0.4, load=load, stiffness=100.0))
    assert motion.settlement.kind == "cycle"
    start = motion.states[-1]

    def rates(t, q):
        rate, mu = bristles(law, speed - q[1], q[2])
        return [q[1], load * mu - 0.4 * q[1] - 100 * q[0], rate]

    span = (0.0, motion.settlement.duration)
    end = solve_ivp(rates, span, start, method="Radau", rtol=1e-9, atol=1e-13).y[:, -1]
    assert end == pytest.approx(start, rel=1e-5)


NEAR_A_CLOSING = [
    [-0.061990988, 0.081217241, 3.0000149e-05],
    [0.090874339, -0.084903029, 3e-05],
    [-0.062054469, 0.081161423, 3.0000149e-05],
    [0.090861941, -0.084916700, 3e-05],
    [-0.062042824, 0.081174035, 3.0000149e-05],
    [0.090892480, -0.084896234, 3e-05],
    [-0.062071507, 0.081155374, 3.0000149e-05],
    [0.090806751, -0.084963782, 3e-05],
]
"""A cycle of four rounds, at eight phases, shortly before its branch closes."""


@pytest.mark.long
def test_a_doubling_just_before_a_branch_closes_is_found_and_where_it_closes_is_known():
    # Its halves then differ by 3e-4 only. Missed, the doubling's own branch closed on nothing.
    law = sf.LuGre(mu_s=0.5, mu_k=0.3, vs=0.2, s0=1e4)
    model = belt(law, 0.76801010973, 0.4, load=4.0, stiffness=100.0)
    nodes, around = np.array(NEAR_A_CLOSING), np.ones(3, dtype=complex)
    given = PeriodicOrbit(model.replace(duration=0.628832038789), 4, nodes, around, np.nan)
    settings = sf.Settings(largest_period=4)
    diagram = sf.response(given, vary="Vd", span=(0.76801010973, 0.8), settings=settings)
    (branch,) = diagram.branches
    (found,) = branch.special
    assert (found.type, diagram.checked.agree) == ("PD", True)
    # The cycle of two rounds is followed to its doubling, and that branch away from it.
    assert found.value == pytest.approx(0.76995381384, abs=1e-9)
    (closed,) = branch.stopped.values
    assert closed == pytest.approx(0.77014492205, abs=1e-6)
