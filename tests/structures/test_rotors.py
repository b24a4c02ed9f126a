"""Matrices that depend on parameters: rotors, spin, circulatory forces."""

import json

import numpy as np
import pytest
from scipy import sparse
from scipy.linalg import block_diag, eig

import slipfold as sf
from helpers.beams import free_beam
from slipfold import HarmonicForce, InputError, ModalReduction, Parameter, Structure

M, K = np.diag([2.0, 2.0]), np.diag([50.0, 50.0])
TURN = np.array([[0.0, 1.0], [-1.0, 0.0]])
SPEED = Parameter("omega", 3.0, "rad/s", "rotor speed", lower=0)


def rotor(**options):
    """A disk that whirls: M q'' + omega G q' + K q = 0."""
    return Structure(M, 0.02 * M, K, G={"omega": TURN}, variables=SPEED, names="x y", **options)


def eigenvalues(model):
    values = model.modes().eigenvalues
    return values[np.argsort(values.imag)]


@pytest.mark.parametrize("speed", [0.0, 1.0, 30.0])
@pytest.mark.parametrize("reduction", [None, ModalReduction(2)], ids=["whole", "reduced"])
def test_forward_and_backward_whirl(speed, reduction):
    # With z = x + i y: 2 s^2 + (0.04 - i omega) s + 50 = 0, and the conjugate equation.
    model = rotor(reduction=reduction).replace(omega=speed)
    both = [np.roots([2, 0.04 + sign * 1j * speed, 50]) for sign in (1, -1)]
    exact = np.concatenate(both)
    exact = np.sort_complex(exact[exact.imag > 0].imag + 1j * exact[exact.imag > 0].real)
    found = np.sort_complex(eigenvalues(model).imag + 1j * eigenvalues(model).real)
    np.testing.assert_allclose(found, exact, rtol=1e-9)
    np.testing.assert_allclose(
        model.damping_matrix, 0.02 * model.mass_matrix, rtol=1e-14, atol=1e-15
    )


def test_the_response_of_a_rotor_with_unbalance():
    # Synchronous unbalance: z = F / (K - 2 w^2 + w omega + 0.04 i w) with omega = w = 2 pi f.
    forces = [HarmonicForce("x", F=1.0, group="u"), HarmonicForce("y", phi=-np.pi / 2, name="y",
              group={"F": "u"})]  # fmt: skip
    model = Structure(M, 0.02 * M, K, G={"2*pi*f": TURN}, names="x y", forcing=forces, f=0.7)
    assert "omega" not in model.values
    w = 2 * np.pi * 0.7
    z = 1 / (50 - 2 * w**2 + w * w + 0.04j * w)
    state = sf.periodic_orbit(model).state
    np.testing.assert_allclose(state[:2], [z.real, z.imag], rtol=1e-9)


def test_spin_softening_and_its_energy():
    # The stiffness of a blade that turns: K0 - omega^2 M; the energy is constant without damping.
    model = Structure(M, None, {1: K, "omega^2": -M}, names="x y", omega=2.0)
    exact = np.sqrt(25 - 4) / (2 * np.pi)
    np.testing.assert_allclose(model.natural_frequencies, exact, rtol=1e-12)
    np.testing.assert_allclose(model.stiffness_matrix, K - 4 * M, rtol=1e-15)
    first, last = sf.simulate(model, 3, [0.1, 0.2, 0.3, -0.1]).states[[0, -1]]
    assert model.evaluate("energy", last) == pytest.approx(model.evaluate("energy", first))


def test_internal_damping_makes_a_fast_rotor_unstable():
    # The classic: rotating damping c adds c omega as a circulatory matrix; with external damping d
    # the threshold is at omega = w (1 + d/c).
    c, d, w = 0.3, 0.1, 5.0
    model = Structure(M, (c + d) * np.eye(2), K, H={"omega": c * TURN}, names="x y")
    limit = w * (1 + d / c)
    growth = [eigenvalues(model.replace(omega=limit * x)).real.max() for x in (0.999, 1.001)]
    assert growth[0] < 0 < growth[1]
    diagram = sf.response(model, vary="omega", span=(5, 8))
    (hopf,) = (item for item in diagram.special if item.point.type == "HB")
    assert hopf.point.value == pytest.approx(limit, rel=1e-9)
    # Energy balance along a motion: its rate is what circulation puts in less what damping takes.
    state, step = np.array([0.3, -0.2, 0.5, 0.7]), 1e-5
    model = model.replace(omega=20, duration=step)
    energies = [model.evaluate("energy", one) for one in sf.simulate(model, 2, state).states]
    rate = (energies[2] - energies[0]) / (2 * step)
    middle = sf.simulate(model, 1, state).states[-1]
    power = model.evaluate("power_circulatory", middle) - model.evaluate("power_damping", middle)
    assert rate == pytest.approx(power, rel=1e-6)


def test_a_large_rotor_is_reduced():
    size = 800
    spread = sparse.diags_array(np.linspace(1, 900, size))
    turn = sparse.kron(sparse.eye_array(size // 2), TURN)
    model = Structure(sparse.eye_array(size), None, spread, G={"omega": turn}, omega=0.5,
                      reduction=ModalReduction(6))  # fmt: skip
    assert len(model.states) == 12
    pair = np.diag(np.linspace(1, 900, size)[:2])
    first = np.linalg.eigvals(np.block([[np.zeros((2, 2)), np.eye(2)], [-pair, -0.5 * TURN]]))
    lowest = np.sort(np.abs(first.imag))[0]
    assert eigenvalues(model).imag[0] == pytest.approx(lowest, rel=1e-9)


def test_files_have_formulas_and_variables(tmp_path):
    np.save(tmp_path / "G.npy", TURN)
    text = (
        '[structure]\nM = { diagonal = [2, 2] }\nK = { 1 = { diagonal = [50, 50] }, "omega^2" = '
        '[[-2, 0], [0, -2]] }\nG = { omega = "G.npy" }\nH = { h = [[0, 1], [-1, 0]] }\n'
        'names = "x y"\n[variables]\nomega = { value = 3, unit = "rad/s", min = 0, doc = "rotor '
        'speed" }\n[parameters]\nomega = "60 rpm"\n'
    )
    (tmp_path / "rotor.toml").write_text(text.replace("60 rpm", "60 Hz"))
    with pytest.raises(InputError, match="omega = '60 Hz' has the unit 'Hz'; give a number, or"):
        Structure.from_toml(tmp_path / "rotor.toml")
    (tmp_path / "rotor.toml").write_text(text)
    model = Structure.from_toml(tmp_path / "rotor.toml")
    same = Structure(
        M, None, {1: K, "omega^2": -M}, G={"omega": TURN}, H={"h": TURN}, variables=[SPEED],
        names="x y", name="rotor", title="", omega=60 * (np.pi / 30),
    )  # fmt: skip
    assert model == same
    assert model.parameter("omega") == SPEED
    assert Structure.from_tables(json.loads(json.dumps(model.to_tables()))) == model


def chain(count):
    return 2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)


@pytest.mark.parametrize(
    "reduction", [None, pytest.param(sf.FreeInterface(modes=4), marks=pytest.mark.long)]
)
def test_a_mass_that_is_a_parameter(reduction):
    # A tuned mass on a chain, and the same with its mass in M.
    count, added = 4, 0.7
    mass = np.eye(count) + 0.1 * (np.eye(count, k=1) + np.eye(count, k=-1))
    there = np.diag([0.0, 1, 0, 0])
    parts = {
        "C": 0.05 * np.eye(count), "K": 10 * chain(count), "names": "a b c d", "f": 0.3,
        "reduction": reduction, "watch": {"u": "d"},
        "elements": sf.CubicSpring("c", k3=3.0), "forcing": HarmonicForce("b", F=0.5),
        "contacts": sf.FrictionContact("a", sf.Dahl(s0=9, mu_k=0.2, e=0.01), load=0.3, Vd=0.1),
    }  # fmt: skip
    model = Structure({1: mass, "m - 1": 2 * there}, **parts).replace(m=1 + added / 2)
    exact = Structure(mass + added * there, **parts)
    if reduction is None:
        np.testing.assert_allclose(model.natural_frequencies, exact.natural_frequencies, rtol=1e-12)
        np.testing.assert_allclose(model.mass_matrix, exact.mass_matrix, rtol=1e-14)
    orbits = [sf.periodic_orbit(one) for one in (model, exact)]
    for output in ("u", "energy"):
        found, known = (orbit.output(output, 32)[1] for orbit in orbits)
        np.testing.assert_allclose(found, known, atol=1e-8)
    assert Structure.from_tables(json.loads(json.dumps(model.to_tables()))) == model


def test_two_masses_that_are_parameters():
    model = Structure({1: np.eye(3), "m": np.diag([1.0, 0, 0]), "2*n": np.diag([0, 1.0, 1])}, None,
                      chain(3), m=0.3, n=0.2)  # fmt: skip
    exact = Structure(np.diag([1.3, 1.4, 1.4]), None, chain(3))
    np.testing.assert_allclose(model.natural_frequencies, exact.natural_frequencies, rtol=1e-13)
    np.testing.assert_allclose(model.modes().frequency, exact.natural_frequencies, rtol=1e-12)


@pytest.mark.parametrize("speed", [0.0, 40.0, 300.0])
def test_an_overhung_rotor(speed):
    # A disk at the end of a shaft, displacement x + i y and slopes p + i q: with the polar inertia
    # P, det [[m s^2 + k11, k12], [k12, J s^2 - i P W s + k22]] = 0 (Childs, Turbomachinery
    # Rotordynamics 1993, chapter 1).
    m, inertia, polar = 3.0, 0.02, 0.035
    bend, length = 900.0, 0.4
    k11, k12, k22 = 12 * bend / length**3, -6 * bend / length**2, 4 * bend / length
    mass = np.diag([m, m, inertia, inertia])
    stiffness = np.kron(np.array([[k11, k12], [k12, k22]]), np.eye(2))
    turn = np.zeros((4, 4))
    turn[2:, 2:] = polar * TURN
    model = Structure(mass, None, stiffness, G={"omega": turn}, names="x y p q", omega=speed)
    modes = model.modes()
    # s = i w: in w real roots, those above zero whirl forward.
    roots = np.roots([m * inertia, -m * polar * speed, -(m * k22 + inertia * k11),
                      k11 * polar * speed, k11 * k22 - k12**2]).real  # fmt: skip
    order = np.argsort(np.abs(roots))
    np.testing.assert_allclose(2 * np.pi * modes.damped_frequency, np.abs(roots)[order], rtol=1e-9)
    if speed:
        forward = np.sign(roots[order])
        np.testing.assert_allclose(modes.whirl("x", "y"), forward, atol=1e-9)
        np.testing.assert_allclose(modes.whirl("q", "p"), -forward, atol=1e-9)
    reduced = model.replace(reduction=ModalReduction(4), watch={"u": "x", "v": "y"}).modes()
    np.testing.assert_allclose(reduced.damped_frequency, modes.damped_frequency, rtol=1e-9)
    assert reduced.names == ("u", "v")
    if speed:
        np.testing.assert_allclose(reduced.whirl("u", "v"), forward, atol=1e-8)
    with pytest.raises(
        InputError, match="the modes have no displacement 'z'; they have x, y, p, q"
    ):
        modes.whirl("x", "z")


@pytest.mark.parametrize(("options", "words"), [
    ({"G": K}, "G is not skew-symmetric: row 1, column 1 is 50, not 0; put its"),
    ({"G": {"omega": np.eye(3)}}, "G has 3 rows and M has 2"),
    ({"G": {"omega": TURN, 1: np.eye(3)}}, "G has 3 rows where 1 multiplies it and 2 where omega"),
    ({"M": {"omega": M}}, "the constant part of M is zero; give at least one degree"),
    ({"M": {1: M, "m": TURN}}, "M is not symmetric: row 1, column 2 is 1, row 2, column 1 is -1"),
    ({"M": {1: M, "m": M}, "m": -2}, "M is not positive definite at these values of its param"),
    ({"M": {1: M, "m": np.diag([1.0, 0]), "n": np.ones((2, 2))}}, "M are not diagonal in the same"),
    ({"M": {1: M, "m": M}, "forcing": sf.BaseMotion(A=1)}, "a base motion acts with the masses"),
    ({"H": {}}, "H is an empty mapping; give matrices by formulas"),
    ({"H": {"2*": M}}, "'2*' cannot multiply a matrix: "),
    ({"H": {"omega": M}, "variables": 3}, "variables has 3, which is no parameter"),
    ({"H": {"omega": M}, "omega": -1}, "omega = -1 is outside its bounds"),
    ({"M": np.diag([1.0, 0]), "H": {"omega": TURN}}, "H acts on q2, which has no mass"),
])  # fmt: skip
def test_what_cannot_be(options, words):
    with pytest.raises(InputError) as caught:
        Structure(**{"M": M, "K": K, "variables": SPEED, **options})
    assert words in str(caught.value)


def shaft():
    """M, C, K and G of a shaft with a disk on each of 31 nodes; a bearing is softer along x."""
    mass, stiffness = free_beam(30)
    mass[1::2, 1::2] += 1e-4 * np.eye(31)
    stiffness[[0, 60], [0, 60]] += 300.0
    tilted = stiffness + 100.0 * np.eye(62, 1) @ np.eye(1, 62)
    damping = np.diag(np.isin(np.arange(62), [0, 60]) * 2.0)
    spin = np.diag(np.tile([0.0, 2e-4], 31))
    planes = [(mass, mass), (damping, damping), (stiffness, tilted)]
    return *(block_diag(*pair) for pair in planes), np.kron(TURN, spin)


def answers(mass, damping, stiffness, places, turns):
    """Displacements for unit forces at circular frequencies. Shapes: (n, 2), (f,); (f, 2, 2)."""
    dynamic = (stiffness - w**2 * mass + 1j * w * damping for w in turns)
    return np.array([places.T @ np.linalg.solve(one, places) for one in dynamic])


def test_a_shaft_of_disks_needs_no_complex_modes():
    """Its error is that reported; no more states than complex modes, and they fit all speeds."""
    mass, damping, stiffness, gyroscopic = shaft()
    names = [f"{kind}{node}" for axis in "xy" for node in range(31) for kind in (axis, "r" + axis)]
    model = Structure(
        mass, damping, stiffness, names=names, G={"omega": gyroscopic}, variables=SPEED,
        elements=sf.CubicSpring("x11", k3=1.0), forcing=HarmonicForce("y20", F=1.0),
        reduction=sf.FreeInterface(up_to=15, accuracy=1e-4),
    )  # fmt: skip
    basis = model.basis
    places = np.eye(124)[:, [names.index("x11"), names.index("y20")]]
    turns = np.linspace(0.5, 2 * np.pi * 15, 400)
    for omega in (0.0, 30.0, 100.0):
        parts = mass, damping + omega * gyroscopic, stiffness * (1 + 0.02j)
        exact = answers(*parts, places, turns)
        found = answers(*(basis.T @ part @ basis for part in parts), basis.T @ places, turns)
        typical = np.exp(np.log(np.abs(np.einsum("faa->fa", exact))).mean(axis=0))
        size = np.maximum(np.abs(exact), np.sqrt(np.outer(typical, typical)))
        error = (np.abs(found - exact) / size).max()
        reported = model.replace(omega=omega).reduction_report.receptance_error
        assert reported / 2 < error < 2 * reported
        assert error < 1e-3
        rates = -np.linalg.solve(mass, np.hstack([parts[2], parts[1]]))
        values, left, right = eig(np.vstack([np.eye(124, 248, 124), rates]), left=True)
        few = np.argsort(np.abs(values))[: 2 * basis.shape[1]]
        left, right = left[:, few], right[:, few]
        inputs = left[124:].conj().T @ np.linalg.solve(mass, places)
        inputs /= np.sum(left.conj() * right, axis=0)[:, None]
        turned = 1 / (1j * turns[:, None] - values[few])
        modal = np.einsum("ai,fi,ib->fab", places.T @ right[:124], turned, inputs)
        assert error < (np.abs(modal - exact) / size).max()


def test_the_accuracy_of_a_reduction_is_that_reported_at_the_speed_of_the_rotor():
    mass, damping, stiffness, gyroscopic = shaft()
    slow, fast = (
        Structure(
            mass, damping, stiffness, G={"omega": gyroscopic}, variables=Parameter("omega", omega),
            elements=sf.CubicSpring("q14", k3=1.0), forcing=HarmonicForce("q85", F=1.0),
            reduction=sf.FreeInterface(up_to=15, accuracy=1e-2),
        )
        for omega in (0.0, 300.0)
    )  # fmt: skip
    assert fast.reduction_report.receptance_error < 1e-2
    assert slow.replace(omega=300.0).reduction_report.receptance_error > 0.1


def test_flutter_by_few_real_modes():
    """Friction of a tilted spring that presses on a shaft couples two planes: two modes merge."""
    mass, _, stiffness, _ = shaft()
    pair = np.eye(124)[[40, 102]]
    across, along = [0.28, 0.96] @ pair, [0.96, -0.28] @ pair
    stiffness += 3000 * np.outer(across, across)
    whole, few = (
        Structure(
            mass, 1e-6 * stiffness, stiffness, H={"mu": -3000 * np.outer(along, across)},
            forcing=HarmonicForce("q41", F=1.0), variables=Parameter("mu", 0.5),
            reduction=reduction,
        )
        for reduction in (None, sf.FreeInterface(up_to=30, accuracy=1e-4))
    )  # fmt: skip
    assert few.basis.shape[1] < 30
    for mu in (0.0, 0.2, 0.4, 1.0):
        exact, found = (eigenvalues(model.replace(mu=mu))[:8] for model in (whole, few))
        assert (exact.real.max() > 0) == (mu > 0.3)
        assert (np.abs(found[:, None] - exact).min(axis=0) < 1e-8 * np.abs(exact)).all()
