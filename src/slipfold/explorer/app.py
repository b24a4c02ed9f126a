"""The application: the page, its files, the models, and the WebSocket."""

from __future__ import annotations

import asyncio
import json
from importlib.resources import files
from time import perf_counter
from typing import Any

from fastapi import FastAPI, WebSocket, WebSocketDisconnect
from fastapi.responses import FileResponse, Response
from pydantic import ValidationError

from slipfold.errors import InputError
from slipfold.explorer.catalogue import Catalogue
from slipfold.explorer.messages import DiagramRequest, parse_request
from slipfold.explorer.security import Access, Application, Guard
from slipfold.explorer.views.diagram import diagram_view
from slipfold.results.response import response

__all__ = ["make_app"]

TYPES = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
    ".mjs": "text/javascript",
    ".svg": "image/svg+xml",
}


def make_app(catalogue: Catalogue, access: Access) -> Application:
    """Return the application, guarded.

    Parameters
    ----------
    catalogue
        The models to offer.
    access
        Who is let in.
    """
    app = FastAPI(title="slipfold explore", docs_url=None, redoc_url=None)
    page = {
        item.name: item
        for item in (files("slipfold.explorer") / "page").iterdir()
        if item.is_file()
    }

    @app.get("/")
    def index() -> Response:
        return FileResponse(str(page["index.html"]), media_type="text/html")

    @app.get("/page/{name:path}")
    def page_file(name: str) -> Response:
        if name not in page:
            return Response("there is no such file", 404)
        suffix = name[name.rfind(".") :]
        return FileResponse(
            str(page[name]), media_type=TYPES.get(suffix, "application/octet-stream")
        )

    @app.get("/plotly.min.js")
    def plotly() -> Response:
        return FileResponse(
            str(files("plotly") / "package_data" / "plotly.min.js"), media_type="text/javascript"
        )

    @app.get("/api/models")
    def models() -> list[dict[str, Any]]:
        return catalogue.describe()

    @app.websocket("/ws")
    async def talk(socket: WebSocket) -> None:
        await socket.accept()
        try:
            while True:
                text = await socket.receive_text()
                answer = await asyncio.to_thread(_answer, catalogue, text)
                await socket.send_text(json.dumps(answer, allow_nan=False, separators=(",", ":")))
        except WebSocketDisconnect:
            pass

    return Guard(app, access)


def _answer(catalogue: Catalogue, text: str) -> dict[str, Any]:
    started = perf_counter()
    try:
        request = parse_request(text)
    except ValidationError as error:
        return {"kind": "error", "id": None, "error": str(error)}
    head = {"kind": request.kind, "id": request.id, "slot": request.slot}
    if not isinstance(request, DiagramRequest):
        return {**head, "error": f"{request.kind} is not answered yet"}
    try:
        model = catalogue.model(request.model, request.parameters)
        view = diagram_view(
            response(model, request.vary, request.span), request.show, request.statistic
        )
    except InputError as error:
        return {**head, "error": str(error)}
    return {**head, **view, "done": True, "elapsed_ms": 1e3 * (perf_counter() - started)}
