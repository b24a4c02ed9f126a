"""``slipfold explore``: the analysis as a page in the browser."""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING, Annotated

from slipfold.declarations import Option
from slipfold.errors import InputError
from slipfold.interface.cli.commands import argument, given_text
from slipfold.interface.cli.reading import equations_file, find_model, load_result
from slipfold.interface.cli.running import note, say

if TYPE_CHECKING:
    from slipfold.results.study import StudyResult

NEEDED = ("fastapi", "uvicorn", "websockets", "plotly")

READERS = {
    "file": given_text(
        argument(
            "[FILE]",
            "A model of your own to offer first, e.g. case.toml, or a study, e.g. study.nc.",
            "file",
            None,
        )
    )
}
Port = Annotated[int, Option("Port to listen on; 0 is any free one.", minimum=0, maximum=2**16 - 1)]
Browser = Annotated[bool, Option("Do not open the page.")]
Workers = Annotated[
    int | None, Option("Processes that compute; one a core, 2 to 4, by default.", maximum=64)
]
Public = Annotated[
    str | None,
    Option(
        "Listen on this address of the machine instead of 127.0.0.1. Everyone who gets the printed "
        "address, with its token, can then use this machine's processors; nothing is encrypted, so "
        "that others on the network can read the token.",
        metavar="ADDRESS",
    ),
]


def explore(
    file: str | None,
    port: Port = 0,
    no_browser: Browser = False,
    workers: Workers = None,
    public_bind: Public = None,
) -> None:
    """Open the explorer in the browser, for this machine only; Ctrl-C ends it."""
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        raise InputError(
            f"slipfold explore needs {', '.join(missing)}, which the extra brings: "
            'pip install "slipfold[explore]"'
        )
    from slipfold.interface.explorer.serve import default_workers, serve

    study = _study(file) if file is not None and file.endswith(".nc") else None
    given = study.model if study else None if file is None else find_model(file, {})
    if public_bind is not None:
        note(
            f"listening on {public_bind} for other machines: whoever has the address with its "
            "token can compute here, and nothing is encrypted"
        )
    serve(
        given,
        None if file is None else equations_file(file),
        study=study,
        port=port,
        public=public_bind,
        workers=workers or default_workers(),
        browser=not no_browser,
        say=say,
    )


def _study(file: str) -> StudyResult:
    from slipfold.results.study import StudyResult

    advice = "which is of one case; give one of slipfold study, or a case file"
    return load_result(file, StudyResult, advice)
