"""Worker processes: what is dropped is dropped, what is killed is replaced, what is large ends."""

import asyncio
import json
import os
import pickle
import signal
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest

from helpers.explorer_server import BASE, SLOW_PLANE, diagram, running_explorer
from slipfold.interface.explorer import answering, trajectories
from slipfold.interface.explorer.answering import Answering
from slipfold.interface.explorer.catalogue import Catalogue
from slipfold.interface.explorer.messages import ExportRequest, parse_request
from slipfold.interface.explorer.security import ServerLimits
from slipfold.interface.explorer.workers import MODEL, Job, Workers

EXPONENTS = {"kind": "exponents", "id": 1, "model": "sliding"}


@pytest.fixture(scope="module")
def explorer():
    """One worker, so that it is known which."""
    with running_explorer(workers=1) as running:
        yield running


def test_a_killed_worker_gives_a_sentence_and_a_fresh_one(explorer):
    with explorer.client() as client:
        client.send(SLOW_PLANE)
        assert "progress" in client.receive()
        before = explorer.workers.processes
        os.kill(before[0], signal.SIGKILL)
        answer = client.until_done(1)[-1]
        assert "ended from outside (signal 9)" in answer["error"]
        assert answer["again"]
        assert client.ask(diagram(2))["branches"]
    assert explorer.workers.processes != before


def test_a_long_computation_ends_when_it_is_no_longer_wanted(explorer):
    # The plane takes many seconds; a text does not wait for it, and its worker is free at the next
    # point.
    with explorer.client() as client, explorer.http() as http:
        client.send(SLOW_PLANE)
        assert "progress" in client.receive()
        text = http.post("/api/export", json={"view": SLOW_PLANE, "format": "python"}).text
        assert "sf.bifurcation_set(" in text
        processes = explorer.workers.processes
        client.send({"kind": "cancel", "id": 2, "of": "plane"})
        while (answer := client.receive())["id"] != 2:
            assert not answer["done"]
        assert client.ask(diagram(3))["done"]
        assert explorer.workers.processes == processes


def test_a_client_that_leaves_takes_its_requests_along(explorer):
    with explorer.client() as client:
        client.send(SLOW_PLANE)
        assert "progress" in client.receive()
    with explorer.client() as client:
        assert client.ask(diagram(1))["branches"]


def computed(workers, *requests):
    """Last replies, or sentences, of requests that are submitted one after the other."""

    async def run():
        await workers.start()
        outcomes = [await one(workers, request) for request in requests]
        await workers.stop()
        return outcomes

    async def one(workers, request):
        arrived = asyncio.get_running_loop().create_future()

        def deliver(reply):
            if reply.last:
                arrived.set_result(reply)

        workers.submit(Job(parse_request(json.dumps(request)), 0, deliver, arrived.set_result))
        return await arrived

    # In a thread of its own: a browser driven in this process has a loop that runs here.
    with ThreadPoolExecutor(1) as executor:
        return executor.submit(lambda: asyncio.run(run())).result()


def test_what_takes_too_long_is_given_up_and_a_worker_that_has_grown_is_replaced():
    limits = ServerLimits(seconds={"plane": 1e-3, "diagram": 60.0}, worker_bytes=1)
    sentence, *replies = computed(Workers(None, 1, limits), SLOW_PLANE, diagram(1), diagram(2))
    assert sentence.startswith("this took more than 0.001 s and was given up")
    assert all(b'"branches"' in reply.body for reply in replies)


class Unloadable:
    """What ends the process that reads it."""

    def __reduce__(self):
        return os._exit, (7,)


@pytest.mark.long
def test_workers_that_cannot_start_are_not_started_for_ever():
    [sentence] = computed(Workers(Unloadable(), 1, ServerLimits()), diagram())
    assert "no worker process can be started" in sentence


def test_a_request_waits_for_the_worker_that_knows_its_branches_unless_that_takes_long():
    orbit = {"kind": "orbit", "id": 1, **BASE, "at": {"branch": 1, "arclength": 0.1}}
    friction = {"kind": "friction", "id": 1, "model": "sliding"}
    workers = Workers(None, 2, ServerLimits())
    home, free = (SimpleNamespace(idle=True, ready=True, job=None) for _ in range(2))
    rows = (diagram(), [orbit]), (orbit, [diagram(), orbit]), (friction, [diagram(), orbit])
    for now, waiting in (*rows, (EXPONENTS, [])):
        busy = SimpleNamespace(idle=False, ready=True, dropping=False, job=made(now))
        workers._workers = [busy, free]
        for asked in (diagram(), orbit):
            assert workers._choose(made(asked)) is (None if asked in waiting else free)
    workers._workers = [home, free]
    assert workers._choose(made(friction)) is free
    assert workers._choose(made(diagram())) is home


SHORT = {"kind": "simulation", "id": 1, "model": "sliding", "periods": 20}
SMALL_PLANE = {**SLOW_PLANE, "x": {"name": "f", "span": [12.4, 12.41]}}
SMALL_PLANE["y"] = {"name": "Nd", "span": [0.05, 0.06]}


@pytest.mark.parametrize("view", [diagram(), SMALL_PLANE, SHORT], ids=lambda view: view["kind"])
def test_a_file_is_made_of_what_is_shown_by_any_worker(view, few_lines, monkeypatch):
    """Each worker ends what takes long by its own seconds, so that another makes another file."""
    request = parse_request(json.dumps(view))
    maker, other = Answering(Catalogue()), Answering(Catalogue())
    maker.answer(request, lambda view: None, lambda: None)
    result = pickle.loads(pickle.dumps(maker.made(request)))
    monkeypatch.delattr(answering, "response")
    monkeypatch.delattr(answering, "bifurcation_set")
    monkeypatch.delattr(trajectories, "simulate")
    other.adopt(request, result)
    for each in (maker, other):
        assert each.export(ExportRequest(view=request, format="csv"), lambda: None)


def test_a_file_does_not_wait_for_what_takes_long(explorer):
    with explorer.client() as client, explorer.http() as http:
        client.send(SHORT)
        client.until_done(1)
        client.send({**SLOW_PLANE, "id": 2})
        assert "progress" in client.receive()
        assert http.post("/api/export", json={"view": SHORT, "format": "nc"}).content[:4]
        client.send({"kind": "cancel", "id": 3, "of": "plane"})
        while (answer := client.receive())["id"] != 3:
            assert not answer["done"]


def test_the_file_of_an_orbit_is_made_of_its_diagram():
    orbit = {"kind": "orbit", "id": 3, **BASE, "at": {"branch": 1, "arclength": 0.1}}
    views = [parse_request(json.dumps(view)) for view in (orbit, diagram(show="y"))]
    assert len({view.subject(*MODEL) for view in views}) == 1


def made(request, place=1):
    """A job of the client whose worker is the first one."""
    job = Job(parse_request(json.dumps(request)), 0, None, None)
    job.position = place
    return job


def test_quick_requests_go_first_and_none_waits_for_ever():
    plane = made(SLOW_PLANE, 1)
    assert made(diagram(), 2).order < plane.order
    assert made(diagram(), 200).order > plane.order
    assert made(diagram(slot="pin:1"), 2).order > made(diagram(), 3).order
