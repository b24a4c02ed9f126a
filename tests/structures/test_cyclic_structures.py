"""Cyclic symmetry: one sector against closed forms and against all sectors as one structure."""

import numpy as np
import pytest
from scipy import sparse

import slipfold as sf
from slipfold import CyclicSymmetry, FrictionContact, HarmonicForce, InputError, Structure
from slipfold.models.structures.receptance import FullStructure

SPRING = np.array([[1.0, -1.0], [-1.0, 1.0]])
LAW = sf.Regularized(sf.Coulomb(mu_k=0.2), e=0.3)
COUPLING = 0.35


def tips(sectors, order, **options):
    """A mass on a spring, coupled with its neighbors."""
    parts = {
        "contacts": FrictionContact("tip", LAW, load=1.0, Vd=0),
        "forcing": HarmonicForce("tip", F=0.4),
        **options,
    }
    return Structure(
        np.diag([1.0, 0.0]), np.diag([0.04, 0.0]), np.diag([1.0, 0.0]) + COUPLING * SPRING,
        names="tip next", cyclic=CyclicSymmetry(sectors, order, "tip", "next"), f=0.22, **parts,
    )  # fmt: skip


def sector():
    """Matrices of a sector whose boundary, of two degrees of freedom, has mass and damping."""
    random = np.random.default_rng(5)
    root = random.normal(size=(6, 6))
    mass = np.diag([1.0, 2, 0.5, 0.4, 0.6, 0.8]) + 0.1 * np.eye(6, k=1) + 0.1 * np.eye(6, k=-1)
    return mass, root @ root.T + np.eye(6)


def whole(matrix, sectors):
    """All sectors of four degrees of freedom; the last two of a sector are the next one's first."""
    result = np.zeros((4 * sectors, 4 * sectors))
    for one in range(sectors):
        places = [4 * one + at for at in range(4)] + [
            4 * ((one + 1) % sectors) + at for at in (0, 1)
        ]
        result[np.ix_(places, places)] += matrix
    return result


@pytest.mark.parametrize("sectors", [2, 7, 12])
def test_natural_frequencies_of_a_chain(sectors):
    diameter = np.arange(sectors // 2 + 1)
    exact = np.sqrt(1 + 2 * COUPLING * (1 - np.cos(2 * np.pi * diameter / sectors))) / (2 * np.pi)
    found = tips(sectors, 1).diameter_frequencies(modes=1)
    np.testing.assert_allclose(found[:, 0], exact, rtol=1e-13)


@pytest.mark.parametrize("sectors", [5, 6])
def test_a_sector_has_the_frequencies_of_all(sectors):
    mass, stiffness = sector()
    cyclic = CyclicSymmetry(sectors, 1, "a b", "e f")
    model = Structure(mass, None, stiffness, names="a b c d e f", cyclic=cyclic)
    ring = Structure(whole(mass, sectors), None, whole(stiffness, sectors))
    found = model.diameter_frequencies(modes=4)
    twice = [1 if d == 0 or 2 * d == sectors else 2 for d in range(len(found))]
    both = np.sort(np.repeat(found, twice, axis=0).ravel())
    np.testing.assert_allclose(both, ring.natural_frequencies, rtol=1e-11)
    np.testing.assert_allclose(model.natural_frequencies, ring.natural_frequencies, rtol=1e-11)


def test_a_third_of_the_sectors_are_all_of_them():
    # Engine order 2 of 6, with friction to the ground and between neighbors, and a cubic spring.
    order, sectors = 2, 6
    few = tips(
        sectors,
        order,
        contacts=[
            FrictionContact("tip", LAW, load=1.0, Vd=0, name="ground"),
            FrictionContact({"tip": 1, "next": -1}, LAW, load=0.5, Vd=0, name="shroud"),
        ],
        elements=sf.CubicSpring("tip", k3=0.05),
    )
    names = [f"q{number}" for number in range(sectors)]
    turn = np.roll(np.eye(sectors), 1, axis=0)
    ring = Structure(
        np.eye(sectors),
        0.04 * np.eye(sectors),
        np.eye(sectors) + COUPLING * (2 * np.eye(sectors) - turn - turn.T),
        names=names,
        contacts=[
            contact
            for name, other in zip(names, np.roll(names, -1).tolist(), strict=True)
            for contact in (
                FrictionContact(name, LAW, load=1.0, Vd=0, name=f"g{name}", group="ground"),
                FrictionContact({name: 1, other: -1}, LAW, 0.5, Vd=0, name=f"s{name}"),
            )
        ],
        elements=[sf.CubicSpring(name, k3=0.05, name=name) for name in names],
        forcing=[
            HarmonicForce(name, F=0.4, phi=-2 * np.pi * order * at / sectors, name=f"f{name}")
            for at, name in enumerate(names)
        ],
        f=0.22,
    )
    assert [state.name for state in few.states[:3]] == ["tip", "tip_s1", "tip_s2"]
    assert "Ns_ground" in few.values
    assert not any(name.endswith("_s1") for name in few.values)
    orbit, all_of_it = sf.periodic_orbit(few), sf.periodic_orbit(ring)
    size = np.abs(orbit.state).max()
    for at in range(sectors):
        found = all_of_it.state[[at, sectors + at]]
        np.testing.assert_allclose(found, orbit.state[[at % 3, 3 + at % 3]], atol=1e-9 * size)
    # Perturbations that repeat after three sectors are among those of all.
    distance = np.abs(orbit.multipliers[:, None] - all_of_it.multipliers).min(axis=1)
    assert distance.max() < 1e-7


def test_sectors_follow_each_other_backward():
    # Engine order 5 of 6 travels as a backward wave of one nodal diameter.
    model = tips(6, 5, reduction=sf.FreeInterface(modes=6), watch={"u": "tip", "v1": "next"})
    assert model.structure["cyclic"].nodal_diameter == 1
    orbit = sf.periodic_orbit(model)
    (_, own), (_, following) = orbit.output("u", 48), orbit.output("v1", 48)
    np.testing.assert_allclose(following, np.roll(own, 40), atol=1e-10)
    np.testing.assert_allclose(orbit.mean("power_friction"), orbit.mean("power_friction_s1"))


def test_modulated_loads_and_memories_are_later_too():
    contact = FrictionContact(
        "tip", sf.Dahl(s0=4.0, mu_k=0.3, e=0.01), sf.ModulatedLoad(Ns=1, Nd=0.4), Vd=0.1, name="pad"
    )
    orbit = sf.periodic_orbit(tips(4, 1, contacts=contact))
    for name in ("N_pad", "Fx_pad"):
        (_, own), (_, following) = orbit.output(name, 40), orbit.output(f"{name}_s1", 40)
        np.testing.assert_allclose(following, np.roll(own, 10), atol=1e-8)


def test_sectors_that_move_alike_are_one():
    alike = tips(12, 12, forcing=[HarmonicForce("tip", F=0.4), sf.BaseAcceleration(a=0.1)])
    alone = Structure([[1.0]], [[0.04]], [[1.0]], names="tip", f=0.22, forcing=alike.structure[
        "forcing"], contacts=alike.structure["contacts"])  # fmt: skip
    assert len(alike.states) == 2
    found = [sf.periodic_orbit(one.replace(F_tip=0.4, a=0.1, Vd=0, mu_k=0.2, e=0.3)).state
             for one in (alike, alone)]  # fmt: skip
    np.testing.assert_allclose(*found, atol=1e-11)


def test_a_sector_in_a_file(tmp_path):
    text = """
        [structure]
        M = { diagonal = [1, 0] }
        C = { diagonal = [0.04, 0] }
        K = [[1.35, -0.35], [-0.35, 0.35]]
        names = "tip next"
        [cyclic]
        sectors = 12
        engine_order = 4
        low = "tip"
        high = ["next"]
        [reduction]
        type = "CraigBampton"
        boundary = ["tip"]
        modes = 0
        [[forcing]]
        type = "HarmonicForce"
        at = "tip"
        F = 0.4
        [parameters]
        f = 0.22
    """
    path = tmp_path / "disk.toml"
    path.write_text(text.replace('"CraigBampton"\n        boundary = ["tip"]\n        modes = 0',
                                 '"ModalReduction"\n        modes = 3'))  # fmt: skip
    model = Structure.from_toml(path)
    assert model == Structure.from_tables(model.to_tables())
    assert "12 sectors" in model.notes[0]
    again = tips(12, 4, contacts=(), reduction=sf.ModalReduction(3), name="disk", title="")
    assert model == again
    with pytest.raises(InputError, match="boundary is the whole structure"):
        Structure.from_toml(text)


MISTAKES = {
    "one sector": (lambda: tips(1, 0), "sectors = 1; give a whole number from 2 to 1000"),
    "half an order": (lambda: tips(4, 0.5), "engine_order = 0.5; give a whole number from 0"),
    "boundaries": (
        lambda: CyclicSymmetry(4, 1, "a b", "c"),
        "low has 2 degrees of freedom and high 1; give",
    ),
    "twice": (lambda: CyclicSymmetry(4, 1, "a a", "c d"), "low has a degree of freedom twice"),
    "no names": (lambda: CyclicSymmetry(4, 1, [3], ["d"]), "low = .3.; give names of degrees"),
    "no such name": (
        lambda: Structure([[1]], None, [[1]], names="a", cyclic=CyclicSymmetry(4, 1, "a", "b")),
        "high has 'b', which is no degree of freedom of the sector; it has a",
    ),
    "one boundary": (
        lambda: Structure(
            np.eye(2), None, SPRING, names="a b", cyclic=CyclicSymmetry(4, 1, "a b", "b a")
        ),
        "a is in low and in high",
    ),
    "name of another": (
        lambda: Structure(
            np.eye(3), None, np.eye(3), names="a b a_s1", cyclic=CyclicSymmetry(4, 1, "a", "b")
        ),
        "has the name of another sector's, such as tip_s1",
    ),
    "not cyclic": (lambda: Structure([[1]], None, [[1]], cyclic=12), "cyclic = 12 is none; give"),
    "no diameters": (
        lambda: Structure([[1]], None, [[1]]).diameter_frequencies(),
        "no cyclic symmetry, so it",
    ),
    "modes": (lambda: tips(4, 1).diameter_frequencies(2), "modes = 2; give a number from 1 to 1"),
    "base": (
        lambda: tips(4, 1, forcing=sf.BaseMotion(A=1)),
        "a base motion moves all sectors at once",
    ),
    "nothing between": (
        lambda: tips(4, 0, elements=sf.CubicSpring({"tip": 1, "next": -1})),
        "with engine_order = 0 all 4 sectors move alike, so tip - 1 next is always zero",
    ),
    "no degree": (lambda: tips(4, 1, elements=sf.CubicSpring("tp")), "no degree of freedom 'tp'"),
    "boundary": (
        lambda: tips(4, 1, reduction=sf.CraigBampton("tp", 0)),
        "the sector has no degree of free",
    ),
}


@pytest.mark.parametrize(("make", "message"), MISTAKES.values(), ids=MISTAKES)
def test_mistakes(make, message):
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize("sectors", [5, 6])
def test_a_reduction_takes_matrices_of_one_sector(sectors):
    mass, stiffness = sector()
    options = {"forcing": HarmonicForce("c", F=1), "contacts": FrictionContact("d", LAW, 0.1, Vd=0)}
    band = {"up_to": 0.35, "accuracy": 1e-3}
    few = Structure(mass, None, stiffness, names="a b c d e f", **options,
                    cyclic=CyclicSymmetry(sectors, 1, "a b", "e f"),
                    reduction=sf.FreeInterface(**band))  # fmt: skip
    ring = few._assembly.reduced.full
    exact = FullStructure(whole(mass, sectors), whole(stiffness, sectors), ring.acting, ring.acting)
    squares, shapes = ring.modes.first(9)
    np.testing.assert_allclose(exact.stiffness @ shapes, exact.mass @ shapes * squares, atol=1e-12)
    np.testing.assert_allclose(squares, exact.modes.first(9)[0], rtol=1e-11)
    even = np.linspace(0.05, 0.35, 5)
    np.testing.assert_allclose(ring._exact(even), exact._exact(even), rtol=1e-9, atol=1e-9)
    count = 5 + int(np.isclose(squares[4], squares[5]))  # both waves of a pair
    residual, known = (one.residual_shapes(count) for one in (ring, exact))
    work = [part @ np.linalg.lstsq(part, exact.acting, rcond=None)[0] for part in (residual, known)]
    np.testing.assert_allclose(*work, atol=1e-9)
    assert few.reduction_report.receptance_error < 1e-3


def test_large_sectors_need_no_large_matrix():
    # A string of 900 masses on each hub: sparse, with a wave in each of seven nodal diameters.
    count, sectors = 900, 12
    hub, tip = 300.0 * SPRING, 1e3 * (2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1))
    stiffness = np.zeros((count + 1, count + 1))
    stiffness[:-1, :-1] = tip
    stiffness[np.ix_([0, count], [0, count])] += hub
    model = Structure(
        sparse.diags_array(np.append(np.ones(count), 0.0)), None, sparse.csr_array(stiffness),
        names=[*(f"q{at}" for at in range(count)), "next"],
        cyclic=CyclicSymmetry(sectors, 5, "q0", "next"), reduction=sf.ModalReduction(up_to=0.025),
    )  # fmt: skip
    by_wave = model.diameter_frequencies(2)
    twice = np.repeat(by_wave, [1, 2, 2, 2, 2, 2, 1], axis=0).ravel()
    kept = model.natural_frequencies
    np.testing.assert_allclose(kept, np.sort(twice)[: len(kept)], rtol=1e-8)
    assert len(kept) == 12


def test_opposite_sectors_begin_to_stick_at_once():
    """Two roots turn back twice in a period, at once; which of them is first is rounding."""
    model = Structure(
        np.diag([1.0, 0.3, 0.0]), np.diag([0.02, 0.02, 0.0]),
        [[1.6, -0.3, -0.3], [-0.3, 0.8, 0.0], [-0.3, 0.0, 0.3]], names="tip root next",
        contacts=FrictionContact("root", sf.Coulomb(mu_k=0.2), load=1.0, Vd=0.0),
        forcing=HarmonicForce("tip", F=0.4), cyclic=CyclicSymmetry(24, 12, "tip", "next"), f=0.2,
    )  # fmt: skip
    found = []
    for span in ((0.2734, 0.2742), (0.2742, 0.2734)):
        (branch,) = sf.response(model, vary="f", span=span).branches
        (point,) = branch.special
        assert (point.type, branch.stopped.kind) == ("STICK", "span")
        found.append(point)
    one, other = found
    assert one.value == pytest.approx(other.value, abs=one.uncertainty + other.uncertainty)
    assert max(one.uncertainty, other.uncertainty) < 1e-10
