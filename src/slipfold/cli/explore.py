"""``slipfold explore``: the analysis as a page in the browser."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Annotated

import typer

from slipfold.cli.case_file import find_model
from slipfold.cli.status import say
from slipfold.errors import InputError

__all__ = ["explore"]

NEEDED = ("fastapi", "uvicorn", "websockets", "plotly")

File = Annotated[
    str | None,
    typer.Argument(metavar="[FILE]", help="A model of your own to offer first, e.g. case.toml."),
]
Port = Annotated[str, typer.Option(metavar="N", help="Port to listen on; 0 is any free one.")]
Browser = Annotated[bool, typer.Option("--no-browser", help="Do not open the page.")]


def explore(file: File = None, port: Port = "0", no_browser: Browser = False) -> None:
    """Open a local page on which the analysis is live; Ctrl-C ends it."""
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        raise InputError(
            f"slipfold explore needs {', '.join(missing)}, not installed here; "
            'install the extra with: pip install "slipfold[explore]"'
        )
    from slipfold.explorer.catalogue import Catalogue
    from slipfold.explorer.serve import serve

    given = None if file is None else find_model(file, {})
    serve(Catalogue(given), _port(port), not no_browser, say)


def _port(text: str) -> int:
    if not (text.isdecimal() and int(text) < 2**16):
        raise InputError(f"--port {text} is not a port; give a whole number from 0 to 65535")
    return int(text)
