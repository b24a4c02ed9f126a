"""Modes with a few nonlinear forces: what is linear is exact, all else agrees with the flow."""

from math import factorial

import numpy as np
import pytest
from numpy.polynomial import Polynomial, legendre
from scipy.linalg import expm

import slipfold as sf
from slipfold.collocation_points import gauss_points
from slipfold.continuation.newton import correct
from slipfold.flow.flow import flow_of
from slipfold.flow.modal_answers import ModalAnswers
from slipfold.flow.modal_equations import CHOICE, ForcedIntervals, modal_equations_of
from slipfold.flow.modal_segments import joined, solve_segments
from slipfold.orbits.kinds import orbits_at
from slipfold.orbits.modal_shooting import ModalShooting, segments_for, shooting_for
from slipfold.orbits.shooting import Shooting

FREE = {"f": 0.1, "F": 1.0, "alpha_M": 0.1, "mu_k": 1.0, "k3": 10.0, "e": 0.1}


def chain(count, **parts):
    """Masses between springs, the last rubbing on a wall, in physical coordinates."""
    stiffness = 100 * (2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1))
    stiffness[-1, -1] = 100
    names = [f"x{number}" for number in range(1, count + 1)]
    given = {
        "C": sf.ProportionalDamping(alpha_M=0.02, beta_K=0.002),
        "contacts": sf.FrictionContact(
            names[-1], sf.Regularized(sf.Coulomb(mu_k=0.3), "sqrt", e=0.5), load=1.0, Vd=0.05
        ),
        "forcing": sf.HarmonicForce(names[0], F=3.0),
        "elements": sf.CubicSpring({"x2": 1, "x1": -1}, k3=30.0),
    }
    model = sf.Structure(np.eye(count), K=stiffness, names=names, **{**given, **parts})
    return model.replace(f=1.03 * model.natural_frequencies[0])


def long_exponential(matrix):
    """The exponential in more digits than double precision."""
    turns = max(0, int(np.ceil(np.log2(max(np.abs(matrix).sum(axis=1).max(), 1e-9)))) + 3)
    part = matrix.astype(np.longdouble) / np.longdouble(2) ** turns
    result = term = np.eye(len(matrix), dtype=np.longdouble)
    for order in range(1, 30):
        term = term @ part / order
        result = result + term
    for _ in range(turns):
        result = result @ result
    return result


@pytest.mark.parametrize("length", [1.0, 0.13])
@pytest.mark.parametrize(
    ("omega", "zeta"),
    [(0, 0), (0.01, 0.5), (9.9, 0.2), (10.1, 0.01), (300, 0.02), (3, 1), (60, 1), (3, 5), (2, 40)],
)
def test_modes_answer_polynomials_exactly(omega, zeta, length):
    """At any speed and damping: a rigid body, critical and stronger damping, many vibrations."""
    points, place, which = gauss_points(6), 3, 2
    damping = 2 * zeta * omega if omega else 0.3
    answers = ModalAnswers(points, *(np.array([x]) for x in (length, omega**2, damping)))
    shape = Polynomial(legendre.leg2poly(points.transform[:, which]))(Polynomial([-1.0, 2.0]))
    matrix = np.zeros((8, 8))  # the mode, then powers of time, each the integral of the next
    matrix[:2, :2] = [[0, 1], [-(omega**2), -damping]]
    matrix[1, 2:] = [factor * factorial(power) for power, factor in enumerate(shape.coef)]
    matrix[:2] *= length
    matrix[np.arange(3, 8), np.arange(2, 7)] = 1
    for at, until in ((place, points.points[place]), (-1, 1.0)):
        exact = long_exponential(matrix * until)[:2, :3].astype(float)
        found = [part[0, 0, at] for part in answers.transitions]
        size = max(omega, 1.0)
        scaled = exact[:, :2] * [[1, size], [1 / size, 1]]
        np.testing.assert_allclose(
            np.reshape(found, (2, 2)) * [[1, size], [1 / size, 1]], scaled, atol=2e-13
        )
        weights = np.eye(2)[:, :, None]  # displacement, then rate
        moved, moving = answers.motions(*weights)[0, :, place, which]
        if at == -1:
            moved, moving = (part[0, 0, which] for part in answers.forced)
        turn = 1 + omega * length
        np.testing.assert_allclose(moved, exact[0, 2], atol=2e-13 * length**2 / turn)
        np.testing.assert_allclose(moving, exact[1, 2], atol=2e-13 * length / turn)


def test_a_linear_structure_is_exact_over_long_intervals():
    model = chain(4, contacts=(), elements=(), forcing=sf.HarmonicForce("x1", F=0.0))
    by = ModalShooting(model, {"f": 0.1}, segments=1, mesh=np.array([0.0, 1.0]))
    constants = flow_of(model).constants_of(model)
    stiffness, damping = model.stiffness_matrix, model.damping_matrix
    matrix = np.block([[np.zeros((4, 4)), np.eye(4)], [-stiffness, -damping]])
    exact = expm(matrix / model.values["f"]) * by.ratios
    blocks = by.transitions(np.ones((1, 8)), constants)[1]
    np.testing.assert_allclose(blocks[0], exact, atol=1e-13 * np.abs(exact).max())


@pytest.fixture(scope="module", params=[3, pytest.param(5, marks=pytest.mark.long)])
def two(request):
    """Modal shooting and shooting of a chain, and states at the nodes."""
    model = chain(request.param).with_scales(np.full(2 * request.param, 0.5))
    mesh = np.linspace(0.0, 1.0, 129)
    modal, shot = ModalShooting(model, FREE, mesh=mesh), Shooting(model, FREE)
    nodes = 0.1 * np.random.default_rng(2).normal(size=(8, 2 * request.param))
    return modal, shot, nodes, flow_of(model).constants_of(model)


def assert_same(found, exact, close):
    for one, other in zip(found, exact, strict=True):
        size = max(1.0, float(np.abs(other).max()))
        np.testing.assert_allclose(one, other, rtol=0, atol=close * size)


def test_derivatives_are_those_of_the_flow(two):
    """By states, frequency, force, damping, friction, a spring and the regularization."""
    modal, shot, nodes, constants = two
    assert_same(modal.transitions(nodes, constants), shot.transitions(nodes, constants), 1e-10)
    assert_same([modal.mismatch(nodes, constants)], [shot.mismatch(nodes, constants)], 1e-10)


def test_second_and_third_derivatives_are_those_of_the_flow(two):
    modal, shot, nodes, constants = two
    vectors = np.random.default_rng(3).normal(size=(2, *nodes.shape))
    given = nodes, constants, vectors
    assert_same(modal.curvatures(*given), shot.curvatures(*given), 1e-9)
    assert_same([modal.cubes(*given)], [shot.cubes(*given)], 1e-8)


def test_states_between_the_nodes_are_those_of_the_flow(two):
    modal, shot, nodes, constants = two
    phases = np.array([0.0, 0.1, 0.33, 0.5, 0.999])
    exact = shot.propagate_to(nodes, constants, phases)
    assert_same(modal.propagate_to(nodes, constants, phases), exact, 1e-10)
    assert_same([modal.states(nodes, constants, phases)], exact[1:2], 1e-10)
    known, at = modal.stage_states(nodes, constants)
    assert_same([known], [shot.states(nodes, constants, at)], 1e-10)


def test_contacts_that_turn_within_a_step_of_newtons_method():
    """All intervals at once diverge from straight lines between nodes: one follows another."""
    law = sf.Regularized(sf.Coulomb(mu_k=0.3), e=2e-2)
    rubs = sf.FrictionContact("x3", law, load=100.0, Vd=0.0)
    model = chain(3, contacts=rubs).with_scales(np.full(6, 0.5))
    constants = flow_of(model).constants_of(model)
    modal = ModalShooting(model, FREE, mesh=np.linspace(0.0, 1.0, 8 * 80 + 1))
    nodes = 0.3 * np.random.default_rng(2).normal(size=(8, 6))
    exact = Shooting(model, FREE).mismatch(nodes, constants)
    assert_same([modal.mismatch(nodes, constants)], [exact], 1e-4)


def test_states_are_those_of_the_flow_where_no_motion_is_found(two, monkeypatch):
    modal, shot, nodes, constants = two
    phases = np.array([0.1, 0.5])
    monkeypatch.setattr("slipfold.orbits.modal_shooting.solve_segments", lambda *_: None)
    own = modal.on(modal.mesh)
    assert np.isnan(own.mismatch(nodes, constants)).all()  # steps of a curve are shortened
    exact = shot.propagate_to(nodes, constants, phases)
    assert_same(own.propagate_to(nodes, constants, phases), exact, 1e-12)
    assert_same([own.states(nodes, constants, phases)], exact[1:2], 1e-12)
    orbits = orbits_at(own.model, 1, 8, by=ModalShooting)
    z = orbits.unknown(nodes, own.model)
    failed = correct(orbits, z, np.eye(len(z))[-1])
    assert not failed.converged
    assert failed.failure == ModalShooting.undefined  # and no singularity of the model


@pytest.mark.parametrize(("stages", "order"), [(1, 2), (2, 4), (3, 6)])
def test_the_order_is_that_of_gauss_points(stages, order):
    model = chain(3)
    equations, constants = modal_equations_of(model), flow_of(model).constants_of(model)
    first = np.random.default_rng(1).normal(size=(1, 6)) * 0.1
    ends = []
    for count in (64, 128, 512):
        start, lengths = joined(np.linspace(0, 1, count + 1), 1)
        intervals = ForcedIntervals(
            equations,
            gauss_points(stages),
            start,
            lengths,
            constants.period,
            equations.dampings(constants),
        )
        guess = np.zeros((count, stages, equations.motions))
        given = intervals, constants, constants.rates[:, :1], first, guess
        found = solve_segments(*given, np.ones(equations.motions))
        ends.append(found.ends[0])
    coarse, fine = (np.abs(item - ends[-1]).max() for item in ends[:2])
    assert np.log2(coarse / fine) > order - 0.5


def test_special_points_are_those_of_the_flow():
    """Folds of a chain that becomes stiffer, and what is computed of them."""
    law = sf.Regularized(sf.Coulomb(mu_k=0.3), "sqrt", e=0.1)
    model = chain(
        3,
        contacts=sf.FrictionContact("x3", law, load=1.0, Vd=0.0),
        forcing=sf.HarmonicForce("x1", F=10.0),
        elements=sf.CubicSpring("x3", k3=30.0),
    )
    assert shooting_for(model) is Shooting
    (exact, own), (found, other) = (folds(model, states) for states in (CHOICE.states, 0))
    assert [item.type for item in exact.special] == ["LP", "LP"]
    for one, reference in zip(found.special, exact.special, strict=True):
        assert one.type == reference.type
        known = one.uncertainty + reference.uncertainty
        assert known < 1e-9
        assert abs(one.value - reference.value) <= known + 1e-15
        # That of the first is a thousandth of the terms of its sum, of which differences know
        # all but the root of the rounding.
        assert one.coefficient == pytest.approx(reference.coefficient, rel=1e-8, abs=1e-7)
        apart = np.abs(one.multipliers[:, None] - reference.multipliers).min(axis=1)
        known = one.multiplier_uncertainty + reference.multiplier_uncertainty.max()
        assert (apart <= known).all()
        assert known.max() < 1e-4
    np.testing.assert_allclose(other, own, rtol=1e-10)


def folds(model, states):
    """A branch with folds, and where the locus of the first leaves a window."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(CHOICE, "states", states)
        branch = sf.response(model, vary="f", span=(0.82, 1.0)).branches[0]
        window = {"f": (0.8, 1.1), "F": (9.95, 10.05)}
        point, given = branch.special[0], {"vary": ("f", "F"), "window": window, "switch": False}
        locus = sf.locus(point, **given).loci[0]
    return branch, locus.values[[0, -1]]


def beam(modes):
    """A cantilever of bending modes, whose tip rubs on a wall."""
    roots = np.append([1.875104, 4.694091], (2 * np.arange(3, modes + 1) - 1) * np.pi / 2)
    names = [f"q{number}" for number in range(1, modes + 1)]
    tip = dict(zip(names, 2 * (-1.0) ** np.arange(modes), strict=True))
    middle = dict(zip(names, np.cos(1.3 * np.arange(modes)), strict=True))
    law = sf.Regularized(sf.Coulomb(mu_k=0.3), "sqrt", e=0.05)
    return sf.Structure(
        np.eye(modes),
        sf.ModalDamping(0.02),
        np.diag((roots / roots[0]) ** 4),
        names=names,
        contacts=sf.FrictionContact(tip, law, load=1.0, Vd=0.0),
        forcing=sf.HarmonicForce(middle, F=0.6),
        f=0.16,
    )


def test_a_response_in_twenty_modes():
    """Modes up to 4,000 times the lowest: no flow of 40 states is differentiated."""
    model = beam(20)
    assert shooting_for(model) is ModalShooting
    branch = sf.response(model, vary="f", span=(0.155, 0.165)).branches[0]
    assert branch.nodes.shape[2] == 40
    assert branch.stable.all()
    assert branch.multiplier_uncertainty.max() < 1e-6
    orbit = sf.periodic_orbit(model.replace(f=branch.parameter[3]))
    np.testing.assert_allclose(orbit.state, branch.nodes[3, 0], atol=1e-8)


@pytest.mark.long
def test_each_orbit_has_a_mesh_of_its_own():
    """Steps move a front of friction by many times its width, and nothing seems to happen there."""
    law, models = sf.Coulomb(mu_k=0.25), []
    for chosen in (law, sf.Regularized(law, e=1e-2), sf.Regularized(law, e=1e-3)):
        contact = sf.FrictionContact("x14", chosen, load=1.0, Vd=0.0)
        given = {"contacts": contact, "elements": (), "forcing": sf.HarmonicForce("x14", F=1.0)}
        models.append(chain(14, **given))
    f = models[0].natural_frequencies[0]
    dry, blunt = (sf.periodic_orbit(model.replace(f=f)).state for model in models[:2])
    (branch,) = sf.response(models[2], "f", (0.97 * f, f)).branches
    assert len(branch) < 30
    assert branch.stable.all()
    assert not branch.special
    assert branch.multiplier_uncertainty.max() < 1e-5
    sharp, blunt = (np.abs(state - dry).max() for state in (branch.nodes[-1, 0], blunt))
    assert sharp < blunt / 5  # the errors of regularization are of the first order


def test_a_fast_mode_is_resolved_or_refused(monkeypatch):
    """It turns a thousand times in a period, and so does what friction does to it."""
    contact = sf.FrictionContact("x1", sf.Regularized(sf.Coulomb(mu_k=0.3), e=0.05), load=1.0, Vd=0)
    stiffness = 1e6 * np.array([[0.01, -0.1], [-0.1, 1.0]]) + np.diag([1.0, 0.0])
    forcing = sf.HarmonicForce("x1", F=1.0)
    model = sf.Structure(
        np.eye(2), 1e-3 * np.eye(2), stiffness, names="x1 x2", contacts=contact, forcing=forcing
    ).replace(f=0.9 / (2 * np.pi))
    orbit, flow = sf.periodic_orbit(model), flow_of(model)
    constants, times = flow.constants(model.vector), np.arange(2.0)[:, None]
    given = orbit.state[None], *times, constants, np.empty((len(constants.values), 0))
    exact = np.poly(flow.linearize(*given)[1][0])
    np.testing.assert_allclose(np.poly(orbit.multipliers), exact, atol=1e-7)
    monkeypatch.setattr("slipfold.orbits.modal_shooting.SHOTS.most", 40)
    with pytest.raises(sf.InputError, match=r"no mesh fits .* more damping of fast modes"):
        sf.periodic_orbit(model)


SKEW = np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 0]])
MASS = np.eye(3) + 0.1 * np.abs(SKEW)
GIVEN = {
    "K": 100 * np.diag([3.0, 2, 1]),
    "names": "x1 x2 x3",
    "variables": sf.Parameter("omega", 1.0, "rad/s", "speed"),
    "forcing": sf.HarmonicForce("x1", F=1.0),
}
WALL = {"load": 1.0, "Vd": 0.1}


def test_an_orbit_that_no_mesh_fits_is_refused(monkeypatch):
    model, words = chain(12), r"no mesh fits the orbit of Structure\(.*f=1\.2.*: each of 8 in turn"
    assert shooting_for(model) is ModalShooting
    monkeypatch.setattr(ModalShooting, "better", lambda self, *given: self)
    with pytest.raises(sf.InputError, match=words):
        sf.periodic_orbit(model.replace(f=1.2))
    with pytest.raises(sf.InputError, match=words):
        sf.response(model, "f", (1.2, 1.3))


@pytest.mark.parametrize(
    "parts",
    [
        {"G": {"omega": SKEW}},
        {"H": {"omega": SKEW}},
        {"K": {1: GIVEN["K"], "omega^2": -0.01 * np.eye(3)}},
        {"C": {1: np.diag([1.0, 0, 0]), "omega": np.diag([0.0, 0.3, 0])}},
    ],
    ids=["gyroscopic", "circulatory", "softening", "damping"],
)
def test_what_couples_modes_at_few_places_is_a_force(parts):
    contact = sf.FrictionContact("x3", sf.Regularized(sf.Coulomb(), e=0.5), **WALL)
    model = sf.Structure(MASS, **{**GIVEN, **parts, "contacts": contact, "f": 2.0, "omega": 3.0})
    free = {"f": 0.2, "omega": 1.0}
    modal = ModalShooting(model, free, mesh=np.linspace(0.0, 1.0, 65))
    nodes = 0.1 * np.random.default_rng(4).normal(size=(8, 6))
    given = nodes, flow_of(model).constants_of(model)
    assert_same(modal.transitions(*given), Shooting(model, free).transitions(*given), 1e-10)


@pytest.mark.parametrize(
    "parts",
    [
        {"G": {"omega": np.kron(np.eye(5), SKEW[:2, :2])}, "K": np.diag(np.arange(1.0, 11))},
        {"C": np.diag([1.0, 2, 3])},
        {"contacts": sf.FrictionContact("x3", sf.Dahl(), **WALL)},
        {"contacts": sf.FrictionContact("x3", sf.Coulomb(), **WALL)},
    ],
    ids=["everywhere", "as many", "memory", "sticking"],
)
def test_what_couples_modes_everywhere_is_left_to_the_flow(parts):
    assert shooting_for(sf.Structure(MASS, **GIVEN, f=1e-3)) is ModalShooting
    mass, own = (np.eye(10), {"names": "x1 x2 x3 a b c d e f1 g"}) if "G" in parts else (MASS, {})
    assert shooting_for(sf.Structure(mass, **{**GIVEN, **own, **parts}, f=1e-3)) is Shooting


@pytest.mark.parametrize(("sectors", "order", "reduction"), [(4, 1, None), (12, 8, 3)])
def test_parts_of_a_period_are_images_around_a_cyclic_structure(sectors, order, reduction):
    """All of an orbit from the sectors' first part, and from all of them by an asymmetric mesh."""
    law = sf.Regularized(sf.Coulomb(mu_k=0.2), e=0.05)
    coupled = np.diag([1.0, 0.0]) + 0.35 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    model = sf.Structure(
        np.diag([1.0, 0.0]), np.diag([0.04, 0.0]), coupled, names="tip next", f=0.22,
        cyclic=sf.CyclicSymmetry(sectors, order, "tip", "next"),
        contacts=sf.FrictionContact("tip", law, load=1.0, Vd=0),
        forcing=sf.HarmonicForce("tip", F=0.4),
        reduction=reduction and sf.FreeInterface(modes=reduction),
    )  # fmt: skip
    constants, count = flow_of(model).constants_of(model), segments_for(model)
    free = {"f": 0.1, "mu_k": 1.0}
    few = ModalShooting(model, free, segments=count)
    orbit = sf.periodic_orbit(model)
    shot = Shooting(model, free, segments=len(orbit.nodes))
    nodes = shot.states(orbit.nodes, constants, few.start)
    few = few.better(nodes, constants) or few
    edges = few.mesh.copy()
    edges[1] += 1e-12  # so that no part is the image of another
    whole = few.on(edges)
    assert (few.images, whole.images) == (sectors // np.gcd(sectors, order), 1)
    fresh, vectors = few.on(few.mesh), np.random.default_rng(3).normal(size=(1, *nodes.shape))
    bent = (by.curvatures(nodes, constants, vectors) for by in (fresh, whole))
    assert_same(*bent, 1e-6)  # of the whole period, which its first part does not go on from
    assert_same(fresh.transitions(nodes, constants), whole.transitions(nodes, constants), 2e-9)
    phases = np.array([0.0, 0.13, 0.5, 0.93])
    lost = nodes.copy()
    lost[1] += 1e-10 * few.scales  # as rounding may do
    for given in (nodes, lost, nodes * (1 + 0.1 * np.arange(count)[:, None])):
        assert_same(few.transitions(given, constants), whole.transitions(given, constants), 2e-9)
        assert_same([few.mismatch(given, constants)], [whole.mismatch(given, constants)], 1e-11)
    assert_same(
        [few.states(nodes, constants, phases)], [whole.states(nodes, constants, phases)], 1e-11
    )
    assert_same(few.stage_states(nodes, constants), whole.stage_states(nodes, constants), 1e-8)
    densities = few.better(nodes, constants), whole.better(nodes, constants)
    assert densities == (None, None)
