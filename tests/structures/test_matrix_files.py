"""Matrices from files of every kind, and files that cannot be read."""

import numpy as np
import pytest
from scipy import sparse
from scipy.io import mmwrite, savemat

from slipfold.errors import InputError
from slipfold.models.structures import Structure

M = np.diag([1.0, 2.0])
K = np.array([[2.0, -1.0], [-1.0, 1.0]])
C = 0.1 * K
EXPECTED = Structure(M, C, K)


def test_archive_of_arrays(tmp_path):
    path = tmp_path / "all.npz"
    np.savez(path, M=M, damping=C, k=K)
    assert Structure(path, path, str(path)) == EXPECTED


def test_matlab(tmp_path):
    path = tmp_path / "all.mat"
    savemat(path, {"Mass": sparse.csc_array(M), "C": C, "K": sparse.csc_array(K)})
    assert Structure(path, path, path) == EXPECTED


def test_one_matrix_a_file(tmp_path):
    np.save(tmp_path / "m.npy", M)
    sparse.save_npz(tmp_path / "c.npz", sparse.csr_array(C))
    mmwrite(tmp_path / "k.mtx", sparse.coo_array(K), symmetry="symmetric")
    assert Structure(*(tmp_path / name for name in ("m.npy", "c.npz", "k.mtx"))) == EXPECTED
    mmwrite(tmp_path / "dense.mtx", K)
    assert Structure(M, C, tmp_path / "dense.mtx") == EXPECTED


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
    ("missing.npz", "does not exist or is no file"),
    ("folder.npz", "does not exist or is no file"),
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
