"""Matrices in files: NumPy's .npz and .npy, SciPy's sparse .npz, MATLAB's .mat, Matrix Market."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from slipfold.errors import InputError
from slipfold.models.structures.components.direction import listed

_LONG_NAMES = {"M": "mass", "C": "damping", "K": "stiffness"}


def read_matrix(path: Path, name: str) -> Any:
    """Read one matrix from a file."""
    ending = "".join(path.suffixes[-2:]).lower() if path.suffix == ".gz" else path.suffix.lower()
    if ending not in _READERS:
        raise InputError(
            f"{path} ends in {ending or 'nothing'}, which is not known for matrices; give a file "
            f"that ends in {', '.join(_READERS)}"
        )
    if not path.is_file():
        raise InputError(f"{path} does not exist or is no file; give the path of a matrix {name}")
    try:
        return _READERS[ending](path, name)
    except InputError:
        raise
    except NotImplementedError as error:
        raise InputError(
            f"{path} is a MATLAB file of version 7.3, which cannot be read; save it in MATLAB with "
            "the option -v7"
        ) from error
    # Damaged files make the readers fail in many ways; none of them is worth a traceback.
    except Exception as error:
        why = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
        raise InputError(
            f"{path} cannot be read as a {ending} file ({why}); save the matrix {name} anew"
        ) from error


def _read_npy(path: Path, name: str) -> Any:
    return np.load(path, allow_pickle=False)


def _read_npz(path: Path, name: str) -> Any:
    # NumPy leaves a file that it opened and cannot read open.
    with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
        if "format" in archive.files:
            from scipy.sparse import load_npz

            return load_npz(path)
        return archive[_chosen(archive.files, path, name)]


def _read_mat(path: Path, name: str) -> Any:
    from scipy.io import loadmat

    found: Mapping[str, Any] = loadmat(path)
    return found[_chosen([key for key in found if not key.startswith("__")], path, name)]


def _read_market(path: Path, name: str) -> Any:
    from scipy.io import mmread

    return mmread(path)


def _chosen(names: Iterable[str], path: Path, name: str) -> str:
    """Return which of the variables in a file is the matrix."""
    given = list(names)
    if len(given) == 1:
        return given[0]
    for wanted in (name, name.lower(), _LONG_NAMES.get(name, name)):
        if wanted in given:
            return wanted
    lowered = {item.lower(): item for item in given}
    if _LONG_NAMES.get(name) in lowered:
        return lowered[_LONG_NAMES[name]]
    raise InputError(
        f"{path} holds no {name}, but {listed(given) or 'nothing'}; call the matrix {name} or "
        f"{_LONG_NAMES.get(name, name)} there, or give the array itself"
    )


_READERS: dict[str, Callable[[Path, str], Any]] = {
    ".npz": _read_npz,
    ".npy": _read_npy,
    ".mat": _read_mat,
    ".mtx": _read_market,
    ".mtx.gz": _read_market,
}
