"""The application: the page, its files, the models, exports, and one session a page."""

from __future__ import annotations

import asyncio
import itertools
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from importlib.resources import files
from pathlib import Path
from typing import Any

from fastapi import FastAPI, Request, WebSocket
from fastapi.exceptions import RequestValidationError
from fastapi.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from pydantic import ValidationError

from slipfold.errors import InputError
from slipfold.interface.explorer.catalogue import Catalogue
from slipfold.interface.explorer.export import MEDIA_TYPES, SUFFIXES
from slipfold.interface.explorer.messages import (
    CancelRequest,
    ExportRequest,
    LawRequest,
    MeasurementsRequest,
    ModelRequest,
    PostedRequest,
    TextRequest,
    ValuesRequest,
    ViewRequest,
    parse_request,
    refusal_of,
)
from slipfold.interface.explorer.security import Access, Allowance, Application, Guard, ServerLimits
from slipfold.interface.explorer.texts import answered
from slipfold.interface.explorer.workers import Job, Reply, Workers

POLICY_VIOLATION, TRY_AGAIN = 1008, 1013
"""Codes with which a WebSocket is closed (RFC 6455)."""


class Session:
    """Talks with one client until it leaves."""

    def __init__(
        self, socket: WebSocket, workers: Workers, limits: ServerLimits, number: int
    ) -> None:
        self._socket = socket
        self._workers = workers
        self._limits = limits
        self._number = number
        self._newest: dict[tuple[str, str], Job] = {}
        self._unsent: asyncio.Queue[bytes | None] = asyncio.Queue()
        self._unsent_bytes = 0
        self._allowance = Allowance(limits.requests_per_second, limits.burst)
        self._refused = 0

    async def run(self) -> None:
        """Answer requests until the client leaves or is let go."""
        writing = asyncio.create_task(self._write())
        reading = asyncio.create_task(self._read())
        try:
            await asyncio.wait({writing, reading}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for job in self._newest.values():
                self._workers.cancel(job)
            for task in (writing, reading):
                task.cancel()
            await asyncio.gather(writing, reading, return_exceptions=True)

    async def _read(self) -> None:
        while True:
            message = await self._socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            text = message.get("text") or message.get("bytes") or b""
            if not self._take(text):
                return

    def _take(self, text: str | bytes) -> bool:
        """Take one request; False if the client is to be let go."""
        if not self._allowance.take():
            self._refused += 1
            if self._refused > self._limits.refused:
                self._unsent.put_nowait(None)
                return True
            sentence = f"more than {self._limits.requests_per_second:g} requests a second; wait"
            self._put({**refusal_of(text), "error": sentence})
            return True
        try:
            request = parse_request(text)
        except ValidationError as error:
            self._put(refusal_of(text, error))
            return True
        if isinstance(request, CancelRequest):
            self._stop(request)
        else:
            self._start(request)
        return True

    def _start(self, request: ViewRequest) -> None:
        key = (request.kind, request.slot)

        def deliver(reply: Reply) -> None:
            if reply.last and self._newest.get(key) is job:
                del self._newest[key]
            if reply.body:
                self._put(reply.body)

        def fail(sentence: str, again: bool = False) -> None:
            if self._newest.get(key) is job:
                del self._newest[key]
            self._put({**request.head, "done": True, "error": sentence, "again": again})

        job = Job(request, self._number, deliver, fail)
        before = self._newest.get(key)
        self._newest[key] = job
        self._workers.submit(job, instead_of=before)

    def _stop(self, request: CancelRequest) -> None:
        job = self._newest.pop((request.of, request.slot), None)
        if job is not None:
            self._workers.cancel(job)
        self._put({**request.head, "of": request.of, "done": True})

    # -- answers -------------------------------------------------------------------------------

    def _put(self, answer: bytes | dict[str, Any]) -> None:
        body = answer if isinstance(answer, bytes) else json.dumps(answer).encode()
        self._unsent_bytes += len(body)
        # None ends the session: a client that does not read must not fill the memory.
        self._unsent.put_nowait(body if self._unsent_bytes <= self._limits.unsent_bytes else None)

    async def _write(self) -> None:
        while True:
            body = await self._unsent.get()
            if body is None:
                await self._socket.close(POLICY_VIOLATION, "too many requests, or answers not read")
                return
            await self._socket.send_text(body.decode())
            self._unsent_bytes -= len(body)


PAGE_TYPES = {
    ".css": "text/css",
    ".html": "text/html",
    ".js": "text/javascript",
    ".svg": "image/svg+xml",
}
"""Media types of the page's files; nothing else is served."""

FRESH, A_DAY = {"cache-control": "no-cache"}, {"cache-control": "private, max-age=86400"}

TOO_MANY = "too many requests a second; wait a little"


def make_app(
    catalogue: Catalogue,
    access: Access,
    workers: Workers,
    limits: ServerLimits,
    study: dict[str, Any] | None = None,
) -> Application:
    """Return the application, guarded; it shows a study if it is given one."""

    @asynccontextmanager
    async def running(app: FastAPI) -> AsyncIterator[None]:
        await workers.start()
        yield
        await workers.stop()

    app = FastAPI(title="slipfold explore", docs_url=None, redoc_url=None, lifespan=running)
    app.add_exception_handler(RequestValidationError, _refusal)
    _add_files(app)
    _add_interface(app, catalogue, Answers(catalogue, workers, limits), study)
    _add_socket(app, workers, limits)
    return Guard(app, access, limits)


async def _refusal(request: Request, error: Exception) -> Response:
    """Return the errors of a request without repeating it: it may not be text."""
    assert isinstance(error, RequestValidationError)
    errors = [{name: item[name] for name in ("loc", "msg", "type")} for item in error.errors()]
    return JSONResponse({"detail": errors}, 422)


def _add_files(app: FastAPI) -> None:
    # The files are looked up among those that are there now: no path of a client is opened.
    folder = Path(str(files("slipfold.interface.explorer") / "page"))
    result = [item for item in folder.rglob("*") if item.suffix in PAGE_TYPES]
    page = {item.relative_to(folder).as_posix(): item for item in result}
    plotly_file = Path(str(files("plotly") / "package_data" / "plotly.min.js"))

    @app.get("/", include_in_schema=False)
    async def index() -> Response:
        return FileResponse(page["index.html"], media_type="text/html", headers=FRESH)

    @app.get("/page/{name:path}", include_in_schema=False)
    async def page_file(name: str) -> Response:
        if name not in page:
            return PlainTextResponse("the page has no such file", 404)
        kind = PAGE_TYPES[page[name].suffix]
        return FileResponse(page[name], media_type=kind, headers=FRESH)

    @app.get("/plotly.min.js", include_in_schema=False)
    async def plotly() -> Response:
        return FileResponse(plotly_file, media_type="text/javascript", headers=A_DAY)


class Answers:
    """What answers requests over HTTP."""

    def __init__(self, catalogue: Catalogue, workers: Workers, limits: ServerLimits) -> None:
        self._catalogue = catalogue
        self._workers = workers
        self._allowance = Allowance(limits.requests_per_second, limits.burst)

    async def by_worker(
        self, request: PostedRequest, media_type: str = "application/json", name: str = ""
    ) -> Response:
        """Answer by a worker; `name` is that of a file."""
        if not self._allowance.take():
            return PlainTextResponse(TOO_MANY, 429)
        reply = await _computed(self._workers, request)
        if isinstance(reply, str) or reply.refused:
            sentence = reply if isinstance(reply, str) else reply.body.decode()
            return PlainTextResponse(sentence, 400)
        headers = {"content-disposition": f'attachment; filename="{name}"'} if name else {}
        return Response(reply.body, media_type=media_type, headers=headers)

    async def about(self, request: ValuesRequest | MeasurementsRequest | TextRequest) -> Response:
        """Answer about a model; one of a client's text is made by a worker, which can be ended."""
        if request.text is not None:
            return await self.by_worker(request)
        if not self._allowance.take():
            return PlainTextResponse(TOO_MANY, 429)
        try:
            return JSONResponse(answered(self._catalogue, request))
        except InputError as error:
            return PlainTextResponse(str(error), 400)


REFUSED: dict[int | str, dict[str, Any]] = {
    400: {"content": {"text/plain": {}}, "description": "why there is none"},
    429: {"content": {"text/plain": {}}, "description": "too many requests"},
}

A_FILE: dict[int | str, dict[str, Any]] = {
    200: {"content": {kind: {} for kind in MEDIA_TYPES.values()}, "description": "the file"}
}


def _add_interface(
    app: FastAPI, catalogue: Catalogue, answers: Answers, study: dict[str, Any] | None
) -> None:
    described = catalogue.describe()

    @app.get("/api/models")
    async def models() -> list[dict[str, Any]]:
        return described

    @app.get("/api/study")
    async def shown_study() -> dict[str, Any] | None:
        return study

    @app.post("/api/values", response_model=dict[str, str], responses=REFUSED)
    async def values(request: ValuesRequest) -> Response:
        """Report which values a model cannot have: sentences by parameter."""
        return await answers.about(request)

    @app.post("/api/measurements", responses=REFUSED)
    async def measurements(request: MeasurementsRequest) -> Response:
        """Read a measured response with the units of a model."""
        return await answers.about(request)

    @app.post("/api/text", response_model=dict[str, Any], responses=REFUSED)
    async def text(request: TextRequest) -> Response:
        """Return a model as a text to edit, that of a file as it is now, and its equations."""
        return await answers.about(request)

    @app.post("/api/model", response_model=dict[str, Any], responses=REFUSED)
    async def written(request: ModelRequest) -> Response:
        """Make the model of a text: return its description, or what is wrong with it and where."""
        return await answers.by_worker(request)

    @app.post("/api/law", response_model=dict[str, str], responses=REFUSED)
    async def law(request: LawRequest) -> Response:
        """Return the text of a model with another friction law in a contact."""
        return await answers.by_worker(request)

    @app.post("/api/export", response_class=PlainTextResponse, responses=A_FILE | REFUSED)
    async def export(request: ExportRequest) -> Response:
        """Make a file of a view, or the text that makes it."""
        name = f"{request.view.kind}.{SUFFIXES[request.format]}"
        return await answers.by_worker(request, MEDIA_TYPES[request.format], name)


async def _computed(workers: Workers, request: PostedRequest) -> Reply | str:
    """Return the reply of a worker, or why there is none."""
    arrived: asyncio.Future[Reply | str] = asyncio.get_running_loop().create_future()

    def arrive(reply: Reply | str) -> None:
        if not arrived.done():
            arrived.set_result(reply)

    def fail(sentence: str, again: bool = False) -> None:
        arrive(sentence)

    job = Job(request, 0, arrive, fail)
    workers.submit(job)
    try:
        return await arrived
    except asyncio.CancelledError:  # the client has gone
        workers.cancel(job)
        raise


def _add_socket(app: FastAPI, workers: Workers, limits: ServerLimits) -> None:
    here: set[int] = set()

    @app.websocket("/ws")
    async def talk(socket: WebSocket) -> None:
        await socket.accept()
        if len(here) >= limits.clients:
            await socket.close(TRY_AGAIN, f"{limits.clients} pages are open; close one")
            return
        # A page that is alone is the first, so that its exports go to the worker of its diagrams.
        number = next(number for number in itertools.count() if number not in here)
        here.add(number)
        try:
            await Session(socket, workers, limits, number).run()
        finally:
            here.discard(number)
