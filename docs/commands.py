"""Sphinx extension: every command with its options, as ``slipfold COMMAND --help`` prints them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from docutils import nodes
from docutils.parsers.rst import Directive
from typer.testing import CliRunner

from slipfold.interface.cli.app import COMMANDS, app

if TYPE_CHECKING:
    from sphinx.application import Sphinx


class Commands(Directive):
    """A section for each command."""

    def run(self) -> list[nodes.Node]:
        """Return the sections."""
        return [self._section(name) for name in COMMANDS]

    def _section(self, name: str) -> nodes.section:
        text = CliRunner().invoke(app, [name, "--help"], prog_name="slipfold").stdout
        block = nodes.literal_block(text, text, language="none")
        identifier = nodes.make_id(f"command-{name}")
        return nodes.section("", nodes.title(text=name), block, ids=[identifier])


def setup(app: Sphinx) -> dict[str, Any]:
    """Add the directive ``commands``."""
    app.add_directive("commands", Commands)
    return {"parallel_read_safe": True}
