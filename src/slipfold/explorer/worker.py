"""A worker process: computes one request at a time, and drops it when it is superseded."""

from __future__ import annotations

import json
import logging
import signal
import sys
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NamedTuple

from slipfold.errors import InputError
from slipfold.explorer.answering import Answering
from slipfold.explorer.catalogue import Catalogue
from slipfold.explorer.messages import ExportRequest, ViewRequest
from slipfold.models.model import Model

READY = 0
"""Number of the reply that says that the worker is ready."""

DATA_BYTES = 2 * 2**30
"""Maximum data memory of a worker in bytes: a larger request fails, not the machine."""


class WorkerTask(NamedTuple):
    """What a worker is given."""

    number: int  # number of the job
    request: ViewRequest | ExportRequest  # the request


class Reply(NamedTuple):
    """What a worker gives back."""

    number: int  # number of the job
    body: bytes  # JSON, or the file of an export
    last: bool = True  # whether it is the last one
    refused: bool = False  # whether the body of an export is a sentence that says why there is none


class Superseded(Exception):
    """The request is superseded."""


def run_worker(
    connection: Connection, current: Any, given: Model | None, file: Path | None
) -> None:
    """Compute until it is stopped; the main function of a worker process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the server says when to stop
    _bound_memory()
    answering = Answering(Catalogue(given, file))
    _warm_up(answering)
    connection.send(Reply(READY, b""))
    while True:
        try:
            task: WorkerTask | None = connection.recv()
        except EOFError:
            return  # the server is gone
        if task is None:
            return
        try:
            connection.send(_reply(answering, task, connection, current))
        except (BrokenPipeError, ConnectionResetError):
            return


def _warm_up(answering: Answering) -> None:
    """Prepare for the first request; what fails here will fail there, and is said to who asks."""
    try:
        answering.warm_up()
    except Exception:
        logging.getLogger("slipfold.explorer").exception("the first view cannot be computed")


def _reply(answering: Answering, task: WorkerTask, connection: Connection, current: Any) -> Reply:
    """Compute one task; return its last reply."""
    number, request = task
    held = b""

    def check() -> None:
        if current.value != number:
            raise Superseded

    def emit(view: dict[str, Any]) -> None:
        nonlocal held
        body = json.dumps(view, allow_nan=False, separators=(",", ":")).encode()
        if view["done"]:
            held = body
        else:
            connection.send(Reply(number, body, last=False))

    try:
        if isinstance(request, ExportRequest):
            return Reply(number, answering.export(request, check))
        answering.answer(request, emit, check)
        return Reply(number, held)
    except Superseded:
        return Reply(number, b"")
    except InputError as error:
        return _failure(task, str(error))
    except MemoryError:
        return _failure(task, "the computation needs more memory than a worker may take")
    except Exception as error:
        logging.getLogger("slipfold.explorer").exception("a request failed: %r", request)
        return _failure(
            task,
            f"this is a defect of slipfold ({type(error).__name__}: {error}); the terminal in "
            "which slipfold explore runs says more",
        )


def _failure(task: WorkerTask, sentence: str) -> Reply:
    request = task.request
    if isinstance(request, ExportRequest):
        return Reply(task.number, sentence.encode(), refused=True)
    answer = {**request.head, "done": True, "error": sentence}
    return Reply(task.number, json.dumps(answer).encode())


def _bound_memory() -> None:
    if sys.platform == "win32":
        return
    import resource

    hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
    bound = DATA_BYTES if hard == resource.RLIM_INFINITY else min(hard, DATA_BYTES)
    resource.setrlimit(resource.RLIMIT_DATA, (bound, hard))
