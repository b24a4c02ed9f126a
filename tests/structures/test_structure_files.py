"""Structures in TOML files: the same as from Python, and what is wrong with them is pointed at."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy import io, sparse

import slipfold as sf
from helpers.frame import TEXT
from slipfold import InputError


def in_python():
    return sf.Structure(
        np.diag([1.0, 2.0]),
        sf.ModalDamping(0.01),
        [[200, -100], [-100, 100]],
        names=["root", "tip"],
        length_scale=0.01,
        reduction=sf.CraigBampton("tip", modes=1),
        elements=[
            sf.CubicSpring("tip", k3=1e4),
            sf.GeometricSpring("root", (0, 1), k=2000, L=5e-3, name="tie"),
        ],
        contacts=sf.FrictionContact(
            "tip", sf.Stribeck(mu_s=0.4, vs=0.2), sf.ModulatedLoad(Ns=2, Nd=0.5), Vd=0.5
        ),
        forcing=sf.MultiHarmonicForce(
            {"tip": 1, "root": -1}, {0: 0.1, 1: 0.5, 3: (0.1, np.pi / 2)}, name="shaker"
        ),
        watch={"u": {"root": 1}},
        name="frame",
        title="",
        f=1.5,
    )


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "frame.toml"
    path.write_text(TEXT)
    return path


def test_a_file_is_the_structure_it_says(file):
    assert sf.Structure.from_toml(file) == in_python()
    assert sf.Structure.from_toml(TEXT) == in_python()
    # The name is that of the file if none is given.
    file.write_text(TEXT.replace('name = "frame"\n', "", 1))
    assert sf.Structure.from_toml(str(file)).name == "frame"


def every_part():
    m = np.array([[2.0, 0.3, 0.0], [0.3, 1.0, 0.1], [0.0, 0.1, 0.5]])
    return sf.Structure(
        m,
        [[1, 0, 0], [0, 2, 0], [0.5, 0, 1]],
        100 * np.eye(3),
        triangles="whole",
        elements=[
            sf.LinearSpring("q1", k="2 kN/m", c=0.1),
            sf.PolynomialSpring({"q1": 0.6, "q2": 0.8}, {1: -3.0, 5: 7.0}, name="poly"),
            sf.GapSpring("q3", k=10, gap="1mm", e=1e-4, side="both", name="stop"),
            sf.GeometricSpring(("q1", "q2"), (1, 2), k=5, L=0.2, stretch=1.1, name="tie"),
            sf.TabulatedSpring("q2", [(-0.1, -2), (0, 0), (0.25, 1)], 2, e=1e-3, name="table"),
        ],
        contacts=[
            sf.FrictionContact(
                ("q1", "q2"),
                sf.Regularized(sf.RationalStribeck(mu_s=0.4, d=2), shape="atan", e=0.01),
                sf.ContactLoad("q3", Ns=5, kn=7, cn=0.1),
                Vd=2,
                alpha="30deg",
                name="pad",
            ),
            sf.FrictionContact("q3", sf.LuGre(s0=1e3), sf.ConstantLoad(3, normal="q2"), name="b"),
            sf.FrictionContact("q2", sf.BoucWen(exponent=4), "2 N", name="d"),
            sf.FrictionContact(
                "q2", sf.Dahl(), sf.ComplianceLoad("q1", 2, 0.1, 1e-3, 1.5), name="e", group="all"
            ),
        ],
        forcing=[
            sf.HarmonicForce("q1", F=2, phi=0.3, harmonic=2),
            sf.TabulatedForce("q2", [1, 2, 4, 1, 0], factor=2, harmonics=1),
            sf.BaseMotion({"q1": 1, "q3": 1}, A="1mm", harmonic=3, name="base"),
            sf.BaseAcceleration(a=9.81, phi=0.2, name="shaker"),
        ],
        watch={"relative": {"q1": 1, "q2": -1}},
        title="every part there is",
        f=0.8,
        level=0.5,
    )


@pytest.mark.parametrize(
    "model",
    [
        in_python(),
        every_part(),
        sf.Structure([[1.0]], sf.ProportionalDamping(0.1, 0.2), [[2.0]]),
        sf.Structure(
            sparse.eye_array(700),
            sf.ModalDamping((0.1, 0.2)),
            sparse.diags_array(np.linspace(1, 2, 700)) / 3,
            reduction=sf.ModalReduction(up_to=0.092),
        ).replace(duration=3),
        sf.Structure(
            np.diag([1.0, 0.0]),
            sf.ModalDamping(0.1),
            [[1.3, -0.3], [-0.3, 0.3]],
            names="tip neighbor",
            cyclic=sf.CyclicSymmetry(8, 2, "tip", "neighbor"),
            forcing=sf.HarmonicForce("tip", F=2.0),
        ),
    ],
    ids=["frame", "every part", "one mass", "sparse", "sectors"],
)
def test_tables_make_the_same_structure_again(model):
    tables = json.loads(json.dumps(model.to_tables()))
    again = sf.Structure.from_tables(tables)
    assert again == model
    assert sf.Structure.from_toml(model.to_toml()) == model
    assert again.name == model.name
    assert again.title == model.title
    for ours, theirs in zip(
        (again.mass_matrix, again.stiffness_matrix, again.damping_matrix, again.basis),
        (model.mass_matrix, model.stiffness_matrix, model.damping_matrix, model.basis),
        strict=True,
    ):
        assert np.array_equal(ours, theirs)


@pytest.mark.parametrize("kind", ["npy", "npz", "sparse npz", "mat", "mtx"])
def test_matrices_lie_beside_the_file(kind, file):
    K = np.array([[200.0, -100.0], [-100.0, 100.0]])
    (file.parent / "data").mkdir()
    name = f"data/matrices.{kind.split()[-1]}"
    path = file.parent / name
    {
        "npy": lambda: np.save(path, K),
        "npz": lambda: np.savez(path, K=K, other=np.eye(3)),
        "sparse npz": lambda: sparse.save_npz(path, sparse.csr_array(K)),
        "mat": lambda: io.savemat(path, {"K": K, "other": np.eye(3)}),
        "mtx": lambda: io.mmwrite(path, sparse.coo_array(K)),
    }[kind]()
    file.write_text(TEXT.replace("[[200, -100], [-100, 100]]", f'"{name}"'))
    assert sf.Structure.from_toml(file) == in_python()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        # Matrices.
        ("[structure]", "[structur]", "line 2, column 1: a structure has no entry 'structur'; did"),
        ("M = { diagonal = [1, 2] }", "", "line 2, column 1: structure has no M; give it"),
        ("[1, 2]", "[1, -1]", "line 3, column 5: M is not positive definite: the mass of tip "),
        ("[1, 2]", '[1, "a"]', "line 3, column 22: structure.M.diagonal[1] is a text"),
        ("diagonal", "diag", "line 3, column 7: structure.M has no entry 'diag'; did you"),
        ("{ diagonal = [1, 2] }", "{}", "column 5: structure.M has no diagonal; give"),
        ("{ diagonal = [1, 2] }", '"M.npz"', "M.npz does not exist or is not a file"),
        ("{ diagonal = [1, 2] }", "true", "column 5: structure.M is true or false, not a matrix"),
        ("[[200, -100], [-100, 100]]", "[[200, -100], [-100]]", "column 19: structure.K has 1 num"),
        ("[[200, -100], [-100, 100]]", "[200, -100]", "column 6: structure.K[0] is a number"),
        ("-100, 100]]", "-90, 100]]", "line 4, column 5: K is not symmetric: row 1, column 2 is"),
        ("[[200, -100]", "[[200, inf]", "column 5: K has the entry inf in row 1, column 2"),
        ('"root tip"', '"root"', "line 5, column 9: 1 names are given for 2"),
        ('"root tip"', "5", "1 names are given for 2 degrees of freedom"),
        ('"10mm"', '"10 kg"', "line 6, column 16: length_scale = '10 kg' has the unit 'kg'"),
        # Damping and reduction.
        ('"ModalDamping"', '"Modal"', "line 8, column 8: damping.type = 'Modal' is unknown; did"),
        ("ratios = 0.01", "ratio = 1", "line 9, column 1: damping has no entry 'ratio'; did you"),
        ('type = "ModalDamping"\n', "C = 1\n", "line 7, column 1: damping has no type"),
        ("[damping]", "C = [[1, 0], [0, 1]]\n[damping]", "both a matrix C and a table [damping]"),
        ('["tip"]', '["tpi"]', "line 12, column 12: the boundary has 'tpi', which is no degree of"),
        ("modes = 1", "modes = true", "line 13, column 9: modes = True; give a whole"),
        # Elements, contacts and forcing.
        ('"CubicSpring"', '"Cubic"', "line 15, column 8: elements[0].type = 'Cubic' is un"),
        ('type = "CubicSpring"\n', "", "line 14, column 1: elements[0] has no type; give one of"),
        ('at = "tip"\nk3', 'at = "tpi"\nk3', "line 16, column 6: the structure has no degree of"),
        ('at = "tip"\nk3', "k3", "line 14, column 1: elements[0] has no at; give it"),
        ("k3 = 1e4", 'k3 = "2*a"', "line 17, column 6: k3 = '2*a' is no calculation of numbers"),
        ("k3 = 1e4", "K3 = 1", "line 17, column 1: elements[0] has no entry 'K3'; did you mean k3"),
        ("[0, 1]", "[0, 0]", "line 22, column 8: the axis of a geometric spring is zero"),
        ("mu_s = 0.4", "mu_s = 0.1", "line 27, column 39: mu_s = 0.1 is below mu_k = 0.3"),
        ("Nd = 0.5", "Nd = 5", "line 28, column 47: Nd = 5 N is not below Ns = 2 N"),
        ("Vd = 0.5", "alpha = 0.5", "line 29, column 9: alpha = 0.5 has no meaning"),
        ("[[forcing]]", "[forcing]", "line 30, column 1: forcing is a table; give an array of tab"),
        # The rest.
        ("u = { root", "u = { roo", "line 36, column 5: the structure has no degree of freedom"),
        ("u = { root = 1 }", 'tip = "root"', "two outputs are called tip"),
        ("u = { root = 1 }", "u = 3", "line 36, column 5: a displacement u acts at 3"),
        ('f = "1.5 Hz"', "f = -1", "line 38, column 5: f = -1 is outside its bounds"),
        ('f = "1.5 Hz"', "F = 1", "line 38, column 5: frame has no parameter 'F'; did you"),
        ('f = "1.5 Hz"', "Nd = 3", "line 37, column 1: Nd = 3 N is not below Ns = 2 N"),
        ('f = "1.5 Hz"', "f = 1979-05-27", "line 38, column 5: f = datetime.date(1979, 5, 27) is"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_pointed_at(old, new, words, file):
    assert old in TEXT
    file.write_text(TEXT.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        sf.Structure.from_toml(file)
    sentence, *excerpt = str(caught.value).split("\n")
    assert sentence.startswith(str(file))
    assert words in sentence
    assert len(excerpt) in (0, 2)


@pytest.mark.parametrize(
    "name", ["../M.npz", "/M.npz", "a/../../M.npz", "C:/M.npz", "\\\\\\\\host\\\\M.npz"]
)
def test_matrices_are_read_from_below_the_folder_only(name, file):
    np.savez(file.parent / "M.npz", M=np.eye(2))
    np.savez(file.parent.parent / "M.npz", M=np.eye(2))
    file.write_text(TEXT.replace("{ diagonal = [1, 2] }", f'"{name}"'))
    with pytest.raises(InputError, match="leads out of the folder of this file; put the file"):
        sf.Structure.from_toml(file)


def test_samples_of_a_force_lie_beside_the_file_too(file):
    table = np.array([0.0, 1.0, 0.5, -2.0])
    np.save(file.parent / "force.npy", table[:, None])
    np.save(file.parent / "plane.npy", np.eye(3))
    more = '[[forcing]]\ntype = "TabulatedForce"\nat = "tip"\nsamples = SAMPLES\n[watch]\n'
    text = TEXT.replace("[watch]\n", more)
    file.write_text(text.replace("SAMPLES", '"force.npy"'))
    assert sf.Structure.from_toml(file).structure["forcing"][1].samples == tuple(table)
    spring = (
        '[[elements]]\ntype = "TabulatedSpring"\nat = "tip"\ne = 1e-3\ntable = "F.npy"\n[watch]\n'
    )
    np.save(file.parent / "F.npy", [[0.0, 0.0], [1.0, 2.0]])
    file.write_text(TEXT.replace("[watch]\n", spring))
    assert sf.Structure.from_toml(file).structure["elements"][2].table == ((0, 0), (1, 2))
    for name, words in {
        "plane.npy": "plane.npy' holds no row of numbers",
        "../force.npy": "leads out of the folder",
    }.items():
        file.write_text(text.replace("SAMPLES", f'"{name}"'))
        with pytest.raises(InputError, match=f"line 38, column 11: .*{words}"):
            sf.Structure.from_toml(file)


def test_a_damaged_matrix_file_is_named(file):
    Path(file.parent, "M.npz").write_bytes(b"PK\x03\x04 no archive")
    file.write_text(TEXT.replace("{ diagonal = [1, 2] }", '"M.npz"'))
    with pytest.raises(InputError, match=r"line 3, column 5: .*M.npz cannot be read as a .npz"):
        sf.Structure.from_toml(file)


@pytest.mark.parametrize("name", ["M", "name"])
def test_no_parameter_is_called_as_an_argument(name):
    with pytest.raises(InputError, match=f"no parameter of a structure is called {name}"):
        sf.Structure.from_tables({**in_python().to_tables(), "parameters": {name: 1.0}})
