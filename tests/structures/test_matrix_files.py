"""Matrices from files of every kind, and files that cannot be read."""

import numpy as np
import pytest
from scipy import sparse
from scipy.io import mmwrite, savemat

from slipfold import InputError, Structure

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


@pytest.mark.parametrize(
    "order", [[0, 1, 2], [2, 1, 0], [1, 2, 0]], ids=["lower", "upper", "mixed"]
)
@pytest.mark.parametrize("write", HALVES.values(), ids=HALVES)
def test_triangles_are_completed_or_refused(tmp_path, write, order):
    # Three masses in a row, fixed at one end: eigenvalues of the chain (Rayleigh), 4 sin^2(pi/14).
    full = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    half = np.tril(full)[np.ix_(order, order)]
    given = write(half, tmp_path)
    given = next(tmp_path.iterdir()) if given is None else given
    for triangle, name in ((given, "K"), (half, "C")):
        matrices = {"M": np.eye(3), "K": full, name: triangle}
        with pytest.raises(InputError, match=rf"^{name} has one entry of each mirrored pair only"):
            Structure(**matrices)
    model = Structure(np.eye(3), None, given, triangles="symmetric")
    assert model == Structure(np.eye(3), None, full[np.ix_(order, order)])
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
    path.write_text(f'{text}triangles = "symmetric"\n')
    mass = np.array([[1, 0.1], [0.1, 2]])
    assert Structure.from_toml(path) == Structure(mass, None, K, name="frame", title="")
    path.write_text(f'{text}triangles = "half"\n')
    with pytest.raises(InputError, match="line 4, column 13: triangles = 'half' is not known"):
        Structure.from_toml(path)


def files(path):
    np.savez(path / "other.npz", stiff=K, mess=M)
    np.savez(path / "objects.npz", K=np.array([{}], dtype=object))
    (path / "broken.npz").write_bytes(b"no archive")
    (path / "broken.mtx").write_text("%%MatrixMarket matrix coordinate real general\n2 2 x\n")
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
