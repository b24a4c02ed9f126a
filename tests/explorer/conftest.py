import pytest

pytest.importorskip("fastapi", reason="the extra explore is not installed")

from helpers.explorer_server import running_explorer

FIRST = ("tests/explorer/browser/", "tests/interface/")


def pytest_collection_modifyitems(items):
    """Tests of the page come first: one process drives a browser, for most of the run.

    Behind them come hundreds that take no time, so that it gets little besides. Other tests of the
    explorer start a server of their own, and may do so in another process.
    """
    items.sort(key=lambda item: [not item.nodeid.startswith(folder) for folder in FIRST])


@pytest.fixture(scope="session")
def explorer():
    """A server with two workers; its tests leave it as they found it."""
    with running_explorer() as running:
        yield running


@pytest.fixture
def client(explorer):
    with explorer.client() as connected:
        yield connected
