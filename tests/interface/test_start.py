"""What ``import slipfold`` imports, and when: nothing before it is requested."""

import multiprocessing
import os
import subprocess
import sys
from pathlib import Path

import pytest

import slipfold
from helpers.studies import CHEAP
from slipfold.threads import VARIABLES
from slipfold.version import package_version


def run(text: str) -> str:
    return subprocess.run(
        [sys.executable, "-c", text], check=True, capture_output=True, text=True
    ).stdout.strip()


def test_the_package_alone_imports_no_compiler_and_no_arrays():
    names = run("import slipfold, sys; print({'heyoka', 'numpy'} & set(sys.modules))")
    assert names == "set()"


def test_the_version_is_that_of_the_package():
    assert slipfold.__version__ == package_version()


@pytest.mark.parametrize(
    ("used", "left"),
    [("computations.response", "slipfold.bifurcations.loci"), ("interface.paper", "matplotlib")],
)
def test_what_is_needed_later_is_imported_later(used, left):
    assert run(f"import slipfold.{used}, sys; print('{left}' in sys.modules)") == "False"


def test_no_public_name_imports_what_takes_a_second():
    text = (
        "import slipfold, sys\n"
        "for name in slipfold.__all__: getattr(slipfold, name)\n"
        "print({'scipy', 'xarray', 'pandas', 'matplotlib'} & set(sys.modules))"
    )
    assert run(text) == "set()"


def test_what_is_not_there_is_said():
    text = "import slipfold\ntry: slipfold.nothing\nexcept AttributeError as error: print(error)"
    assert run(text) == "module 'slipfold' has no attribute 'nothing'"


@pytest.mark.parametrize(("given", "threads"), [(None, "1"), ("3", "3")])
def test_commands_take_one_thread_for_linear_algebra_unless_asked_otherwise(given, threads):
    text = (
        "import os, sys\n"
        "from slipfold.interface.cli import main\n"
        "assert 'numpy' not in sys.modules\n"
        "sys.argv = ['slipfold', '--version']\n"
        "try: main()\n"
        "except SystemExit: print(os.environ['OPENBLAS_NUM_THREADS'])"
    )
    free = {name: value for name, value in os.environ.items() if name not in VARIABLES}
    told = {} if given is None else {"OPENBLAS_NUM_THREADS": given}
    printed = subprocess.check_output([sys.executable, "-c", text], env=free | told, text=True)
    assert printed.split()[-1] == threads


@pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="needs Linux")
def test_processes_of_a_study_start_with_one_thread(monkeypatch):
    for name in VARIABLES:
        monkeypatch.delenv(name, raising=False)
    given = set[bool]()

    def look(_):
        for process in multiprocessing.active_children():
            given.add(
                b"OPENBLAS_NUM_THREADS=1" in Path(f"/proc/{process.pid}/environ").read_bytes()
            )

    slipfold.study(CHEAP, executor=2, on_progress=look)
    assert given == {True}
    assert not set(VARIABLES) & set(os.environ)
