"""The environment of every test and docstring example.

It lies beside ``pyproject.toml``, not in ``tests/``, so that ``pytest src`` sees it too. The
variables are set before anything imports numpy or matplotlib, and worker processes inherit them.
"""

import gc
import os
import shutil
import sys
import tempfile

import pytest

for variable, value in {
    "MPLBACKEND": "Agg",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    # Most tests integrate a model of their own, and not for long: half of their time was compiling.
    "SLIPFOLD_OPTIMISATION": "0",
}.items():
    os.environ.setdefault(variable, value)

CACHE_VARIABLE = "SLIPFOLD_CACHE_DIR"


def pytest_configure(config):
    # Compiled flows are kept in one folder for the whole run, shared by all workers: the
    # first process makes it, the workers find the variable set.
    if CACHE_VARIABLE not in os.environ:
        folder = tempfile.mkdtemp(prefix="slipfold-cache-")
        os.environ[CACHE_VARIABLE] = folder

        def remove():
            os.environ.pop(CACHE_VARIABLE, None)
            shutil.rmtree(folder, ignore_errors=True)

        config.add_cleanup(remove)


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
