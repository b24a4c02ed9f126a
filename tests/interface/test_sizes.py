"""The project stays small enough to be read."""

import ast
import subprocess
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = ("src", "tests", "docs", "bench")
WRITTEN = {".py", ".js", ".css", ".html", ".md"}

TOTAL = {"src": 84_172, "tests": 43_405}
"""Lines of Python. Lower it whenever code is deleted; raise it for what is new, and say why."""

FILE_LINES = 600
FUNCTION_LINES = 60  # below the docstring
FOLDER_FILES = 35


@pytest.fixture(scope="module")
def files():
    """Files that git knows, without what tools leave beside them."""
    try:
        listed = subprocess.check_output(["git", "ls-files", "-z", *FOLDERS], cwd=ROOT, text=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("no checkout of the project")
    return [path for path in map(ROOT.joinpath, listed.split("\0")) if path.is_file()]


@pytest.fixture(scope="module")
def definitions(files):
    """Functions with their lengths below the docstring, and how often a class has a name."""
    lengths, classes = {}, Counter()
    for path in files:
        if path.suffix == ".py":
            tree = ast.parse(path.read_bytes())  # not kept: a million nodes take their time
            for node in ast.walk(tree):
                if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                    documented = ast.get_docstring(node, clean=False) is not None
                    begin = node.body[0].end_lineno if documented else node.lineno
                    lengths[f"{path}:{node.lineno}"] = node.end_lineno - begin
            if path.is_relative_to(ROOT / "src"):
                classes.update(node.name for node in tree.body if isinstance(node, ast.ClassDef))
    return lengths, classes


def lines_of(path):
    return len(path.read_text(encoding="utf-8").splitlines())


@pytest.mark.parametrize("folder", TOTAL)
def test_the_total_stays_in_its_budget(files, folder):
    counted = [p for p in files if p.suffix == ".py" and p.is_relative_to(ROOT / folder)]
    assert sum(map(lines_of, counted)) <= TOTAL[folder]


def test_no_file_is_long(files):
    lines = {path: lines_of(path) for path in files if path.suffix in WRITTEN}
    assert {str(path): count for path, count in lines.items() if count > FILE_LINES} == {}


def test_no_function_is_long(definitions):
    lengths, _ = definitions
    assert {place: length for place, length in lengths.items() if length > FUNCTION_LINES} == {}


def test_a_class_name_stands_for_one_thing(definitions):
    _, classes = definitions
    repeated = {name for name, count in classes.items() if count > 1}
    assert {name for name in repeated if not name.startswith("_")} == set()


def test_no_folder_is_full(files):
    held = Counter(path.parent for path in files)
    assert {str(folder): count for folder, count in held.items() if count > FOLDER_FILES} == {}
