"""One open page: its requests, of which the newest of each kind wins, and its answers."""

from __future__ import annotations

import asyncio
import json
from typing import Any

from fastapi import WebSocket
from pydantic import ValidationError

from slipfold.explorer.job import Job
from slipfold.explorer.limits import Allowance, Limits
from slipfold.explorer.messages import CancelRequest, ViewRequest, parse_request, refusal_of
from slipfold.explorer.worker import Reply
from slipfold.explorer.workers import Workers

POLICY_VIOLATION, TRY_AGAIN = 1008, 1013
"""Codes with which a WebSocket is closed (RFC 6455)."""

PATIENCE = 500
"""Refused requests after which a client that asks too often is let go."""


class Session:
    """Talks with one client until it leaves."""

    def __init__(self, socket: WebSocket, workers: Workers, limits: Limits, number: int) -> None:
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
            if self._refused > PATIENCE:
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
            head = {"kind": request.kind, "id": request.id, "slot": request.slot}
            self._put({**head, "done": True, "error": sentence, "again": again})

        job = Job(request, self._number, deliver, fail)
        before = self._newest.get(key)
        self._newest[key] = job
        self._workers.submit(job, instead_of=before)

    def _stop(self, request: CancelRequest) -> None:
        job = self._newest.pop((request.of, request.slot), None)
        if job is not None:
            self._workers.cancel(job)
        head = {"kind": "cancel", "id": request.id, "slot": request.slot}
        self._put({**head, "of": request.of, "done": True})

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
