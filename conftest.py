"""The environment of every test and docstring example.

It lies beside ``pyproject.toml``, not in ``tests/``, so that ``pytest src`` sees it too. The
variables are set before anything imports numpy or matplotlib, and worker processes inherit them.
"""

import gc
import os
import shutil
import sys
import tempfile
import zlib
from collections import Counter
from contextlib import ExitStack

import pytest

for variable, value in {
    "MPLBACKEND": "Agg",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    # Most tests integrate a model of their own, and not for long: half of their time was compiling.
    "SLIPFOLD_OPTIMIZATION": "0",
}.items():
    os.environ.setdefault(variable, value)

# Containers often forbid it: each process that tests start would compile the package anew, which
# takes a third of its imports.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

FREE_CHOICES = pytest.StashKey()
CACHE_VARIABLE = "SLIPFOLD_CACHE_DIR"


def pytest_addoption(parser):
    group = parser.getgroup("slipfold")
    group.addoption(
        "--perturb-kernels",
        metavar="SEED",
        help="linear algebra answers as another LAPACK might; SEED is any word",
    )
    group.addoption(
        "--one-part-in",
        metavar="N",
        type=int,
        help="run one part in N of the files, which SEED chooses",
    )


def pytest_configure(config):
    perturb(config)
    # Compiled flows are kept in one folder for the whole run, shared by all workers: the
    # first process makes it, the workers find the variable set.
    if CACHE_VARIABLE not in os.environ:
        folder = tempfile.mkdtemp(prefix="slipfold-cache-")
        os.environ[CACHE_VARIABLE] = folder

        def remove():
            os.environ.pop(CACHE_VARIABLE, None)
            shutil.rmtree(folder, ignore_errors=True)

        config.add_cleanup(remove)


def perturb(config):
    """Replace linear algebra for the whole run, before what is tested imports it."""
    seed = config.getoption("perturb_kernels")
    if seed is None:
        return
    from portable.perturbed_kernels import perturbed

    kernels = ExitStack()
    config.stash[FREE_CHOICES] = kernels.enter_context(perturbed(seed))
    config.add_cleanup(kernels.close)


def pytest_collection_modifyitems(config, items):
    parts = config.getoption("one_part_in")
    if parts is None:
        return
    files = sorted({item.nodeid.partition("::")[0] for item in items})
    chosen = set(files[zlib.crc32(config.getoption("perturb_kernels").encode()) % parts :: parts])
    others = [item for item in items if item.nodeid.partition("::")[0] not in chosen]
    config.hook.pytest_deselected(items=others)
    items[:] = [item for item in items if item.nodeid.partition("::")[0] in chosen]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item):
    item.stash[FREE_CHOICES] = Counter(item.config.stash.get(FREE_CHOICES, ()))
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item):
    # Which bases LAPACK was free to choose: --junitxml writes it for each test.
    try:
        return (yield)
    finally:
        counts = item.config.stash.get(FREE_CHOICES, Counter())
        free = counts - item.stash[FREE_CHOICES]
        item.user_properties += [(name, count) for name, count in free.items()]


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    # All that is imported and listed here stays: looking through it for garbage, again and again
    # while it grows, takes a fifth of the time.
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.fixture(autouse=True)
def _close_figures():
    yield
    pyplot = sys.modules.get("matplotlib.pyplot")
    if pyplot is not None:
        pyplot.close("all")
