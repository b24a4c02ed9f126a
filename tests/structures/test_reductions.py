"""Reduced structures: the full ones if nothing is left out, and the error that is computed."""

import numpy as np
import pytest
from scipy import sparse
from scipy.linalg import eigh
from tests.helpers.beams import free_beam

import slipfold as sf
from slipfold import InputError

DAMPING = sf.ProportionalDamping(alpha_M=0.05, beta_K=0.002)


def chain(size, held=True):
    """Unit masses and springs of 100 N/m, fixed at the root, or free at both ends."""
    rows = [-np.ones(size), 2 * np.ones(size), -np.ones(size)]
    rows[1][-1] = 1
    rows[1][0] = 2 if held else 1
    k = 100 * sparse.dia_array((rows, [-1, 0, 1]), shape=(size, size))
    return sparse.eye_array(size), k.tocsr()


def rubbing(size, reduction=None, held=True, **values):
    """A chain with a force in the middle, and friction and a cubic spring at its tip."""
    mass, stiffness = chain(size, held)
    tip = f"q{size}"
    return sf.Structure(
        mass,
        DAMPING,
        stiffness,
        reduction=reduction,
        contacts=sf.FrictionContact(tip, sf.Regularized(sf.Coulomb(mu_k=0.3), e=0.5), load=3, Vd=0),
        elements=sf.CubicSpring(tip, k3=2.0),
        forcing=sf.HarmonicForce(f"q{size // 2}", F=3.0),
        watch={"u": tip},
        **values,
    )


@pytest.mark.long
@pytest.mark.parametrize("size", [6, 10, 20])
def test_nothing_left_out_changes_no_orbit(size):
    reductions = [
        sf.FreeInterface(modes=size),
        sf.FreeInterface(modes=size - 2),  # and two static shapes, which are the rest
        sf.CraigBampton([f"q{size // 2}", f"q{size}"], modes=size - 2),
    ]
    models = [rubbing(size, reduction, f=1.9 / size) for reduction in (None, *reductions)]
    orbits = [sf.periodic_orbit(model) for model in models]
    tips = [model.evaluate("u", orbit.state)
            for model, orbit in zip(models, orbits, strict=True)]  # fmt: skip
    assert tips == pytest.approx(len(tips) * tips[:1], rel=1e-8)
    sizes = [np.sort(np.abs(orbit.multipliers))[::-1][:8] for orbit in orbits]
    assert np.array(sizes) == pytest.approx(np.array(len(sizes) * sizes[:1]), abs=1e-6)
    for small in models[1:]:
        matrices = (small.mass_matrix, small.stiffness_matrix, small.damping_matrix)
        assert all(np.array_equal(part, np.diag(np.diag(part))) for part in matrices)
        assert len(small.states) == 2 * size
        assert small.reduction_report.receptance_error < 1e-9


def test_nothing_left_out_changes_no_fold():
    def folds(reduction):
        model = rubbing(3, reduction, F=6.0, Ns=1.0)
        (branch,) = sf.response(model, vary="f", span=(0.6, 1.2)).branches
        return [point.value for point in branch.special if point.type == "LP"]

    expected = folds(None)
    assert len(expected) == 2
    assert folds(sf.FreeInterface(modes=2)) == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("held", [True, False])
def test_static_forces_cause_the_exact_displacement(held):
    size = 12
    mass, stiffness = (part.toarray() for part in chain(size, held))
    model = rubbing(size, sf.FreeInterface(modes=3), held)
    squares, shapes = eigh(stiffness, mass)
    kept = slice(0, None) if held else slice(1, None)  # a free chain has no static displacement
    for force in (size // 2 - 1, size - 1):
        exact = shapes[:, kept] @ (shapes[force, kept] / squares[kept])
        rows, stiff = model.basis, np.diag(model.stiffness_matrix)
        elastic = stiff > 1e-9 * stiff.max()
        found = rows[:, elastic] @ (rows[force, elastic] / stiff[elastic])
        assert found == pytest.approx(exact, rel=1e-9, abs=1e-9 * np.abs(exact).max())


def largest_error(model, mass, stiffness, directions, frequencies):
    """Largest error of a receptance, with the loss factor of the report."""
    squares, shapes = eigh(stiffness, mass)
    stiff, moved = np.diag(model.stiffness_matrix), np.diag(model.mass_matrix)
    answers = []
    for rows, k, m in ((shapes, squares, np.ones(len(squares))), (model.basis, stiff, moved)):
        there = rows[directions]
        turned = (2 * np.pi * frequencies[:, None]) ** 2
        answers.append(there @ ((1 / (k * (1 + 0.02j) - turned * m))[:, :, None] * there.T))
    exact, found = answers
    mean = np.exp(np.log(np.abs(np.einsum("faa->fa", exact))).mean(axis=0))
    scale = np.maximum(np.abs(exact), np.sqrt(np.outer(mean, mean)))
    return (np.abs(found - exact) / scale).max()


@pytest.mark.parametrize("size", [40, 700])  # full and sparse matrices
@pytest.mark.parametrize("kind", [sf.FreeInterface, sf.ModalReduction, sf.CraigBampton])
def test_as_many_modes_as_the_accuracy_needs(size, kind):
    ends = [f"q{size // 2}", f"q{size}"]
    boundary = [ends] if kind is sf.CraigBampton else []
    frequencies = sf.Structure(*(part.toarray() for part in chain(40)[:1]), None,
                               chain(40)[1].toarray()).natural_frequencies  # fmt: skip
    band = frequencies[4] * 40 / size
    accuracy = 2e-2 if kind is sf.ModalReduction else 1e-3
    model = rubbing(size, kind(*boundary, up_to=band, accuracy=accuracy))
    report = model.reduction_report
    assert report.receptance_error <= accuracy
    assert report.whole == size
    mass, stiffness = (part.toarray() for part in chain(size))
    there = [size // 2 - 1, size - 1]
    spread = np.linspace(band / 500, band, 500)
    assert largest_error(model, mass, stiffness, there, spread) < 1.2 * accuracy
    count = len(model.states) // 2 - (0 if kind is sf.ModalReduction else 2)
    fewer = rubbing(size, kind(*boundary, modes=count - 1))
    assert (
        fewer.reduction_report.band < band
        or largest_error(fewer, mass, stiffness, there, spread) > accuracy / 2
    )


def test_equal_parts_have_all_their_modes():
    """Two pads alike, ten blades alike: each frequency as often as there are parts."""
    mass, stiffness = chain(100)
    structure = sf.Structure(
        sparse.block_diag([mass] * 10), DAMPING, sparse.block_diag([stiffness] * 10),
        reduction=sf.FreeInterface(modes=30), forcing=sf.HarmonicForce("q100", F=1.0),
    )  # fmt: skip
    frequencies = structure.natural_frequencies[:30]
    turns = (2 * np.repeat([0, 1, 2], 10) + 1) * np.pi / (2 * 201)
    np.testing.assert_allclose(np.pi * frequencies, 10 * np.sin(turns), rtol=1e-9)
    assert structure.reduction_report.error < 1e-9


def test_a_free_structure_keeps_its_rigid_body_motion():
    model = rubbing(800, sf.FreeInterface(modes=4), held=False)
    exact = 2 * 10 * np.sin(np.arange(4) * np.pi / 1600) / (2 * np.pi)
    assert model.natural_frequencies[:4] == pytest.approx(exact, abs=1e-7)
    assert "receptances by" in str(model.reduction_report)


@pytest.mark.parametrize(("reduction", "words"), [
    (lambda: sf.FreeInterface(modes=3, accuracy=1e-3), "give up_to, the frequency in Hz"),
    (lambda: sf.FreeInterface(up_to=1, accuracy=2), "give a relative error between 0 and 1"),
    (lambda: sf.FreeInterface(up_to=1, accuracy="5 Hz"), "accuracy = '5 Hz' has the unit"),
    (lambda: rubbing(700, sf.ModalReduction(up_to=0.1, accuracy=1e-7)), "with up to 120 modes"),
    (lambda: sf.Structure([[1]], None, [[1]], reduction=sf.FreeInterface(up_to=1, accuracy=0.1)),
     "the structure has none; add one"),
])  # fmt: skip
def test_accuracies_that_cannot_be(reduction, words):
    with pytest.raises(sf.InputError) as caught:
        reduction()
    assert words in str(caught.value)


def lumped_beam(count):
    """A free beam of the length, mass and stiffness one, of elements with lumped masses."""
    h = 1 / count
    m = np.tile([h, h**3 / 12], count + 1)
    m[[0, 1, -2, -1]] /= 2
    return np.diag(m), free_beam(count)[1]


@pytest.mark.parametrize("count", [12, 50, 400])
@pytest.mark.parametrize(
    "reduction", [sf.FreeInterface(modes=6), sf.CraigBampton(["q1", "q2"], modes=6)]
)
def test_rounding_of_rigid_body_modes_is_no_stiffness_and_no_error(count, reduction):
    m, k = lumped_beam(count)
    model = sf.Structure(m, None, k, forcing=sf.HarmonicForce("q1", F=1), reduction=reduction)
    report = model.reduction_report
    assert not model.natural_frequencies[:2].any()
    assert not report.exact[:2].any()
    # A free beam, cos(x) cosh(x) = 1; lumped masses have errors of second order.
    assert report.frequencies[2] == pytest.approx(
        4.73004074486270**2 / (2 * np.pi), rel=6 / count**2
    )
    assert report.errors[:4].max() < 2e-2
    assert report.receptance_error < 1  # it was 1e9 by rounding
    assert model.notes == (
        f"2 of {len(report.exact)} modes have no stiffness: only elements, contacts and other "
        "matrices can hold them",
    )


def test_an_accuracy_holds_at_the_resonances_of_the_coordinates_that_are_kept():
    mass, stiffness = chain(30)
    middle, tip = (sparse.diags_array(100 * np.eye(30)[at]) for at in (15, 29))
    model = sf.Structure(
        mass, DAMPING, {1: stiffness + tip, "s": middle}, variables=sf.Parameter("s", 10.0),
        elements=sf.CubicSpring("q30", k3=1.0), forcing=sf.HarmonicForce("q1", F=1.0),
        reduction=sf.FreeInterface(up_to=1.5, accuracy=0.1),
    )  # fmt: skip
    assert model.reduction_report.receptance_error <= 0.1


def test_no_error_is_known_where_a_matrix_has_no_finite_value():
    mass, stiffness = chain(30)
    grounded = sparse.diags_array(np.eye(30)[15])

    def reduced(**more):
        return sf.Structure(
            mass, DAMPING, {1: stiffness, "1/s": grounded}, variables=sf.Parameter("s", 0.0),
            elements=sf.CubicSpring("q30", k3=1.0), reduction=sf.FreeInterface(up_to=1.5, **more),
        )  # fmt: skip

    words = "'1/s' multiplies a matrix and has no finite value at s = 0, where the error"
    for asked in (lambda: reduced(accuracy=1e-2), lambda: reduced().reduction_report):
        with pytest.raises(InputError, match=words):
            asked()
    assert reduced().replace(s=1.0).reduction_report.receptance_error > 0


def test_rounding_of_a_fine_beam_is_stated():
    m, k = lumped_beam(400)
    model = sf.Structure(m[2:, 2:], None, k[2:, 2:], reduction=sf.ModalReduction(modes=2))
    report = model.reduction_report
    exact = 1.87510406871196**2 / (2 * np.pi)
    assert abs(report.frequencies[0] / exact - 1) < report.rounding + 1e-5
    assert 1e-7 < report.rounding < 1e-3
    assert "rounding of the stiffness matrix changes the lowest by up to" in str(report)


@pytest.mark.parametrize("form", [np.asarray, sparse.csr_array])
def test_a_fine_free_beam_has_exact_static_shapes(form):
    mass, stiffness = free_beam(120)
    names = [f"{kind}{node}" for node in range(121) for kind in "wr"]
    model = sf.Structure(
        form(mass), None, form(stiffness), names=names, reduction=sf.FreeInterface(modes=4),
        forcing=sf.HarmonicForce("w120", F=1),
    )  # fmt: skip
    # Without the rigid-body motion the tip of a free beam under a unit force at it and its inertia
    # moves by 1/105 (L^3/EI): the sum of all modes but the first two.
    few = model._assembly.reduced.coordinates
    tip = few.shapes[names.index("w120")]
    elastic = few.squares > 1
    flexibility = np.sum(tip[elastic] ** 2 / (few.masses * few.squares)[elastic])
    assert flexibility == pytest.approx(1 / 105, rel=1e-5)


@pytest.mark.parametrize("count", [20, 320])
def test_a_boundary_that_does_not_hold_a_beam_is_refused(count):
    mass, stiffness = free_beam(count)
    names = [f"{kind}{node}" for node in range(count + 1) for kind in "wr"]
    held = sf.CraigBampton([f"w{count}"], modes=3)
    with pytest.raises(InputError, match="the boundary does not hold the rest of the structure"):
        sf.Structure(mass, None, stiffness, names=names, reduction=held)


def test_what_may_hide_a_motion_is_named():
    contact = sf.FrictionContact("a", sf.Regularized(sf.Coulomb(mu_k=0.3), e=0.1), load=1, Vd=0)
    loose = sf.Structure(np.eye(2), None, [[1, -1], [-1, 1]], names="a b", contacts=contact,
                         forcing=sf.HarmonicForce("b", F=0.1), f=0.3)  # fmt: skip
    why = "mode 1 has no stiffness, so that nothing may determine the mean of a, b; add a LinearSp"
    with pytest.raises(InputError, match=why):
        sf.periodic_orbit(loose)
    with pytest.raises(InputError, match=why):
        sf.response(loose, "f", (0.2, 0.4))
    with pytest.raises(InputError, match=why):
        sf.response(loose.replace(forcing=(), Vd=1), "Vd", (0.5, 2))
    stiff = loose.replace(C=0.1 * np.eye(2), K=[[1, -1], [-1, 1e10]])
    why = r"mode 2 at .* is 1e\+10 times as stiff as mode 1 .*; give reduction=ModalReduction"
    with pytest.raises(InputError, match=f"no mesh fits the orbit of .*; {why}"):
        sf.periodic_orbit(stiff)
    assert sf.Structure(np.eye(2), None, np.diag([1.0, 1e6])).advice == ""
