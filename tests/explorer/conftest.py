import pytest

pytest.importorskip("fastapi", reason="the extra explore is not installed")

from helpers.explorer_server import running_explorer


def pytest_collection_modifyitems(items):
    """These tests come first: other processes take from the end, and start no server or browser."""
    items.sort(key=lambda item: not item.nodeid.startswith("tests/explorer/"))


@pytest.fixture(scope="session")
def explorer():
    """A server with two workers; its tests leave it as they found it."""
    with running_explorer() as running:
        yield running


@pytest.fixture
def client(explorer):
    with explorer.client() as connected:
        yield connected
