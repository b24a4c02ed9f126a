"""The page about the paper builds with and without the paper's output."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType

import pytest

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture
def reproduction(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(DOCS))
    return importlib.import_module("reproduction")


def test_without_output_the_page_says_what_to_do(reproduction: ModuleType, tmp_path: Path) -> None:
    text = reproduction.gather(tmp_path / "paper-output", tmp_path)
    assert "make paper" in text
    assert list(tmp_path.iterdir()) == []


def test_output_is_copied_and_shown(reproduction: ModuleType, tmp_path: Path) -> None:
    output, folder = tmp_path / "paper-output", tmp_path / "page"
    output.mkdir()
    folder.mkdir()
    names = ("figure2.png", "figure3.png", "claims.md", "thresholds.csv")
    names += ("bifurcation_set_f_Nd.png", "bifurcation_sets.md")
    for name in names:
        (output / name).write_text(name)
    text = reproduction.gather(output, folder)
    assert sorted(path.name for path in folder.iterdir()) == sorted(names)
    assert text.index("/_build/paper/figure2.png") < text.index("/_build/paper/figure3.png")
    assert "{include} /_build/paper/claims.md" in text
    assert "/_build/paper/bifurcation_set_f_Nd.png" in text
    assert "{include} /_build/paper/bifurcation_sets.md" in text
