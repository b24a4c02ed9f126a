"""Matrices from files of every kind, and files that cannot be read."""

import sys
from pathlib import Path

import numpy as np
import pytest
from scipy import sparse
from scipy.io import hb_write, mmwrite, savemat

import slipfold as sf
from slipfold import BaseMotion, FrictionContact, InputError, Structure

M = np.diag([1.0, 2.0])
K = np.array([[2.0, -1.0], [-1.0, 1.0]])
C = 0.1 * K
EXPECTED = Structure(M, C, K)


def test_matlab(tmp_path):
    path = tmp_path / "all.mat"
    savemat(path, {"Mass": sparse.csc_array(M), "C": C, "K": sparse.csc_array(K)})
    assert Structure(path, path, path) == EXPECTED


HALVES = {
    "array": lambda a, path: a,
    "sparse": lambda a, path: sparse.coo_array(a),
    "npy": lambda a, path: np.save(path / "a.npy", a),
    "npz": lambda a, path: np.savez(path / "a.npz", K=a),
    "sparse npz": lambda a, path: sparse.save_npz(path / "a.npz", sparse.csc_array(a)),
    "mat": lambda a, path: savemat(path / "a.mat", {"K": sparse.csc_array(a)}),
    "mtx": lambda a, path: mmwrite(path / "a.mtx", sparse.coo_array(a), symmetry="general"),
}
"""What finite-element programs write: one triangle of a symmetric matrix."""


ORDERS = {"lower": [0, 1, 2], "upper": [2, 1, 0], "mixed": [1, 2, 0]}


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("kind", HALVES)
def test_triangles_are_completed_or_refused(tmp_path, kind, order):
    # Three masses in a row, fixed at one end: eigenvalues of the chain (Rayleigh), 4 sin^2(pi/14).
    full = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    order, side = ORDERS[order], order
    half = np.tril(full)[np.ix_(order, order)]
    given = HALVES[kind](half, tmp_path)
    filed = given is None
    given = next(tmp_path.iterdir()) if filed else given
    expected = Structure(np.eye(3), None, full[np.ix_(order, order)])
    assert expected.notes == ()
    if filed and side != "mixed":  # as programs write it
        model = Structure(np.eye(3), None, given)
        assert model == expected
        assert model.notes == (f"K was given by its {side} triangle and is completed",)
        assert model.replace(duration=2).notes == model.notes
    refused = [(half, "C")] if filed and side != "mixed" else [(half, "C"), (given, "K")]
    for triangle, name in refused:
        matrices = {"M": np.eye(3), "K": full, name: triangle}
        with pytest.raises(InputError, match=rf"^{name} has one entry of each mirrored pair only"):
            Structure(**matrices)
    model = Structure(np.eye(3), None, given, triangles="symmetric")
    assert model == expected
    lowest = 2 * np.sin(np.pi / 14) / (2 * np.pi)
    np.testing.assert_allclose(model.natural_frequencies[0], lowest, rtol=1e-12)
    whole = Structure(np.eye(3), half, given, triangles="whole")
    np.testing.assert_array_equal(whole.stiffness_matrix, half)
    assert Structure.from_tables(whole.to_tables()) == whole
    assert whole.replace(K=given, triangles="symmetric") == model.replace(C=whole.structure["C"])


def test_a_triangle_in_a_structure_file(tmp_path):
    np.save(tmp_path / "K.npy", np.tril(K))
    text = '[structure]\nM = [[1, 0], [0.1, 2]]\nK = "K.npy"\n'
    path = tmp_path / "frame.toml"
    path.write_text(text)
    with pytest.raises(InputError, match="line 2, column 5: M has one entry of each mirrored pair"):
        Structure.from_toml(path)
    path.write_text(text.replace("0.1", "0"))
    assert Structure.from_toml(path).notes == (
        "K was given by its lower triangle and is completed",
    )
    path.write_text(f'{text}triangles = "symmetric"\n')
    mass = np.array([[1, 0.1], [0.1, 2]])
    assert Structure.from_toml(path) == Structure(mass, None, K, name="frame", title="")
    path.write_text(f'{text}triangles = "half"\n')
    with pytest.raises(InputError, match="line 4, column 13: triangles = 'half' is not known"):
        Structure.from_toml(path)


BOEING = """\
A chain of three masses, as ANSYS writes it                            CHAIN
             4             1             1             2             0
RSA                        3             3             5             0
(8I3)           (8I3)           (1P,4D12.5)         (1P,4D12.5)
  1  3  5  6
  1  2  2  3  3
 2.00000D+00-1.00000D+00 2.00000D+00-1.00000D+00
 1.00000D+00
"""
CHAIN = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
ABAQUS = "** stiffness\n1, 1, 2.0\n2, 1, -1.0\n2, 2, 2.0\n3, 2, -1.0\n3, 3, 1.0\n"


def test_what_finite_element_programs_write(tmp_path):
    expected = Structure(np.eye(3), None, CHAIN)
    (tmp_path / "K.hb").write_text(BOEING)
    assert Structure(np.eye(3), None, tmp_path / "K.hb") == expected
    hb_write(tmp_path / "K.rb", sparse.csc_matrix(CHAIN))
    assert Structure(np.eye(3), None, tmp_path / "K.rb") == expected
    (tmp_path / "K.mtx").write_text(ABAQUS)
    model = Structure(np.eye(3), None, tmp_path / "K.mtx")
    assert model == expected
    assert model.notes == ("K was given by its lower triangle and is completed",)


def test_nastran_files(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyyeti.nastran", None)
    for path in (tmp_path / "all.op2", tmp_path / "all.op4"):
        path.write_text("")
        with pytest.raises(InputError, match=r"install slipfold\[nastran\], or save the matrix as"):
            Structure(path, None, path)
    monkeypatch.undo()
    op4 = pytest.importorskip("pyyeti.nastran.op4")
    op4.write(str(path), {"MAA": np.eye(3), "KAA": sparse.csc_matrix(CHAIN)}, binary=False)
    assert Structure(path, None, path) == Structure(np.eye(3), None, CHAIN)
    # A file of Nastran itself: the stiffness KHH in modes of unit mass, which assemble.out lists.
    given = Path(op4.__file__).parents[1] / "tests" / "nas2cam_extseout" / "assemble.op2"
    model = Structure(np.eye(54), None, given)
    listed = [1.698800, 1.767487, 1.857720, 3.419612, 7.024210]
    np.testing.assert_allclose(model.natural_frequencies[6:11], listed, rtol=1e-6)


def test_names_in_a_table(tmp_path):
    table = tmp_path / "nodes.csv"
    table.write_text("\ufeffnode, direction, name\n17, uz,\npad, uz,\n3, ry, tilt\n")
    model = Structure(np.eye(3), None, CHAIN, names=table)
    assert [state.name for state in model.states[:3]] == ["uz17", "uz_pad", "tilt"]
    text = "[structure]\nM = { diagonal = [1, 1, 1] }\nK = { diagonal = [1, 1, 1] }\nnames = "
    (tmp_path / "frame.toml").write_text(f'{text}"nodes.csv"\n')
    assert Structure.from_toml(tmp_path / "frame.toml").structure["names"][1] == "uz_pad"
    # A contact at node and direction; a base that moves all nodes along one direction.
    parts = {"contacts": FrictionContact("pad:uz"), "forcing": BaseMotion("*:uz", A=1.0)}
    model = model.replace(**parts, watch={"u": {"17:uz": 2.0}})
    assert model.structure["contacts"][0].along[0].weights == (("uz_pad", 1.0),)
    power = model.evaluate("power_forcing", [0, 0, 0, 1, 2, 5])
    assert power == pytest.approx((2 * np.pi) ** 2 * (1 + 2), rel=1e-12)
    for at, words in {
        "18:uz": "freedom 'uz18'; did you mean uz17",
        "*:ux": r"freedom '\*:ux'",
    }.items():
        with pytest.raises(InputError, match=words):
            model.replace(forcing=BaseMotion(at))
    for content, words in {
        "knot,direction\n": "has the columns knot, direction; its first row must hold node and",
        "node,direction\n1,uz\n,ux\n": "neither a name nor a node with a direction in line 3",
        "node,direction\n1,uz\n1,uz\n2,uz\n": "two degrees of freedom are called uz1",
    }.items():
        table.write_text(content)
        with pytest.raises(InputError, match=words):
            Structure(np.eye(3), None, CHAIN, names=table)
    with pytest.raises(InputError, match="does not exist or is not a file; give the path of a tab"):
        Structure(np.eye(3), None, CHAIN, names=tmp_path / "no.csv")


def files(path):
    np.savez(path / "other.npz", stiff=K, mess=M)
    np.savez(path / "objects.npz", K=np.array([{}], dtype=object))
    (path / "broken.npz").write_bytes(b"no archive")
    (path / "broken.mtx").write_text("%%MatrixMarket matrix coordinate real general\n2 2 x\n")
    (path / "table.mtx").write_text("1 2\n")
    (path / "headless.mtx").write_text("%MatrixMarket matrix\n2 2 2\n1 1 5\n2 1 3\n")
    (path / "broken.hb").write_text(BOEING.replace("RSA", "CSA"))
    (path / "broken.mat").write_bytes(b"\0" * 200)
    (path / "new.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM" + b"\0" * 400)
    (path / "matrix.txt").write_text("1 2 3")
    (path / "folder.npz").mkdir()


@pytest.mark.parametrize(("name", "part"), [
    ("missing.npz", "does not exist or is not a file"),
    ("folder.npz", "does not exist or is not a file"),
    ("matrix.txt", "ends in .txt, which is not known for matrices; give a file that ends in .npz"),
    ("nothing", "ends in nothing"),
    ("other.npz", "holds no K, but stiff, mess; call the matrix K or stiffness there"),
    ("objects.npz", "cannot be read as a .npz file"),
    ("broken.npz", "cannot be read as a .npz file"),
    ("broken.mtx", "cannot be read as a .mtx file"),
    ("table.mtx", "it has no Matrix Market header and 2 numbers a row"),
    ("headless.mtx", "its first row may be the size of a Matrix Market file"),
    ("broken.hb", "its type is CSA; real assembled matrices (RSA, RUA) are read"),
    ("broken.mat", "cannot be read as a .mat file"),
    ("new.mat", "MATLAB file of version 7.3"),
])  # fmt: skip
def test_files_that_cannot_be_read(tmp_path, name, part):
    files(tmp_path)
    with pytest.raises(InputError) as caught:
        Structure(M, None, tmp_path / name)
    message = str(caught.value)
    assert part in message
    assert name in message
    assert "\n" not in message


@pytest.mark.parametrize(("units", "length", "mass"), [
    ("mm-t-s", 1e-3, 1e3), ("mm-kg-s", 1e-3, 1.0), ("in-lbf-s", 0.0254, 175.12683524647636),
])  # fmt: skip
def test_matrices_in_other_units(units, length, mass):
    # A mass of 3 kg on a spring and a lever of 2 kg m^2 on one, coupled: 40 N/m, 7 N m, 2 N.
    inertia, stiffness = np.diag([3.0, 2.0]), np.array([[40.0, 2.0], [2.0, 7.0]])
    energy, scale = mass * length**2, np.diag([length, 1.0])
    given = [scale @ one @ scale / energy for one in (inertia, 0.1 * stiffness, stiffness)]
    model = sf.Structure(given[0], given[1], {1: given[2], "s": given[2]}, names="ux7 rz7",
                         units=units, s=0)  # fmt: skip
    np.testing.assert_allclose(model.mass_matrix, inertia, rtol=1e-14)
    np.testing.assert_allclose(model.stiffness_matrix, stiffness, rtol=1e-14)
    np.testing.assert_allclose(model.replace(s=2).stiffness_matrix, 3 * stiffness, rtol=1e-14)
    np.testing.assert_allclose(model.damping_matrix, 0.1 * stiffness, rtol=1e-14)
    assert model.notes[0] == (
        f"matrices were given in {units} and are converted to SI units; rotations are rz7"
    )
    again = sf.Structure.from_tables(model.to_tables())
    np.testing.assert_allclose(again.stiffness_matrix, stiffness, rtol=1e-14)
    other = model.replace(elements=sf.CubicSpring("ux7", k3=1))
    np.testing.assert_allclose(other.stiffness_matrix, stiffness, rtol=1e-14)
    with pytest.raises(InputError, match="units = 'mm' is not known; give SI, mm-t-s, mm-kg-s, in"):
        sf.Structure([[1]], None, [[1]], units="mm")
