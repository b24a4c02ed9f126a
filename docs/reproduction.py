"""Sphinx extension: puts what `make paper` wrote, if it was run, on the page about the paper."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

OUTPUT = "paper-output"
NOTHING = f"""\
## Figures and claims

This page shows them if `make paper` was run before the documentation was built; no `{OUTPUT}`
was found.
"""


def gather(output: Path, folder: Path) -> str:
    """Copy figures and tables beside the page's text, and return what refers to them.

    Parameters
    ----------
    output
        What `slipfold paper` wrote.
    folder
        Where the pages find files.
    """
    figures = sorted(output.glob("figure*.png"))
    if not figures or not (output / "claims.md").exists():
        return NOTHING
    sets = sorted(output.glob("bifurcation_set_*.png"))
    texts = [output / "claims.md", output / "thresholds.csv"]
    if sets:
        texts.append(output / "bifurcation_sets.md")
    for path in (*figures, *sets, *texts):
        shutil.copy(path, folder)
    parts = ["## Figures"]
    for path in figures:
        number = path.stem.removeprefix("figure").replace("_", ", ")
        parts.append(f"### Figure {number}")
        # A path from the root of the pages: the text is included from another folder.
        parts.append(f"![Figure {number}](/_build/paper/{path.name})")
    parts.append("All special points: {download}`thresholds.csv </_build/paper/thresholds.csv>`.")
    parts.append("```{include} /_build/paper/claims.md\n:heading-offset: 1\n```")
    for path in sets:
        parts.append(f"![{path.stem.replace('_', ' ')}](/_build/paper/{path.name})")
    if sets:
        parts.append("```{include} /_build/paper/bifurcation_sets.md\n:heading-offset: 1\n```")
    return "\n\n".join(parts)


def write(app: Sphinx) -> None:
    """Write the part of the page that depends on the output."""
    source = Path(app.srcdir)
    folder = source / "_build" / "paper"
    folder.mkdir(parents=True, exist_ok=True)
    text = gather(source.parent / OUTPUT, folder)
    (folder / "reproduction.md").write_text(text, encoding="utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    """Register with Sphinx."""
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True}
