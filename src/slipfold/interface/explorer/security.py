"""Access to the explorer: token and addresses, limits of a client, what a page may load."""

from __future__ import annotations

import secrets
from collections.abc import Awaitable, Callable, Mapping, MutableMapping
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from time import monotonic
from typing import Any
from urllib.parse import parse_qs, urlsplit


@dataclass(frozen=True)
class ServerLimits:
    """Bounds on what clients ask for."""

    request_bytes: int = 192 * 1024  # largest request: the text of a model, escaped, and values
    # Requests of one client, in the long run; a slider that is dragged makes sixty
    requests_per_second: float = 120.0
    burst: int = 240  # requests of one client at once
    refused: int = 500  # requests too many, after which a client is let go
    clients: int = 64  # open pages
    # Workers in a row that end before they are ready, after which no more are started
    failed_starts: int = 3
    unsent_bytes: int = 64 * 2**20  # answers that wait for a slow client; beyond that it is let go
    # Time in s that a worker may take over a request, by kind, where not its own
    seconds: Mapping[str, float] = field(default_factory=dict)
    worker_bytes: int = 2**30  # memory beyond which a worker is replaced once it is idle


class Allowance:
    """Number of requests a client has left; it grows with time.

    By `per_second`, up to `maximum`; `clock` returns the time in s.

    >>> allowance = Allowance(1.0, 2, clock=lambda: 0.0)
    >>> [allowance.take() for _ in range(3)]
    [True, True, False]
    """

    def __init__(
        self, per_second: float, maximum: int, clock: Callable[[], float] = monotonic
    ) -> None:
        self._per_second = per_second
        self._maximum = maximum
        self._clock = clock
        self._left = float(maximum)
        self._then = clock()

    def take(self) -> bool:
        """Use one up; False if there is none."""
        now = self._clock()
        self._left = min(self._left + (now - self._then) * self._per_second, self._maximum)
        self._then = now
        if self._left < 1:
            return False
        self._left -= 1
        return True


Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
Application = Callable[[Scope, Receive, Send], Awaitable[None]]

LOCAL = ("127.0.0.1", "localhost", "[::1]")
"""Names of this machine, to itself."""

WAY_IN = "open the address that slipfold explore printed, with its token"

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; font-src 'self'; connect-src 'self' {sockets}; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""What the page may load: itself alone. plotly.js writes style elements, hence the exception."""


@dataclass(frozen=True)
class Access:
    """Who is let in.

    >>> access = Access(8000)
    >>> access.knows_host("localhost:8000"), access.knows_host("attacker.example:8000")
    (True, False)
    """

    port: int  # port the explorer listens on
    hosts: tuple[str, ...] = LOCAL  # names and addresses under which it may be reached
    # The secret of this run; a random one by default
    token: str = field(default_factory=lambda: secrets.token_urlsafe(32), repr=False)

    @property
    def cookie(self) -> str:
        """Name of the cookie; cookies of one host are shared by its ports."""
        return f"slipfold-{self.port}"

    def is_token(self, given: str) -> bool:
        """Whether this is the token, in a time that does not depend on how much of it is right."""
        return secrets.compare_digest(given.encode(), self.token.encode())

    def knows_host(self, header: str) -> bool:
        """Whether a Host header names this server; a rebound name of another site does not."""
        return header.lower() in {f"{host}:{self.port}" for host in self.hosts}

    def knows_origin(self, header: str) -> bool:
        """Whether a request comes from a page of this server."""
        parts = urlsplit(header)
        return parts.scheme in ("http", "https") and self.knows_host(parts.netloc)


class Guard:
    """Lets requests through to the application that come from its own page; adds the headers."""

    def __init__(self, application: Application, access: Access, limits: ServerLimits) -> None:
        self.application = application
        self.access = access
        self.limits = limits

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request or one WebSocket."""
        if scope["type"] not in ("http", "websocket"):
            await self.application(scope, receive, send)
            return
        headers = {
            key.decode("latin-1").lower(): value.decode("latin-1")
            for key, value in scope["headers"]
        }
        refusal = self._refusal(scope, headers)
        if refusal is not None:
            await _refuse(scope, receive, send, *refusal)
            return
        await self.application(scope, receive, self._with_headers(scope, headers, send))

    def _refusal(self, scope: Scope, headers: dict[str, str]) -> tuple[int, str] | None:
        """Return status and sentence if the request must not pass."""
        access = self.access
        if not access.knows_host(headers.get("host", "")):
            return 421, "this address is not one that slipfold explore answers to"
        origin = headers.get("origin")
        if origin is not None and not access.knows_origin(origin):
            return 403, "the request comes from another site"
        if origin is None and scope["type"] == "websocket":
            return 403, "a WebSocket without an Origin is refused"
        if not self._has_token(scope, headers):
            return 401, WAY_IN
        length = headers.get("content-length", "0")
        if not length.isdecimal() or int(length) > self.limits.request_bytes:
            return 413, f"the request is larger than {self.limits.request_bytes} bytes"
        if "transfer-encoding" in headers:
            return 411, "a request must say how long it is"
        return None

    def _has_token(self, scope: Scope, headers: dict[str, str]) -> bool:
        try:
            cookie = SimpleCookie(headers.get("cookie", "")).get(self.access.cookie)
        except CookieError:
            cookie = None
        if cookie is not None and self.access.is_token(cookie.value):
            return True
        return self._brings_token(scope)

    def _brings_token(self, scope: Scope) -> bool:
        """Whether the address of the page carries the token; no other address may."""
        if scope["type"] != "http" or scope["path"] != "/" or scope["method"] != "GET":
            return False
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])
        return self.access.is_token(given[0])

    def _with_headers(self, scope: Scope, headers: dict[str, str], send: Send) -> Send:
        host = headers["host"]
        added = {
            "content-security-policy": POLICY.format(sockets=f"ws://{host} wss://{host}"),
            "cross-origin-opener-policy": "same-origin",
            "cross-origin-resource-policy": "same-origin",
            "permissions-policy": "camera=(), geolocation=(), microphone=()",
            "referrer-policy": "no-referrer",
            "x-content-type-options": "nosniff",
            "x-frame-options": "DENY",
        }
        if self._brings_token(scope):
            added["set-cookie"] = (
                f"{self.access.cookie}={self.access.token}; HttpOnly; SameSite=Strict; Path=/"
            )

        async def sending(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                pairs = [(name.encode(), value.encode()) for name, value in added.items()]
                message = {**message, "headers": [*message.get("headers", []), *pairs]}
            await send(message)

        return sending


async def _refuse(scope: Scope, receive: Receive, send: Send, status: int, sentence: str) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 1008, "reason": sentence})
        return
    body = sentence.encode()
    headers = [
        (b"content-type", b"text/plain; charset=utf-8"),
        (b"content-length", str(len(body)).encode()),
        (b"x-content-type-options", b"nosniff"),
    ]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})
