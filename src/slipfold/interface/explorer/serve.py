"""Run the explorer: listen, say the address, open the browser, stop on Ctrl-C."""

from __future__ import annotations

import ipaddress
import os
import socket
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import Any

import uvicorn

from slipfold.errors import InputError
from slipfold.interface.explorer.app import make_app
from slipfold.interface.explorer.catalogue import Catalogue
from slipfold.interface.explorer.curves import study_view
from slipfold.interface.explorer.security import LOCAL, Access, ServerLimits
from slipfold.interface.explorer.settings import PAGE
from slipfold.interface.explorer.workers import Workers
from slipfold.models.model import Model
from slipfold.results.study import StudyResult


def default_workers() -> int:
    """Return the number of worker processes: one a core, and two at least."""
    return min(max(os.cpu_count() or 1, 2), PAGE.workers)


def serve(
    given: Model | None,
    file: Path | None = None,
    *,
    study: StudyResult | None = None,
    port: int,
    public: str | None,
    workers: int,
    browser: bool,
    say: Callable[[str], None],
) -> None:
    """Serve the explorer until it is interrupted."""
    catalogue = Catalogue(given, file)
    described = None if study is None else study_view(study, catalogue.names[0])
    listener = listen(public or "127.0.0.1", port)
    host = f"[{public}]" if public and ":" in public else public or "127.0.0.1"
    access = Access(listener.getsockname()[1], (host,) if public else LOCAL)
    limits = ServerLimits()
    pool = Workers(given, workers, limits, file)
    app = make_app(catalogue, access, pool, limits, described)
    config = uvicorn.Config(app, **settings_of_server(limits))
    address = f"http://{host}:{access.port}/?token={access.token}"
    say(address)
    if browser:
        webbrowser.open(address)
    uvicorn.Server(config).run(sockets=[listener])


def settings_of_server(limits: ServerLimits) -> dict[str, Any]:
    """Return the options of uvicorn."""
    return {
        "log_level": "warning",
        "server_header": False,
        "proxy_headers": False,
        "ws": "websockets-sansio",
        "ws_max_size": limits.request_bytes,
        "ws_per_message_deflate": False,
        "limit_concurrency": 4 * limits.clients,
        "timeout_graceful_shutdown": 2,
    }


def listen(address: str, port: int) -> socket.socket:
    """Open a port."""
    if _is_every(address):
        raise InputError(
            f"--public-bind {address} means every address of this machine, but requests are "
            "checked against one; give that by which other machines reach this one"
        )
    family = socket.AF_INET6 if ":" in address else socket.AF_INET
    try:
        return socket.create_server((address, port), family=family)
    except OSError as error:
        why = (error.strerror or str(error)).lower()
        raise InputError(
            f"{address} port {port} cannot be listened on ({why}); give another port, or --port 0 "
            "for any free one"
        ) from error


def _is_every(address: str) -> bool:
    try:
        return ipaddress.ip_address(address).is_unspecified
    except ValueError:
        return False
