import pytest

pytest.importorskip("fastapi", reason="the extra explore is not installed")

from helpers.explorer_server import running_explorer


@pytest.fixture(scope="session")
def explorer():
    """A server with two workers; its tests leave it as they found it."""
    with running_explorer() as running:
        yield running


@pytest.fixture
def client(explorer):
    with explorer.client() as connected:
        yield connected
