"""Who is let in, and how much may be asked for."""

import socket

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from helpers.explorer_server import PATIENCE, running_explorer
from slipfold.interface.explorer.security import Access, ServerLimits

PATHS = ["/", "/page/main.js", "/plotly.min.js", "/api/models", "/openapi.json", "/nothing"]


def get(explorer, path, **headers):
    with explorer.http() as http:
        http.headers.pop("cookie")
        return http.get(path, headers=headers)


@pytest.mark.parametrize("path", PATHS)
def test_without_the_token_there_is_nothing(explorer, path):
    answer = get(explorer, path)
    assert answer.status_code == 401
    assert "the address that slipfold explore printed" in answer.text
    assert "set-cookie" not in answer.headers


@pytest.mark.parametrize("token", ["", "wrong", "ä", "%00", "x" * 5000])
def test_with_a_wrong_token_there_is_nothing(explorer, token):
    assert get(explorer, f"/?token={token}").status_code == 401
    wrong = f"{explorer.access.cookie}={token}".encode()
    assert get(explorer, "/api/models", cookie=wrong).status_code == 401


def test_the_token_in_the_address_becomes_a_cookie_that_no_script_can_read(explorer):
    answer = get(explorer, f"/?token={explorer.access.token}")
    assert answer.status_code == 200
    cookie = answer.headers["set-cookie"]
    assert cookie.startswith(explorer.cookie)
    assert {"HttpOnly", "SameSite=Strict", "Path=/"} <= set(cookie.split("; "))
    assert get(explorer, "/api/models", cookie=cookie.split(";")[0]).status_code == 200


@pytest.mark.parametrize("path", PATHS[1:])
def test_the_token_in_the_address_opens_the_page_alone(explorer, path):
    assert get(explorer, f"{path}?token={explorer.access.token}").status_code == 401


def test_every_run_has_a_token_of_its_own_that_is_not_shown():
    one, other = Access(8000), Access(8000)
    assert one.token != other.token
    assert len(one.token) >= 43  # 256 bits
    assert one.token not in repr(one)


@pytest.mark.parametrize(
    "host",
    ["attacker.example", "127.0.0.1", "127.0.0.1:1", "localhost.attacker.example:{port}", ""],
)
def test_another_host_is_refused(explorer, host):
    # A name of another site that is made to resolve to this machine (DNS rebinding).
    given = host.format(port=explorer.access.port)
    answer = get(explorer, "/api/models", host=given, cookie=explorer.cookie)
    assert answer.status_code in (400, 421)


@pytest.mark.parametrize(
    "origin", ["https://attacker.example", "null", "file://", "http://127.0.0.1:1"]
)
def test_another_origin_is_refused(explorer, origin):
    answer = get(explorer, "/api/models", origin=origin, cookie=explorer.cookie)
    assert answer.status_code == 403


@pytest.mark.parametrize("origin", [None, "https://attacker.example", "null"])
def test_a_socket_of_another_page_is_refused(explorer, origin):
    address = f"ws://127.0.0.1:{explorer.access.port}/ws"
    with (
        pytest.raises(InvalidStatus) as raised,
        connect(address, origin=origin, additional_headers={"cookie": explorer.cookie}),
    ):
        pass
    assert raised.value.response.status_code == 403


def test_a_socket_without_the_token_is_refused(explorer):
    with (
        pytest.raises(InvalidStatus),
        connect(f"ws://127.0.0.1:{explorer.access.port}/ws", origin=explorer.base),
    ):
        pass


def test_the_page_may_load_nothing_from_elsewhere(explorer):
    headers = get(explorer, "/", cookie=explorer.cookie).headers
    policy = headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "script-src 'self';" in policy
    assert "frame-ancestors 'none'" in policy
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "no-referrer"
    assert headers["x-frame-options"] == "DENY"
    assert "server" not in headers


@pytest.mark.parametrize(
    "path",
    [
        "/page/../app.py",
        "/page/%2e%2e/app.py",
        "/page/..%2fapp.py",
        "/page//etc/passwd",
        "/page/%00",
    ],
)
def test_only_the_files_of_the_page_are_served(explorer, path):
    with socket.create_connection(("127.0.0.1", explorer.access.port), timeout=PATIENCE) as raw:
        # As it stands: a client library would tidy the path up.
        head = f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{explorer.access.port}\r\n"
        raw.sendall(f"{head}Cookie: {explorer.cookie}\r\nConnection: close\r\n\r\n".encode())
        with raw.makefile("rb") as answer:
            assert answer.readline().split()[1] == b"404"


def test_a_large_request_is_refused(explorer):
    with explorer.http() as http:
        answer = http.post("/api/export", content=b" " * (ServerLimits().request_bytes + 1))
    assert answer.status_code == 413


def test_a_request_of_unknown_length_is_refused(explorer):
    with explorer.http() as http:
        answer = http.post("/api/export", content=iter([b"{}"]))
    assert answer.status_code == 411


def test_a_large_message_ends_the_socket(explorer):
    with explorer.client() as client:
        client.send(" " * (ServerLimits().request_bytes + 1))
        with pytest.raises(ConnectionClosed) as raised:
            client.receive()
    assert raised.value.rcvd.code == 1009


def test_too_many_requests_are_refused_and_at_last_the_client_is_let_go():
    limits = ServerLimits(requests_per_second=1e-9, burst=3)
    cancel = {"kind": "cancel", "of": "plane"}
    with running_explorer(workers=0, limits=limits) as explorer, explorer.client() as client:
        for number in range(4):
            client.send({**cancel, "id": number})
        answers = [client.receive() for _ in range(4)]
        assert [bool(answer.get("error")) for answer in answers] == [False, False, False, True]
        assert "requests a second" in answers[3]["error"]
        with pytest.raises(ConnectionClosed) as raised:
            talk_on(client, cancel)
    assert raised.value.rcvd.code == 1008


def talk_on(client, request):
    for number in range(2000):
        client.send({**request, "id": number})
        client.receive()


def test_too_many_pages_are_refused():
    with (
        running_explorer(workers=0, limits=ServerLimits(clients=1)) as explorer,
        explorer.client(),
        explorer.client() as second,
        pytest.raises(ConnectionClosed) as raised,
    ):
        second.receive()
    assert raised.value.rcvd.code == 1013
    assert "1 pages are open" in raised.value.rcvd.reason


def test_a_client_that_does_not_read_is_let_go():
    with (
        running_explorer(workers=0, limits=ServerLimits(unsent_bytes=10)) as explorer,
        explorer.client() as client,
    ):
        client.send({"kind": "cancel", "id": 1, "of": "plane"})
        with pytest.raises(ConnectionClosed) as raised:
            client.receive()
    assert raised.value.rcvd.code == 1008
