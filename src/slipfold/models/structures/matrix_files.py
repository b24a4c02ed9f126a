"""Matrices and names of degrees of freedom in files, as finite-element programs write them."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Collection
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from slipfold.errors import InputError
from slipfold.text import listed
from slipfold.writing import to_read


def read_matrix(path: Path, name: str) -> Any:
    """Read one matrix from a file."""
    ending = "".join(path.suffixes[-2:]).lower() if path.suffix == ".gz" else path.suffix.lower()
    if ending not in READERS:
        raise InputError(
            f"{path} ends in {ending or 'nothing'}, which is not known for matrices; give a file "
            f"that ends in {', '.join(READERS)}"
        )
    _require_file(path, f"a matrix {name}")
    try:
        content = READERS[ending](path)
        return content[_chosen(content, path, name)] if isinstance(content, dict) else content
    except InputError:
        raise
    except NotImplementedError as error:
        raise InputError(
            f"{path} is a MATLAB file of version 7.3, which cannot be read; save it in MATLAB with "
            "the option -v7"
        ) from error
    # Damaged files make the readers fail in many ways; a message says more than a traceback.
    except Exception as error:
        why = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
        raise InputError(
            f"{path} cannot be read as a {ending} file ({why}); save the matrix {name} again"
        ) from error


def _require_file(path: Path, what: str) -> None:
    if not to_read(path).is_file():
        raise InputError(f"{path} does not exist or is not a file; give the path of {what}")


def _read_npz(path: Path) -> Any:
    # NumPy leaves a file that it opened and cannot read open.
    with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
        if "format" in archive.files:
            from scipy.sparse import load_npz

            return load_npz(path)
        return dict(archive)


def _read_mat(path: Path) -> Any:
    from scipy.io import loadmat

    return {name: value for name, value in loadmat(path).items() if not name.startswith("__")}


def _read_market(path: Path) -> Any:
    """Read a Matrix Market file, or the rows ``row, column, value`` of Abaqus."""
    from scipy.io import mmread

    if path.suffix == ".gz":
        return mmread(path)
    with path.open("rb") as file:
        if file.read(2) == b"%%":
            return mmread(path)
    from scipy.sparse import coo_array

    text = path.read_text().replace(",", " ")
    table = np.loadtxt(text.splitlines(), comments=("*", "#", "%"), ndmin=2)
    if table.shape[1] != 3:
        raise ValueError(f"it has no Matrix Market header and {table.shape[1]} numbers a row")
    if (table[0] == [*table[:, :2].max(axis=0), len(table) - 1]).all():
        raise ValueError(
            "its first row may be the size of a Matrix Market file whose header is missing, or the "
            "last entry of a matrix; begin the file with %%MatrixMarket matrix coordinate real "
            "general, or symmetric, or let another entry be first"
        )
    rows, columns = (table[:, place].astype(np.int64) - 1 for place in (0, 1))
    return coo_array((table[:, 2], (rows, columns)), (max(rows.max(), columns.max()) + 1,) * 2)


_FORTRAN = re.compile(r"\((?:\d+P,?)?(\d*)[IEDFG](\d+)(?:\.\d+(?:E\d+)?)?\)")
"""A format of numbers: how many stand on a line, and in how many columns each."""


def _fixed(lines: list[str], form: str, count: int) -> list[str]:
    """Return the numbers of lines in a Fortran format, without blanks between them perhaps."""
    words = " ".join(lines).split()
    if len(words) == count:
        return words
    match = _FORTRAN.fullmatch(form.upper().replace(" ", ""))
    if match is None:
        raise ValueError(f"its format {form.strip()} is not known")
    each, width = int(match[1] or 1), int(match[2])
    places = [slice(width * place, width * (place + 1)) for place in range(each)]
    return [line[place] for line in lines for place in places][:count]


def _read_boeing(path: Path) -> Any:
    """Read a Harwell-Boeing file; SciPy refuses the symmetric ones that programs write."""
    from scipy.sparse import coo_array, csc_array

    with path.open() as file:
        _, counts, kind, forms = islice(file, 4)
        _, *sizes, right = (int(counts[at : at + 14].strip() or 0) for at in _CARDS)
        rows, columns, entries = (int(kind[at : at + 14]) for at in _CARDS[1:4])
        if kind[0] not in "Rr" or kind[1] not in "SsUuZz" or kind[2] not in "Aa":
            raise ValueError(f"its type is {kind[:3]}; real assembled matrices (RSA, RUA) are read")
        if right > 0:
            next(file)
        starts, places, values = (list(islice(file, size)) for size in sizes)
    starts = _fixed(starts, forms[:16], columns + 1)
    places = _fixed(places, forms[16:32], entries)
    values = _fixed(values, forms[32:52], entries)
    numbers = [float(value.upper().replace("D", "E")) for value in values]
    indices = (np.array(part, dtype=np.int64) - 1 for part in (places, starts))
    half = coo_array(csc_array((np.array(numbers), *indices), (rows, columns)))
    if kind[1] in "Uu":
        return half
    off = half.row != half.col
    mirror = (half.data[off], (half.col[off], half.row[off]))
    return half + (1 if kind[1] in "Ss" else -1) * coo_array(mirror, half.shape)


_CARDS = tuple(range(0, 70, 14))
"""Columns at which the numbers of a header of Harwell-Boeing begin."""


def _read_nastran(path: Path) -> Any:
    """Read the matrices of a Nastran OUTPUT2 or OUTPUT4 file."""
    try:
        from pyyeti.nastran import op2, op4
    except ImportError:
        raise InputError(
            f"{path} is read by the package pyyeti, which is not installed; install "
            "slipfold[nastran], or save the matrix as a Matrix Market file"
        ) from None
    two = path.suffix.lower() == ".op2"
    return op2.rdmats(str(path)) if two else op4.read(str(path), sparse=None)


READERS: dict[str, Callable[[Path], Any]] = {
    ".npz": _read_npz,
    ".npy": partial(np.load, allow_pickle=False),
    ".mat": _read_mat,
    ".mtx": _read_market,
    ".mtx.gz": _read_market,
    ".hb": _read_boeing,
    ".rb": _read_boeing,
    ".rsa": _read_boeing,
    ".rua": _read_boeing,
    ".op2": _read_nastran,
    ".op4": _read_nastran,
}

_OTHER_NAMES = {
    "M": ("mass", "maa", "mgg", "mhh"),
    "C": ("damping", "baa", "bgg", "bhh"),
    "K": ("stiffness", "kaa", "kgg", "khh"),
    "G": ("gyroscopic",),
    "H": ("circulatory",),
}
"""What programs call the matrices: by their full names, and as Nastran does."""


def _chosen(names: Collection[str], path: Path, name: str) -> str:
    """Return the name of the matrix among the variables of a file."""
    if len(names) == 1:
        return next(iter(names))
    others = _OTHER_NAMES.get(name, ())
    lowered = {item.lower(): item for item in names}
    for wanted in (name, name.lower(), *(lowered.get(other, "") for other in others)):
        if wanted in names:
            return wanted
    called = " or ".join([name, *others[:1]])
    raise InputError(
        f"{path} holds no {name}, but {listed(names) or 'nothing'}; call the matrix {called} "
        "there, or give the array itself"
    )


def node_name(node: str, direction: str) -> str:
    """Return the name of a degree of freedom: ``uz17``, or ``uz_pad`` if the node has a name.

    >>> node_name("17", "uz"), node_name("pad", "uz")
    ('uz17', 'uz_pad')
    """
    return f"{direction}{node}" if node.isdecimal() else f"{direction}_{node}"


_COLUMNS = ("node", "direction", "name")


def csv_table(path: Path, what: str) -> tuple[list[str], list[dict[str, str]]]:
    """Return the columns of a CSV file and its rows, cells without blanks around them."""
    _require_file(path, what)
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            given = csv.DictReader(file, skipinitialspace=True)
            columns = [str(item).strip().lower() for item in given.fieldnames or ()]
            given.fieldnames = columns
            return columns, [{key: (row[key] or "").strip() for key in columns} for row in given]
    except (csv.Error, UnicodeDecodeError) as error:
        raise InputError(
            f"{path} is no table of comma-separated values ({error}); save it as CSV in UTF-8"
        ) from None


def read_names(path: Path) -> tuple[str, ...]:
    """Read names of degrees of freedom, one a row: of node and direction, or a name."""
    columns, rows = csv_table(path, "a table with the columns node and direction, or name")
    if not ({"node", "direction"} <= set(columns) or "name" in columns):
        raise InputError(
            f"{path} has the columns {listed(columns, 'nothing')}; its first row must hold node "
            "and direction, or name"
        )
    return tuple(_named(row, path, line) for line, row in enumerate(rows, 2))


def _named(row: dict[str, str], path: Path, line: int) -> str:
    node, direction, name = (row.get(key, "") for key in _COLUMNS)
    if name or (node and direction):
        return name or node_name(node, direction)
    raise InputError(
        f"{path} has neither a name nor a node with a direction in line {line}; give one"
    )
