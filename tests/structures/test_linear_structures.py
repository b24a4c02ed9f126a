"""Linear structures against closed forms: responses, damping, reductions."""

import numpy as np
import pytest
from scipy import sparse
from scipy.linalg import eigh
from tests.helpers.beams import free_beam

from slipfold import (
    BaseAcceleration,
    BaseMotion,
    CraigBampton,
    CubicSpring,
    FreeInterface,
    FrictionContact,
    HarmonicForce,
    ModalDamping,
    ModalReduction,
    ProportionalDamping,
    Structure,
    periodic_orbit,
)

RNG = np.random.default_rng(20260103)
ROOT = RNG.normal(size=(3, 3))
M = np.eye(3) + 0.1 * (ROOT + ROOT.T)
K = 100 * (ROOT @ ROOT.T + np.eye(3))
C = 0.05 * M + 0.002 * K


def chain(size, stiffness=1.0, mass=1.0):
    """Fixed at its root, free at its tip."""
    k = 2 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1)
    k[-1, -1] = 1
    return mass * np.eye(size), stiffness * k


def chain_frequencies(size):
    """Closed form in Hz for unit masses and stiffnesses."""
    modes = np.arange(1, size + 1)
    return 2 * np.sin((2 * modes - 1) * np.pi / (2 * (2 * size + 1))) / (2 * np.pi)


def cantilever(elements):
    """A clamped beam of unit length, stiffness and density: deflections and rotations."""
    mass, stiffness = free_beam(elements)
    names = [f"{kind}{node}" for node in range(1, elements + 1) for kind in "wr"]
    return mass[2:, 2:], stiffness[2:, 2:], names


def steady(model, load):
    """State at phase zero under a harmonic load with the complex amplitude at the frequency f."""
    w = 2 * np.pi * model.f
    m, c, k = model.mass_matrix, model.damping_matrix, model.stiffness_matrix
    x = np.linalg.solve(k + 1j * w * c - w**2 * m, load)
    return np.concatenate([x.real, (1j * w * x).real])


@pytest.mark.parametrize("frequency", [0.7, 1.9, 3.3])
def test_frequency_response(frequency):
    force = HarmonicForce({"q1": 0.6, "q3": -0.8}, F=2.0, phi=0.4)
    model = Structure(M, C, K, forcing=force, f=frequency, length_scale=0.01)
    orbit = periodic_orbit(model)
    expected = steady(model, 2.0 * np.exp(0.4j) * np.array([0.6, 0, -0.8])) / 0.01
    assert orbit.state == pytest.approx(expected, rel=1e-10, abs=1e-10 * np.abs(expected).max())


@pytest.mark.parametrize("ratios", [0.01, (0.01, 0.02, 0.05)])
def test_modal_damping_has_its_ratios(ratios):
    modes = Structure(M, ModalDamping(ratios), K).modes()
    assert modes.damping_ratio == pytest.approx(np.broadcast_to(ratios, 3), rel=1e-10)
    stiffness = np.diag([9.0, 1.0, 4.0])
    modes = Structure(np.eye(3), ModalDamping(ratios), stiffness).modes()
    assert modes.damping_ratio == pytest.approx(np.broadcast_to(ratios, 3), rel=1e-12)


def test_modal_reduction_is_exact_for_the_kept_modes():
    m, k = chain(12)
    squares, shapes = eigh(k, m)
    # A load that only the first three modes feel: the reduced structure must answer as the whole.
    load = m @ shapes[:, :3] @ [1.0, 2.0, -1.0]
    direction = {f"q{position + 1}": value for position, value in enumerate(load)}
    common = {"forcing": HarmonicForce(direction, F=1.0), "watch": {"tip": "q12"}, "f": 0.03}
    whole = Structure(m, ProportionalDamping(beta_K=0.05), k, **common)
    small = Structure(m, ProportionalDamping(beta_K=0.05), k, reduction=ModalReduction(3), **common)
    assert small.natural_frequencies == pytest.approx(np.sqrt(squares[:3]) / (2 * np.pi))
    assert [state.name for state in small.states[:3]] == ["mode1", "mode2", "mode3"]
    assert small.reduction_report.error == 0
    found, expected = (model.evaluate("tip", periodic_orbit(model).state)
                       for model in (small, whole))  # fmt: skip
    assert found == pytest.approx(expected, rel=1e-9)
    assert np.abs(small.basis).max(axis=0) == pytest.approx(np.ones(3))


def test_cantilever_by_craig_bampton():
    m, k, names = cantilever(20)
    roots = np.array([1.87510406871196, 4.69409113297418, 7.85475743823761])
    model = Structure(m, None, k, names=names, reduction=CraigBampton(["w20", "r20"], modes=5))
    assert [state.name for state in model.states[:2]] == ["mode1", "mode2"]
    assert {"w20", "r20"} < {output.name for output in model.outputs()}
    found = model.natural_frequencies[:3]
    assert found == pytest.approx(roots**2 / (2 * np.pi), rel=5e-4)
    assert found[0] == pytest.approx(roots[0] ** 2 / (2 * np.pi), rel=1e-5)
    report = model.reduction_report
    assert report.exact[:3] == pytest.approx(roots**2 / (2 * np.pi), rel=2e-5)
    # By Rayleigh's principle no frequency is below the exact one.
    assert np.all(report.frequencies >= report.exact * (1 - 1e-9))
    assert 0 < report.error < 0.02
    assert "42 degrees" not in str(report)
    assert "40 degrees of freedom reduced to 7" in str(report)


def test_what_a_reduced_structure_shows_is_where_something_acts():
    m, k = chain(7)
    four = dict.fromkeys(("q1", "q2", "q3", "q4"), 0.5)
    parts = {
        "contacts": FrictionContact({"q3": 1, "q2": -1}, load=1, Vd=0.5),
        "elements": [CubicSpring("q7", k3=1, name="tip"), CubicSpring(four, k3=1, name="four")],
        "forcing": [HarmonicForce("q5", F=1), BaseAcceleration("q1", a=1, name="base")],
        "watch": {"tip": "q7", "turn": {"q7": 1, "q6": -1}},
    }
    model = Structure(m, None, k, reduction=ModalReduction(modes=2), **parts)
    assert model.shown == ("tip", "turn", "q3", "q2", "q5")
    assert set(model.shown) < {output.name for output in model.outputs()}
    state = np.arange(1.0, 5.0)
    whole = model.basis @ state[:2]
    assert model.evaluate("q5", state) == pytest.approx(whole[4], rel=1e-14)
    assert Structure(m, None, k, **parts).shown[:2] == ("q1", "q2")
    one = model.replace(forcing=HarmonicForce("q5", F=1))
    assert one.steady().shown == one.shown == model.shown


def test_craig_bampton_with_all_modes_is_exact_and_guyan_is_static():
    m, k = chain(7)
    whole = CraigBampton(["q3", "q7"], modes=5)
    model = Structure(m, None, k, reduction=whole)
    assert model.natural_frequencies == pytest.approx(chain_frequencies(7), rel=1e-12)
    guyan = Structure(m, None, k, reduction=CraigBampton("q7", modes=0))
    # Seven springs in a row, and a linear deflection: sum (i/7)^2.
    assert guyan.stiffness_matrix == pytest.approx(np.array([[1 / 7]]), rel=1e-12)
    assert guyan.mass_matrix == pytest.approx(np.array([[140 / 49]]), rel=1e-12)


@pytest.mark.parametrize("reduction", [
    ModalReduction(modes=4), ModalReduction(up_to=4e-3), CraigBampton("q1000", modes=6),
])  # fmt: skip
def test_large_sparse_structures(reduction):
    size = 1000
    diagonals = [-np.ones(size), np.append(2 * np.ones(size - 1), 1.0), -np.ones(size)]
    k = sparse.dia_array((diagonals, [-1, 0, 1]), shape=(size, size)).tocsr()
    model = Structure(sparse.eye_array(size), None, k, reduction=reduction)
    report = model.reduction_report
    exact = chain_frequencies(size)
    assert report.exact == pytest.approx(exact[: len(report.exact)], rel=1e-7)
    assert report.error < 2e-2
    assert report.whole == size
    if reduction == ModalReduction(up_to=4e-3):
        assert len(model.states) == 2 * np.sum(exact <= 4e-3)


@pytest.mark.parametrize("reduction", [
    None, ModalReduction(4), CraigBampton("w2", modes=3), FreeInterface(4),
])  # fmt: skip
def test_massless_rotations_are_condensed(reduction):
    # A beam with lumped masses: its rotations follow the deflections, as the full solution says.
    m, k, names = cantilever(4)
    m = np.diag(np.where([name[0] == "w" for name in names], 0.25, 0.0))
    load, f = {"r1": 0.3, "w4": 1.0}, 0.4
    model = Structure(
        m, ProportionalDamping(beta_K=0.05), k, names=names, reduction=reduction,
        forcing=HarmonicForce(load, F=2.0), watch={"u": "w3"}, f=f,
    )  # fmt: skip
    assert model.notes == ("without mass, condensed statically: 4 (r1, r2, r3, r4)",)
    assert len(model.states) == 8
    stiffness = (1 + 2j * np.pi * f * 0.05) * k
    vector = [2.0 * load.get(name, 0.0) for name in names]
    full = np.linalg.solve(stiffness - (2 * np.pi * f) ** 2 * m, vector)
    orbit = periodic_orbit(model)
    for name, place in [("u", "w3"), ("w4", "w4")]:
        found = model.evaluate(name, orbit.state)
        assert found == pytest.approx(full[names.index(place)].real, rel=1e-9)
    assert "r1" not in [output.name for output in model.outputs()]  # it moves with the force too
    lowest = np.sqrt(1 / np.linalg.eigvals(np.linalg.solve(k, m)).real.max()) / (2 * np.pi)
    assert model.natural_frequencies[0] == pytest.approx(lowest, rel=1e-10)


def test_a_base_with_a_given_acceleration():
    m, k, names = cantilever(2)
    weights = {name: 1.0 for name in names if name[0] == "w"}
    options = {"C": ProportionalDamping(beta_K=0.01), "K": k, "names": names, "f": 0.3}
    driven = Structure(m, **options, forcing=BaseAcceleration("*:w", a=2.0, phi=0.4))
    moved = Structure(m, **options, forcing=BaseMotion(weights, A=-2 / (0.6 * np.pi) ** 2, phi=0.4))
    states = [periodic_orbit(model).state for model in (driven, moved)]
    np.testing.assert_allclose(*states, rtol=1e-9)
    twice = driven.replace(f=0.6)
    exact = steady(twice, -2.0 * np.exp(0.4j) * m @ [weights.get(name, 0) for name in names])
    np.testing.assert_allclose(periodic_orbit(twice).state, exact, rtol=1e-8)


def test_a_proportional_damping_matrix_stays_diagonal_in_modal_coordinates():
    m, k, _ = cantilever(6)
    model = Structure(m, 1e-3 * k, k, reduction=ModalReduction(4), G=np.zeros((12, 12)))
    assert np.count_nonzero(model.damping_matrix) == 4
    expected = 1e-3 * np.diag(model.stiffness_matrix)
    np.testing.assert_allclose(np.diag(model.damping_matrix), expected, rtol=1e-8)
