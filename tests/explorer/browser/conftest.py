"""The explorer as its users have it: the command's server, and Debian's Chromium on its page."""

import pytest

pytest.importorskip("fastapi", reason="the extra explore is not installed")
pytest.importorskip("playwright.sync_api", reason="the browser tests need playwright")

from helpers.explorer_models import BRAKE_OF_FILE, HOSTILE, STIFFNESS
from helpers.explorer_page import PATIENCE, ExplorerPage, served


@pytest.fixture(scope="session")
def address(tmp_path_factory):
    """The address of a page that offers a model whose texts are markup."""
    case = tmp_path_factory.mktemp("explorer") / "hostile.toml"
    case.write_text(HOSTILE)
    with served(case) as printed:
        yield printed


@pytest.fixture(scope="session")
def brake_file(tmp_path_factory):
    case = tmp_path_factory.mktemp("brake") / "one's own.toml"
    case.write_text(BRAKE_OF_FILE)
    (case.parent / "K.mtx").write_text(STIFFNESS)
    return case


@pytest.fixture(scope="session")
def brake_address(brake_file):
    """The address of a page that offers a structure from a file."""
    with served(brake_file, workers=1) as printed:
        yield printed


@pytest.fixture(scope="session")
def context(browser):
    """A reader who has seen the tour, on a laptop, and wishes for less motion."""
    context = browser.new_context(
        viewport={"width": 1280, "height": 800},
        permissions=["clipboard-read", "clipboard-write"],
        reduced_motion="reduce",
    )
    context.set_default_timeout(PATIENCE)
    context.add_init_script("localStorage.setItem('slipfold-tour-seen', 'yes')")
    yield context
    context.close()


@pytest.fixture(scope="session")
def tab(context, address):
    return ExplorerPage(context.new_page(), address)


@pytest.fixture
def explorer(tab):
    """A tab that was used before; nothing may go wrong on it unseen."""
    yield tab
    tab.page.evaluate("scrollTo(0, 0)")  # other tests point at the diagram
    assert tab.faults == []


@pytest.fixture
def brake(context, brake_address):
    """A tab that shows the structure of a user's own."""
    explorer = ExplorerPage(context.new_page(), brake_address)
    yield explorer
    explorer.page.close()
    assert explorer.faults == []


@pytest.fixture
def new_tab(context, address):
    """A tab of its own."""
    explorer = ExplorerPage(context.new_page(), address)
    yield explorer
    explorer.page.close()
    assert explorer.faults == []
