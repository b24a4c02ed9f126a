"""What a structure in meters is measured in: a pin vibrates by micrometres, a tower by more."""

import math

import numpy as np
import pytest
from scipy.integrate import LSODA, OdeSolver

import slipfold as sf
from slipfold.bifurcations.branches.response import trace_response
from slipfold.flow.flow import Flow
from slipfold.flow.modal_equations import CHOICE
from slipfold.flow.scales import measured


@pytest.mark.parametrize("size", [1e-6, 1e-4, 1e-2, 1.0, 10.0, 1e4])
def test_squeal_does_not_depend_on_the_unit_of_length(size):
    # All lengths shrink and the belt slows down with them: the same motion, smaller.
    def pin(stiffness: float) -> sf.Structure:
        law = sf.Stribeck(mu_s=0.6, mu_k=0.3, vs=0.4 * size)
        contact = sf.FrictionContact(("u", "w"), law, load=5.0 * size, Vd=2.0 * size)
        return sf.Structure(
            0.05 * np.eye(2),
            0.4 * np.eye(2),
            np.diag([stiffness, 1.3 * stiffness]),
            names=("u", "w"),
            contacts=contact,
        )

    still, cycles = trace_response(pin(2000.0), "Vd", (2 * size, 0.5 * size))
    (hopf,) = still.special
    exact = 0.4 * size * math.log(5 * 0.3 / (0.4 * 0.4))
    assert hopf.value == pytest.approx(exact, rel=1e-10)
    assert hopf.leads_to == cycles.id
    assert cycles.stopped.kind == "limit"
    assert cycles.stopped.value / size == pytest.approx(1.381596529, rel=1e-7)


def test_a_load_that_grows_a_thousand_times_takes_few_points():
    # At rest nothing bends and nothing moves, so that only the state of rest has a size.
    law = sf.Stribeck(mu_s=0.6, mu_k=0.3, vs=0.4)
    belt = sf.FrictionContact("tip", law, load=5.0, Vd=2.0)
    brake = sf.Structure([[0.05]], [[0.4]], [[2000.0]], names=("tip",), contacts=belt)
    (still,) = sf.response(brake, vary="Ns", span=(0.005, 10)).branches
    assert still.stopped.kind == "span"
    assert len(still) < 50
    mu = 0.3 + 0.3 * math.exp(-2.0 / 0.4)
    assert still.nodes[-1, 0] == pytest.approx([10 * mu / 2000, 0], rel=1e-9, abs=1e-12)


def test_a_branch_that_ends_for_a_fast_mode_says_so():
    stiff, damped = 1e7 * np.array([[1, -1], [-1, 1]]), 0.3 * np.array([[1, -1], [-1, 1]])
    structure = sf.Structure(
        np.eye(2), damped + np.diag([0.6, 0]), stiff + np.diag([1000, 0]), names=("a", "b"),
        elements=sf.CubicSpring("a", k3="1e5 N/m^3"), forcing=sf.HarmonicForce("a", "1 N"),
    )  # fmt: skip
    few = sf.Settings(steps=sf.Steps(points=10))
    (branch,) = sf.response(structure, "f", (2, 8), settings=few).branches
    ratio = np.sqrt(2e7) / (2 * np.pi) / branch.parameter[-1]
    said = branch.stopped.reason.split("; a mode ")[1].split(" times as fast as the orbit ")[0]
    assert int(said) == pytest.approx(ratio, abs=1)


def test_a_fast_mode_that_decays_within_a_period_is_not_why_a_branch_ends():
    states = {"x": "v", "v": "-x - 0.05*v - 0.1*x^3 + cos(w*t)", "y": "u", "u": "x - 1e4*y - 100*u"}
    system = sf.System(parameters={"w": 1}, forcing={"period": "2*pi/w"}, states=states)
    few = sf.Settings(steps=sf.Steps(points=3))
    (branch,) = sf.response(system, "w", (0.8, 1.2), settings=few).branches
    assert branch.stopped.reason == "3 points were not enough; allow more points"


def test_several_modes_of_a_chain_may_begin_to_squeal_in_one_step():
    # With twenty states test functions are 1e-30 everywhere; the eigenvalues say what is lost.
    n = 10
    stiffness = 100.0 * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    stiffness[-1, -1] = 100.0
    damping = 0.05 * np.eye(n) + 0.0005 * stiffness
    belt = sf.FrictionContact("q10", sf.Stribeck(mu_s=0.5, mu_k=0.3, vs=0.4), load=10.0, Vd=3.0)
    chain = sf.Structure(np.eye(n), damping, stiffness, contacts=belt)
    settings = sf.Settings(steps=sf.Steps(points=8))
    still = sf.response(chain, vary="Vd", span=(3, 0.8), settings=settings).branches[0]
    assert [point.type for point in still.special] == ["HB"] * 3

    def growths(speed: float) -> np.ndarray:
        c = damping.copy()
        c[-1, -1] += -10 * 0.2 / 0.4 * np.exp(-speed / 0.4)
        matrix = np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, -c]])
        return np.linalg.eigvals(matrix).real

    for point in still.special:
        assert np.abs(growths(point.value)).min() < 1e-11


def test_a_dry_contact_at_rest_hides_no_natural_frequency():
    # Its friction has no derivative there: steps along a resonance were lengths of velocities alone
    model = sf.Structure(
        np.eye(2),
        sf.ProportionalDamping(beta_K=1e-4),
        [[2e4, -1e4], [-1e4, 2e4]],
        contacts=sf.FrictionContact("q2", sf.Coulomb(mu_k=0.3), load=1.0, Vd=0.0),
        forcing=sf.HarmonicForce("q1", F=3.0),
    )
    sizes = measured(model.replace(f=0.97 * model.natural_frequencies[0]))
    for scales in (sizes.state_scales(), sizes.step_scales()):
        assert np.log2(scales[2:] / scales[:2] / 100) == pytest.approx(0.0, abs=1)


def test_rounding_of_a_mean_force_couples_no_modes():
    # A rest of 1e-19 m bent the cubic spring: lengths were measured in units of 1e13 m.
    model = sf.Structure(
        np.eye(4),
        sf.ModalDamping(0.005),
        np.diag([9.4e3, 3.7e5, 2.9e6, 1.7e7]),
        elements=sf.CubicSpring({"q1": 7.0, "q2": -7.0, "q3": 7.0, "q4": -4.0}, k3=1e6),
        forcing=sf.HarmonicForce({"q1": 7.0, "q2": -7.0, "q3": 7.0, "q4": -4.0}, F=0.5),
    )
    for frequency in (10.0, 11.0, 12.0):
        scales = measured(model.replace(f=frequency)).state_scales()
        per_turn = scales[4:] / scales[:4] / (math.tau * model.natural_frequencies)
        assert np.log2(per_turn) == pytest.approx(0.0, abs=1)


def test_scales_of_many_modes_need_no_compiled_integrator(monkeypatch):
    law = sf.Regularized(sf.Coulomb(mu_k=0.3), e=0.01)
    chain = sf.Structure(
        np.eye(3),
        sf.ProportionalDamping(beta_K=2e-3),
        100.0 * (2 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)),
        contacts=sf.FrictionContact("q3", law, load=1.0, Vd=0.0),
        forcing=sf.HarmonicForce("q1", F=3.0),
        f=1.1,
    )
    by_flow = measured(chain)
    monkeypatch.setattr(CHOICE, "states", 0)
    monkeypatch.setattr(Flow, "trajectory", None)
    by_modes = measured(chain)
    np.testing.assert_array_equal(by_modes.state_scales(), by_flow.state_scales())
    np.testing.assert_array_equal(by_modes.step_scales(), by_flow.step_scales())


def test_a_trial_that_escapes_ends_there(monkeypatch):
    # The spring softens until nothing holds the mass: no step advances beyond a finite time.
    size, stiffness, taken = 12, (16 * math.pi) ** 2, []

    def step(solver: LSODA) -> None:
        taken.append(solver)
        assert len(taken) < 5000
        OdeSolver.step(solver)

    monkeypatch.setattr(LSODA, "step", step)
    chain = sf.Structure(
        np.eye(size),
        0.32 * math.pi * np.eye(size),
        stiffness * (2 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1)),
        elements=sf.CubicSpring("q11", k3=-1e3),
        forcing=sf.HarmonicForce("q11", F=3000.0),
        f=2.0,
    )
    scales = measured(chain).state_scales()
    assert taken
    assert np.isfinite(scales).all()
    assert (scales > 0).all()


def test_a_plate_that_hardly_moves_at_first_does_not_set_the_scale():
    # Friction bends where the pad moves as fast as the disc: 2,000 times farther at the other end.
    contact = sf.FrictionContact("x", sf.Stribeck(mu_s=0.55, mu_k=0.3, vs=0.3), load=150, Vd=1.5)
    pad = sf.Structure([[0.8]], [[6.0]], [[320000.0]], names="x", contacts=contact)
    still = sf.Settings(largest_period=0)
    slow, fast = (
        sf.response(pad, "Vd", span, settings=still).branches[0].model.state_scales()[1]
        for span in ((0.0015, 3.0), (3.0, 0.0015))
    )
    assert 0.01 < slow < fast < 10


@pytest.mark.parametrize("rate", [1e-3, 1e-5])
def test_friction_sets_the_scale_before_its_heat_does(rate):
    # Friction bends the rates at the belt's speed, the product of heat and slip at 1/rate.
    model = sf.System(
        parameters={"Vd": 1.5},
        states={"x": "v", "v": "F - 0.05*v - x", "T": f"{rate}*(5*F*(Vd - v) - T)"},
        contacts={"F": {"slip": "Vd - v", "normal": "1 - 0.3*T", "friction": sf.Stribeck(vs=0.2)}},
    )
    assert (measured(model).estimated_scales[0, :2] <= 8).all()
