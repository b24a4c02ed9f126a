"""The explorer's server in this process, with real workers, and clients of it."""

import json
import threading
from contextlib import contextmanager

import httpx
import uvicorn
from websockets.sync.client import connect

from slipfold.interface.explorer.answering import Answering
from slipfold.interface.explorer.app import make_app
from slipfold.interface.explorer.catalogue import Catalogue
from slipfold.interface.explorer.messages import parse_request
from slipfold.interface.explorer.security import Access, ServerLimits
from slipfold.interface.explorer.serve import listen, settings_of_server
from slipfold.interface.explorer.workers import Workers

PATIENCE = 120
"""Seconds that a test waits for what should come at once."""

BASE = {"model": "sliding", "parameters": {"f": 12.5}, "vary": "Nd", "span": [0, 0.98]}
"""The paper's base case, Fig. 2."""

SLOW_PLANE = {
    "kind": "plane",
    "id": 1,
    "model": "sliding",
    "x": {"name": "f", "span": [11.5, 13.5]},
    "y": {"name": "Nd", "span": [0, 0.9]},
}
"""A plane that takes many seconds."""


def diagram(number=1, **changes):
    return {"kind": "diagram", "id": number, "show": "x", **BASE, **changes}


def answers_to(request, answering=None):
    """All that a request is answered without a server."""
    answers, answering = [], answering or Answering(Catalogue())
    answering.answer(parse_request(json.dumps(request)), answers.append, lambda: None)
    return answers


class Explorer:
    """A running server."""

    def __init__(self, access, workers):
        self.access = access
        self.workers = workers
        self.base = f"http://127.0.0.1:{access.port}"
        self.cookie = f"{access.cookie}={access.token}"

    def http(self):
        """A client that has the token."""
        return httpx.Client(base_url=self.base, headers={"cookie": self.cookie}, timeout=PATIENCE)

    @contextmanager
    def client(self):
        address = f"ws://127.0.0.1:{self.access.port}/ws"
        headers = {"cookie": self.cookie}
        with connect(
            address, origin=self.base, additional_headers=headers, max_size=None
        ) as socket:
            yield Client(socket)


class Client:
    """One open page."""

    def __init__(self, socket):
        self.socket = socket

    def send(self, request):
        self.socket.send(request if isinstance(request, (str, bytes)) else json.dumps(request))

    def receive(self):
        return json.loads(self.socket.recv(timeout=PATIENCE))

    def until_done(self, number):
        """All answers to a request; what is answered to others in between is left out."""
        answers = []
        while not answers or not answers[-1]["done"]:
            answer = self.receive()
            if answer["id"] == number:
                answers.append(answer)
        return answers

    def ask(self, request):
        self.send(request)
        return self.until_done(request["id"])[-1]


@contextmanager
def running_explorer(given=None, workers=2, limits=None):
    limits = limits or ServerLimits()
    listener = listen("127.0.0.1", 0)
    access = Access(listener.getsockname()[1])
    pool = Workers(given, workers, limits)
    app = make_app(Catalogue(given), access, pool, limits)
    server = uvicorn.Server(uvicorn.Config(app, **settings_of_server(limits)))
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]})
    thread.start()
    try:
        yield Explorer(access, pool)
    finally:
        server.should_exit = True
        thread.join()
