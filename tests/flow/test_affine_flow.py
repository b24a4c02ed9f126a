"""Affine rates in closed form, beside the matrix exponential and beside the integrator."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import block_diag, expm

import slipfold as sf
from slipfold.flow.affine_events import EVENT
from slipfold.flow.affine_flow import (
    AffineFlow,
    AffineSolutions,
    Harmonics,
    _eigenvectors,
    divided,
    harmonics_of,
    twice_divided,
)
from slipfold.flow.flow import Flow, flow_of
from slipfold.flow.hybrid_flow import HybridFlow, hybrid_flow_of
from slipfold.flow.hybrid_trajectory import first_mode, smooth_phases
from slipfold.flow.linearized_trajectory import linearized_trajectory
from slipfold.flow.modes import Status


def chain(count, load=0.4, **parts):
    """Masses between springs, the last one rubbing dryly on a wall."""
    stiffness = 100 * (2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1))
    model = sf.Structure(
        np.eye(count),
        sf.ProportionalDamping(alpha_M=0.02, beta_K=0.002),
        stiffness,
        contacts=sf.FrictionContact(f"q{count}", sf.Coulomb(mu_s=0.5, mu_k=0.3), load=load, Vd=0.0),
        forcing=sf.HarmonicForce("q1", F=3.0),
        **parts,
    )
    return model.replace(f=1.03 * model.natural_frequencies[0])


@pytest.mark.parametrize("gap", [0.0, 1e-9, 0.3, 0.6, 4.0 + 2j])
@pytest.mark.parametrize("slow", [0.0, 1e-4j, -0.01])
def test_divided_differences_are_entries_of_an_exponential(gap, slow):
    # Opitz: f[a, b, c] stands in the corner of f of a matrix with a, b, c and ones beside them.
    a, b, c = -0.4 + 3j + gap, -0.4 + 3j + slow, -0.4 + 3j
    exact = expm(np.array([[a, 1, 0], [0, b, 1], [0, 0, c]]))
    given = (np.array([item], dtype=complex) for item in (a, b, c))
    a, b, c = given
    assert divided(a, b)[0] == pytest.approx(exact[0, 1], rel=1e-13)
    assert twice_divided(a, b, c)[0] == pytest.approx(exact[0, 2], rel=1e-13)


def test_solutions_are_those_of_the_exponential():
    # Two zero eigenvalues, as where a contact sticks, one of them pushed by a constant; a harmonic
    # at an undamped frequency; a fast mode
    rng = np.random.default_rng(4)
    turns = [np.array([[0, w], [-w, -d]]) for w, d in ((2 * np.pi, 0.0), (200.0, 3.0), (1.0, 5.0))]
    basis = np.eye(8) + 0.3 * rng.normal(size=(8, 8))
    matrix = basis @ block_diag(0.0, 0.0, *turns) @ np.linalg.inv(basis)
    forces = rng.normal(size=(3, 8))
    both = np.array([forces[1] + 1j * forces[2], 2 * forces[0], forces[1] - 1j * forces[2]]) / 2
    forcing = Harmonics(2j * np.pi * np.array([-1, 0, 1]), both)
    change, (pushed, ahead) = rng.normal(size=(8, 8)), rng.normal(size=(2, 8))

    # The same as an autonomous system: the states with cosine and sine, and their variation
    turn = block_diag(0.0, [[0, -2 * np.pi], [2 * np.pi, 0]])
    whole = np.block(
        [[matrix, np.stack([forces[0], forces[1], forces[2]]).T], [np.zeros((3, 8)), turn]]
    )
    varied = np.zeros((11, 11))
    varied[:8, :8], varied[:8, 8], varied[:8, 9] = change, pushed, ahead
    block = np.block([[whole, np.zeros((11, 11))], [varied, whole]])

    begin, times, first = np.array([0.2, 0.9]), np.array([0.05, 0.8]), rng.normal(size=(2, 8))
    solutions = AffineSolutions.of(_eigenvectors(matrix.tobytes(), 8), 1.0, forcing, np.ones(8))
    start = first @ solutions.into.T
    moved = (solutions.motions(start, begin, times[:, None])[:, 0] @ solutions.shapes.T).real
    own = Harmonics(2j * np.pi * np.array([-1, 0, 1]), np.array([ahead, 2 * pushed, ahead]) / 2)
    along = solutions.along(start, begin, times, change[None], own)
    for row in range(2):
        angle = 2 * np.pi * begin[row]
        given = np.concatenate([first[row], [1, np.cos(angle), np.sin(angle)], np.zeros(11)])
        exact = expm(times[row] * block)
        end = exact @ given
        size = np.abs(end).max()
        assert np.abs(moved[row] - end[:8]).max() < 1e-12 * size
        assert np.abs(along[row, :, 0] - end[11:19]).max() < 1e-11 * size
        assert np.abs(solutions.transitions(times)[row] - exact[:8, :8]).max() < 1e-11


def test_forcing_is_a_sum_of_few_harmonics_or_none():
    units, orders = np.array([1.0, 1e3]), np.array([0, 3, 40])

    def periodic(phases):
        values = np.cos(2 * np.pi * np.outer(phases, orders) + orders)
        return (values @ [[1, 0], [0.1, 500], [1e-3, 0]])[:, None]

    found = harmonics_of(periodic, units, 0.0)
    assert np.unique(np.abs(found.exponents.imag) / (2 * np.pi)).round(9).tolist() == [0, 3, 40]
    phases = np.random.default_rng(1).uniform(0, 5, 20)
    assert np.abs(found.at(phases) - periodic(phases)[:, 0]).max() < 1e-10
    assert harmonics_of(lambda at: np.abs(np.cos(at))[:, None, None], np.ones(1), 0.0) is None
    assert harmonics_of(lambda at: at[:, None, None], np.ones(1), 0.0) is None
    # Rounding errors of what is as good as zero are no forcing.
    noise = np.random.default_rng(2)
    small = harmonics_of(lambda at: 1e-17 * noise.normal(size=(len(at), 1, 2)), units, 1.0)
    assert len(small.exponents) == 0


@pytest.mark.parametrize("status", [Status.STICK, Status.FORTH])
def test_modes_are_linearized_as_by_the_integrator(status):
    model = chain(4, load=sf.ModulatedLoad(Ns=0.4, Nd=0.1))
    flow, constants = hybrid_flow_of(model).of((status,)), flow_of(model).constants_of(model)
    assert isinstance(flow, AffineFlow)
    scales = model.state_scales()
    states = scales * np.random.default_rng(3).normal(size=(3, 8))
    begin, end = np.array([0.1, 0.3, 0.7]), np.array([0.15, 0.6, 1.6])
    given = states, begin, end, constants, constants.rates
    assert flow.solutions(constants) is not None
    for own, exact in zip(flow.linearize(*given), Flow.linearize(flow, *given), strict=True):
        assert np.abs(own - exact).max() < 1e-11 * np.abs(exact).max()
    ends = flow.advance(*given[:4])
    assert np.abs(ends - flow.linearize(*given)[0]).max() < 1e-13 * np.abs(ends).max()


TWO = (
    sf.FrictionContact(
        "q4",
        sf.Coulomb(mu_s=0.5, mu_k=0.3),
        load=sf.ContactLoad("q2", Ns=0.4, kn=5.0, cn=0.02),
        Vd=0.1,
        name="opens",
    ),
    sf.FrictionContact(
        "q3",
        sf.Coulomb(mu_s=0.4, mu_k=0.3),
        load=sf.ModulatedLoad(Ns=0.3, Nd=0.1),
        Vd=0.0,
        name="pulsates",
    ),
)
"""Contacts that slip, stick and open."""


@pytest.mark.parametrize(
    "model",
    [chain(4), chain(4).replace(Ns=2.0, Vd=0.05), chain(4).replace(contacts=TWO)],
    ids=["wall", "belt", "two"],
)
def test_smooth_phases_are_those_of_the_integrator(monkeypatch, model):
    constants, start, passed = flow_of(model).constants_of(model), np.zeros(8), []
    scales = model.state_scales()
    for many in (9, 8):
        monkeypatch.setattr(EVENT, "many", many)
        system = HybridFlow(model).system(start, constants)
        mode = first_mode(system, start)
        passed.append(list(smooth_phases(system, mode, start, 12.0)))
    assert len(passed[0]) > 20
    met = {status for part, _ in passed[0] for status in part.mode}
    assert {Status.STICK, Status.FORTH} <= met
    assert (Status.OPEN in met) == (len(mode) > 1)
    assert all(compiled.exact for compiled in system.flow._modes.values())
    lost = sum(part.energies for part, _ in passed[0])
    for (one, _), (other, _) in zip(*passed, strict=True):
        assert one.mode == other.mode
        assert one.end == pytest.approx(other.end, abs=1e-10)
        assert np.abs((one.state - other.state) / scales).max() < 1e-10
        assert np.abs(one.energies - other.energies).max() < 1e-10 * np.abs(lost).max()
    # Dense output, and no energies where none are wanted
    system, before = replace(system, energies=False), start
    for part, _ in smooth_phases(system, mode, start, 3.0, dense=True):
        phases = part.begin + (part.end - part.begin) * np.array([0.0, 0.37, 0.9, 1.0])
        exact = system.flow.of(part.mode).along(before[None], phases[None], constants)[0]
        assert np.abs(part.polynomials(phases) - exact / constants.scales).max() < 1e-12
        assert not part.energies.any()
        before = part.state


@pytest.mark.parametrize(("c", "groups"), [(0.0, [[1], [0]]), (0.05, [[0, 1]])])
def test_derivatives_jump_where_two_changes_meet_if_contacts_are_coupled(monkeypatch, c, groups):
    """Two masses between a third and walls begin to slip one after the other, in either order."""
    monkeypatch.setattr(EVENT, "many", 6)
    law = sf.Coulomb(mu_s=0.5, mu_k=0.3)
    model = sf.Structure(
        np.eye(3),
        [[0.1 + c, -c, 0], [-c, 0.1 + c, 0], [0, 0, 0.1]],
        [[2, 0, -1], [0, 2, -1], [-1, -1, 3]],
        contacts=[sf.FrictionContact(q, law, load=1.0, Vd=0.0, name=q) for q in ("q1", "q2")],
        forcing=sf.HarmonicForce("q3", F=1.2),
        f=0.2,
    )
    flow, constants = HybridFlow(model), flow_of(model).constants_of(model)
    assert flow.groups(constants) == groups
    found, none = [], np.zeros((len(constants.values), 0))
    for apart in (1e-6, -1e-6):
        start = np.array([0.5 + apart, 0.5 - apart, 1.0, 0.0, 0.0, 0.0])
        system = flow.system(start, constants)
        passed = list(smooth_phases(system, first_mode(system, start), start, 1.0))
        found.append(linearized_trajectory(system, start, passed, none).matrix)
        assert passed[0][1] == ((0, 1) if apart < 0 else (1, 0))
    jumps = np.abs(found[0] - found[1]).max() > 1e-3
    assert jumps == (len(groups) == 1)
    assert jumps or np.abs(found[0] - found[1]).max() < 1e2 * 1e-6


def test_a_free_mass_has_too_few_eigenvectors():
    free = sf.Structure(
        np.eye(4),
        K=np.zeros((4, 4)),
        contacts=sf.FrictionContact("q1", sf.Coulomb(mu_k=0.3), load=1.0, Vd=0.0),
        forcing=sf.HarmonicForce("q1", F=3.0),
    )
    flow, constants = hybrid_flow_of(free).of((Status.FORTH,)), flow_of(free).constants_of(free)
    assert isinstance(flow, AffineFlow)
    assert flow.solutions(constants) is None


def test_stick_without_a_limit_leaves_the_limit_of_other_systems(monkeypatch):
    """A contact that may stick for ever at first sticks as long as before when it may not."""
    monkeypatch.setattr(EVENT, "many", 8)
    model, mode = chain(4), (Status.STICK,)
    state = np.zeros(8)
    flow, ends = HybridFlow(model), []
    for asks in (False, True):
        system = flow.system(state, flow_of(model).constants_of(model), energies=False)
        if asks:
            unlimited = system.without_limits([0]).run(mode, state, 0.0, 5.0)
            assert unlimited.event is None
        ends.append(system.run(mode, state, 0.0, 5.0).end)
    assert 0 < ends[0] < 5
    assert ends[0] == ends[1]


def test_slip_that_has_hardly_begun_is_no_scale_for_rounding():
    model = chain(4)
    flow, constants = HybridFlow(model), flow_of(model).constants_of(model)
    scales = np.repeat([1.0, 1e-9], 4)
    system = flow.system(np.zeros(8), replace(constants, scales=scales))
    assert np.finfo(float).eps * system.weights[0] < EVENT.rounding


def test_what_a_phase_adds_to_slip_does_not_depend_on_the_unit_of_time():
    weights = []
    for unit in (1.0, 2.0**-20):
        model = sf.Structure(
            [[unit**2]], None, [[1.0]], f=0.2 / unit, forcing=sf.HarmonicForce("q1", F=3.0),
            contacts=sf.FrictionContact("q1", sf.Coulomb(mu_k=0.3), load=1.0, Vd=0.0),
        )  # fmt: skip
        constants = replace(flow_of(model).constants_of(model), scales=np.array([1.0, 1e-9 / unit]))
        weights.append(HybridFlow(model).system(np.zeros(2), constants).weights[0] / unit)
    assert weights[0] == weights[1]


def test_what_was_computed_before_changes_no_bit():
    """A light contact decays 1e5 times a second; how it is solved depends on the period alone."""
    link = np.array([[1.0, -1.0], [-1.0, 1.0]])
    light = sf.Structure(
        np.diag([1e-3, 1.0]), 100 * link, 1e3 * link + np.diag([0.0, 1.0]), names="a b",
        contacts=sf.FrictionContact("a", sf.Coulomb(mu_k=1.0), load=0.25, Vd=0),
        forcing=sf.HarmonicForce("a", F=0.5),
    )  # fmt: skip
    models, mode = [light.replace(f=f) for f in (0.2, 2.0, 20.0)], (Status.FORTH,)
    found = []
    for order in ([0, 1, 2], [2, 1, 0, 1]):
        hybrid, results = HybridFlow(light), {}
        for which in order:
            constants, state = flow_of(light).constants_of(models[which]), np.array([0, 0, 1e-3, 1])
            parts = hybrid.system(state, constants).run(mode, state, 0.0, 0.4)
            given = state[None], np.zeros(1), np.array([0.4]), constants, constants.rates
            results[which] = (parts.state, *hybrid.of(mode).linearize(*given))
            assert np.isfinite(np.concatenate([item.ravel() for item in results[which]])).all()
        found.append([item.tobytes() for which in range(3) for item in results[which]])
    assert found[0] == found[1]
