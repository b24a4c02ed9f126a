"""Studies that take little time."""

import resource
from contextlib import contextmanager
from pathlib import Path

CHEAP = {
    "model": "sliding",
    "parameters": {"f": 12.5, "Nd": 0.02},
    "compute": {"what": "simulation", "periods": 4},
    "cases": {
        "grid": {"Vd": {"from": 0.5, "to": 0.8, "count": 20}, "mu": [0.3, 0.4, 0.5, 0.6, 0.7]}
    },
}
"""A hundred motions of four periods."""

CHEAP_FILE = """
model = "sliding"
parameters = {f = 12.5, Nd = 0.02}
compute = {what = "simulation", periods = 4}
[cases.grid]
Vd = {from = 0.5, to = 0.8, count = 20}
mu = [0.3, 0.4, 0.5, 0.6, 0.7]
"""
"""The same as a file."""


def content(result, folder):
    """Return what is in the file of a result, byte for byte."""
    path = Path(folder) / "result.nc"
    result.save(path)
    return path.read_bytes()


@contextmanager
def files_of_at_most(size):
    """As if the disk were full."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
