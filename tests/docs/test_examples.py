"""The examples on the pages of the documentation run as they are printed."""

from __future__ import annotations

import doctest
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
BUILT = ("_build", "gallery_pages")
BLOCK = re.compile(r"^```pycon\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def examples(page: Path) -> str:
    """All examples of a page, one after the other."""
    return "\n".join(BLOCK.findall(page.read_text(encoding="utf-8")))


# What they show has tests of its own in the folders of these names, and in parameter_space.
LONG = ["friction-damper", "measured-data", "uncertainty-and-design"]
LONG += ["attractors", "structures", "tori-and-chaos"]


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(p, marks=[pytest.mark.long] * (p.stem in LONG), id=p.name)
        for p in (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))
        if not {*BUILT} & {*p.parts} and examples(p)
    ],
)
@pytest.mark.usefixtures("few_lines")
def test_examples_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import matplotlib as mpl

    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(mpl.rcParams, "backend", "agg")
    test = doctest.DocTestParser().get_doctest(examples(page), {}, page.name, str(page), 0)
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    report: list[str] = []
    runner.run(test, out=report.append)
    assert runner.tries
    assert not runner.failures, "".join(report)


def test_the_tutorial_has_examples() -> None:
    assert examples(ROOT / "docs" / "tutorial.md").count(">>>") > 30
