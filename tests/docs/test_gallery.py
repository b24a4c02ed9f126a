"""Every page of the gallery runs, and its table agrees with what is published."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import matplotlib as mpl
import pytest

GALLERY = Path(__file__).parents[2] / "docs" / "gallery"
HELPERS = runpy.run_path(str(GALLERY.parent / "conf.py"))["sphinx_gallery_conf"]["ignore_pattern"]
PAGES = sorted(path for path in GALLERY.rglob("*.py") if not re.search(HELPERS, path.name))


# Systems of tests/docs/test_demos.py, or of other tests.
LONG = ["auto_demos", "bifurcationkit", "duffing_cascade", "pin_on_disc", "chain", "lorenz"]
LONG += ["freire", "roessler", "mathieu", "belts", "mode_coupling", "squeal_of_the_oscillator"]
LONG += ["grazing"]


@pytest.mark.parametrize(
    "page",
    [pytest.param(p, marks=[pytest.mark.long] * (p.stem in LONG), id=p.stem) for p in PAGES],
)
def test_page_agrees_with_what_is_published(page: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import matplotlib.pyplot as plt

    monkeypatch.setitem(mpl.rcParams, "backend", "agg")
    monkeypatch.syspath_prepend(str(GALLERY))
    with mpl.rc_context():
        table = runpy.run_path(str(page))["table"]
    plt.close("all")
    rows = list(table)
    assert rows
    assert all(row.agrees for row in rows), f"\n{table}"


def test_there_is_a_page_for_every_system_asked_for() -> None:
    assert len(PAGES) == 23
