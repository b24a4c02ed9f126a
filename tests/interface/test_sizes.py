"""Files and folders of the project stay small enough to be read."""

import subprocess
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = ("src", "tests", "docs", "bench")
WRITTEN = {".py", ".js", ".css", ".html", ".md"}

LONGEST = 450
"""Lines of a file."""

MOST = 25
"""Files of a folder."""


@pytest.fixture(scope="module")
def files():
    """What is kept of the project, without what tools leave beside it."""
    try:
        listed = subprocess.check_output(["git", "ls-files", "-z", *FOLDERS], cwd=ROOT, text=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("no checkout of the project")
    return [path for path in map(ROOT.joinpath, listed.split("\0")) if path.is_file()]


def test_no_file_is_long(files):
    written = [path for path in files if path.suffix in WRITTEN]
    lines = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in written}
    assert {str(path): count for path, count in lines.items() if count > LONGEST} == {}


def test_no_folder_is_full(files):
    held = Counter(path.parent for path in files)
    assert {str(folder): count for folder, count in held.items() if count > MOST} == {}
