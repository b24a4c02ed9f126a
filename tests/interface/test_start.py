"""What ``import slipfold`` imports, and when: nothing before it is requested."""

import os
import subprocess
import sys

import pytest

import slipfold
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
