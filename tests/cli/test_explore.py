"""``slipfold explore``: what it is given, and what it says."""

import importlib
import socket

import pytest

from helpers.command_line import run


@pytest.fixture
def started(monkeypatch):
    """Options with which the server would have been started."""
    pytest.importorskip("fastapi")
    calls = []
    monkeypatch.setattr(
        "slipfold.interface.explorer.serve.serve",
        lambda given, file, **options: calls.append((given, {**options, "file": file})),
    )
    return calls


def test_it_listens_on_this_machine_alone_unless_asked_otherwise(started):
    assert run("explore", "--no-browser").exit_code == 0
    [(given, options)] = started
    assert given is None
    assert options["public"] is None
    assert options["port"] == 0
    assert options["browser"] is False


def test_a_public_address_is_said_to_be_one(started):
    result = run("explore", "--public-bind", "192.0.2.7")
    assert "whoever has the address with its token can compute here" in result.stderr
    assert started[0][1]["public"] == "192.0.2.7"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            ["--port", "70000"],
            "--port 70000 is not a whole number from 0 to 65535; give one",
        ),
        (["--port", "x"], "--port x is not a whole number"),
        (["--workers", "0"], "--workers 0 is not a whole number from 1 to 64"),
        (["missing.toml"], "missing.toml cannot be read"),
        (["nothing"], "there is no model 'nothing'"),
    ],
    ids=str,
)
def test_what_cannot_be_used_is_refused_in_a_sentence(started, arguments, words):
    result = run("explore", *arguments)
    assert result.exit_code == 2
    assert words in result.stderr
    assert started == []


def test_without_the_extra_it_says_what_to_install(monkeypatch):
    monkeypatch.setattr(
        importlib.import_module("slipfold.interface.cli.explore"), "find_spec", lambda name: None
    )
    result = run("explore")
    assert result.exit_code == 2
    assert 'pip install "slipfold[explore]"' in result.stderr


@pytest.mark.parametrize("address", ["0.0.0.0", "::"])
def test_every_address_at_once_is_refused(address):
    pytest.importorskip("fastapi")
    result = run("explore", "--no-browser", "--public-bind", address)
    assert result.exit_code == 2
    assert "means every address of this machine" in result.stderr


def test_a_port_in_use_is_refused():
    pytest.importorskip("fastapi")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        result = run("explore", "--no-browser", "--port", port)
    assert result.exit_code == 2
    assert f"127.0.0.1 port {port} cannot be listened on" in result.stderr
