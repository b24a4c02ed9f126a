"""The application: the page, its files, the models, and the WebSocket."""

from __future__ import annotations

import asyncio
import json
from importlib.resources import files
from typing import Any

from fastapi import FastAPI, WebSocket, WebSocketDisconnect
from fastapi.responses import FileResponse, Response
from pydantic import ValidationError

from slipfold.explorer.answering import Answering
from slipfold.explorer.catalogue import Catalogue
from slipfold.explorer.messages import CancelRequest, parse_request
from slipfold.explorer.security import Access, Application, Guard

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

    answering = Answering(catalogue)

    @app.websocket("/ws")
    async def talk(socket: WebSocket) -> None:
        await socket.accept()
        try:
            while True:
                text = await socket.receive_text()
                answers: list[dict[str, Any]] = []
                try:
                    request = parse_request(text)
                    if not isinstance(request, CancelRequest):
                        await asyncio.to_thread(answering.answer, request, answers.append)
                except ValidationError as error:
                    answers.append({"kind": "error", "id": None, "error": str(error)})
                for answer in answers:
                    await socket.send_text(json.dumps(answer, allow_nan=False))
        except WebSocketDisconnect:
            pass

    return Guard(app, access)
