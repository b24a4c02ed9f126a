"""Motions that nothing forces: on what they settle, and what is said where they do not."""

import json
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf
from slipfold.models.registry import model_named


def system(start, **rates):
    states = {
        name: {"rate": rate, "start": value}
        for (name, rate), value in zip(rates.items(), start, strict=True)
    }
    return sf.System(name="own", states=states)


def said(model, **options):
    return sf.simulate(model, **options).settlement


# -- cycles -----------------------------------------------------------------------------------


def test_van_der_pols_cycle_is_settled_on_with_its_period():
    found = said(model_named("vanderpol-free"))
    assert (found.settled, found.kind, found.period) == (True, "cycle", 1)
    assert found.duration == pytest.approx(6.663286859323, rel=1e-11)
    assert found.message.startswith("settled on a cycle of 6.66328686 s (0.150076 Hz)")


def test_a_squealing_structure_settles_on_the_cycle_that_newton_finds():
    motion = sf.simulate(model_named("squeal", mu=1.0))
    cycle = sf.periodic_orbit(
        motion.model, state=motion.states[-1], duration=motion.settlement.duration
    )
    assert motion.settlement.duration == pytest.approx(cycle.duration, rel=1e-9)
    assert "forcing" not in motion.settlement.message + motion.summary()


@pytest.fixture(scope="module")
def relaxation():
    """Duration of a relaxation oscillation by an implicit method."""
    crossings = solve_ivp(
        lambda t, q: [q[1], 20 * (1 - q[0] ** 2) * q[1] - q[0]],
        (0, 120), [2.0, 0.0], "Radau", rtol=1e-7, atol=1e-9,
        events=lambda t, q: q[0],
    ).t_events[0]  # fmt: skip
    return crossings[-1] - crossings[-3]


@pytest.mark.parametrize("unit", [1e-5, 1.0, 1e4])
def test_a_relaxation_oscillation_in_any_unit_of_time(unit, relaxation):
    rate = f"(20*(1 - x^2)*v - x)/{unit!r}"
    found = said(system((2.0, 0.0), x=f"v/{unit!r}", v=rate))
    assert found.kind == "cycle"
    assert found.duration == pytest.approx(unit * relaxation, rel=1e-5)


def test_lines_of_a_cycle_are_multiples_of_its_frequency():
    motion = sf.simulate(model_named("stuart-landau", r=0.25, w=3.0))
    spectrum = motion.spectrum(4)
    assert spectrum.frequency[4] == pytest.approx(3 / (2 * np.pi), rel=1e-9)
    assert spectrum.line("x", 1.0) == pytest.approx(0.5, rel=1e-8)
    assert spectrum.line("x", 2.0) == pytest.approx(0.0, abs=1e-12)
    record = json.loads(json.dumps(motion.to_json()))
    assert record["duration"] == pytest.approx(2 * np.pi / 3, rel=1e-9)
    assert (record["kind"], record["period"]) == ("cycle", 1)


# -- equilibria -------------------------------------------------------------------------------


def test_a_focus_is_an_equilibrium():
    found = said(system((1.0, 0.0), x="v", v="-x - 0.1*v"))
    assert (found.settled, found.kind, found.duration) == (True, "equilibrium", None)


@pytest.mark.parametrize(
    ("model", "kind"),
    [(model_named("vanderpol-free"), "cycle"), (model_named("squeal", mu=1.0), "cycle")],
)
def test_a_start_on_an_unstable_equilibrium_is_left(model, kind):
    found = said(model, state=np.zeros(len(model.states)))
    assert found.kind == kind
    assert "It began on an unstable equilibrium and was pushed off it by 1e-06" in found.message


def test_a_motion_that_comes_to_a_saddle_is_pushed_off_it():
    found = said(system((0.0, 1.0), x="x - x^3", y="-y"))
    assert found.kind == "equilibrium"
    assert "it had reached an unstable equilibrium" in found.message.replace("At", "at")


def test_a_slow_focus_says_how_long_it_takes():
    focus = system((1.0, 0.0), x="v", v="-x - 2e-3*v")
    found = said(focus, periods=5000)
    assert not found.settled
    more = float(found.message.split("about ")[1].split()[0])
    assert math.exp(-1e-3 * (5000 + more)) == pytest.approx(1e-9, rel=0.5)


# -- neither ----------------------------------------------------------------------------------


def test_a_center_is_not_settled_on():
    found = said(system((2.0, 0.0), x="v", v="-sin(x)"), periods=2000)
    assert (found.settled, found.kind, found.period) == (False, None, None)
    assert "nothing attracts the trajectory to it" in found.message


@pytest.mark.parametrize(
    "model",
    [
        model_named("lorenz"),
        system(
            (1.0, 0.0, 1.0, 0.0),
            x="v", v="(1 - x^2)*v - x", y="w", w="(1 - y^2)*w - 3.3*y",
        ),
    ],
    ids=["chaos", "torus"],
)  # fmt: skip
def test_chaos_and_tori_are_not_settled(model):
    found = said(model, periods=1500)
    assert not found.settled
    assert "does not shrink; a torus, chaos" in found.message


@pytest.mark.parametrize("growth", [0.05, 5.0])
def test_growth_without_bound_ends(growth):
    motion = sf.simulate(system((1.0, 0.0), x="v", v=f"-x + {growth}*v"))
    assert motion.stopped.kind == "unbounded"
    assert "grows without bound" in str(motion.settlement)


# -- time -------------------------------------------------------------------------------------


def test_a_motion_that_becomes_fast_is_kept_more_finely():
    chirp = system((1.0, 0.0, 0.01), x="s*v", v="-s*x - 0.001*v", s="s*(1 - s/3e4)")
    motion = sf.simulate(chirp, 40, duration=1.0)
    assert motion.stopped is None
    assert motion.duration == pytest.approx(40.0)
