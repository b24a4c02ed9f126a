"""Run the explorer: listen, say the address, open the browser, stop on Ctrl-C."""

from __future__ import annotations

import socket
import webbrowser
from collections.abc import Callable

import uvicorn

from slipfold.explorer.app import make_app
from slipfold.explorer.catalogue import Catalogue
from slipfold.explorer.security import Access

__all__ = ["serve"]


def serve(catalogue: Catalogue, port: int, browser: bool, say: Callable[[str], None]) -> None:
    """Serve the explorer until it is interrupted.

    Parameters
    ----------
    catalogue
        The models to offer.
    port
        Port to listen on; 0 for any free one.
    browser
        Whether to open the page.
    say
        Prints a line.
    """
    listener = socket.create_server(("127.0.0.1", port))
    access = Access(listener.getsockname()[1])
    address = f"http://127.0.0.1:{access.port}/?token={access.token}"
    config = uvicorn.Config(make_app(catalogue, access), log_level="warning", server_header=False)
    say(address)
    if browser:
        webbrowser.open(address)
    uvicorn.Server(config).run(sockets=[listener])
