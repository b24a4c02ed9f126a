"""The explorer as its users have it: the command's server, and Debian's Chromium on its page."""

import pytest

pytest.importorskip("fastapi", reason="the extra explore is not installed")
pytest.importorskip("playwright.sync_api", reason="the browser tests need playwright")

from helpers.explorer_models import HOSTILE
from helpers.explorer_page import PATIENCE, ExplorerPage, served


@pytest.fixture(scope="session")
def case_file(tmp_path_factory):
    """A model whose texts are markup."""
    case = tmp_path_factory.mktemp("explorer") / "hostile.toml"
    case.write_text(HOSTILE)
    return case


@pytest.fixture(scope="session")
def address(case_file):
    """The address of a page that offers the model of the file."""
    with served(case_file) as printed:
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
    tab.page.mouse.move(5, 5)  # what is pointed at is shown, also when the page moves below it
    tab.page.evaluate("scrollTo(0, 0)")  # other tests point at the diagram
    assert tab.faults == []


@pytest.fixture
def own_tab(context, address):
    """A tab of its own, for what cannot be taken from a tab again."""
    explorer = ExplorerPage(context.new_page(), address)
    yield explorer
    explorer.page.close()
    assert explorer.faults == []


@pytest.fixture(scope="session")
def second_tab(context, address):
    explorer = ExplorerPage(context.new_page(), address)
    explorer.holding(None)
    return explorer


@pytest.fixture
def new_tab(second_tab):
    """A page that is loaded anew: in a tab where it was before, which takes a third of the time."""
    second_tab.is_loaded = False
    yield second_tab
    second_tab.holding(None)
    second_tab.page.unroute_all()
    second_tab.page.set_viewport_size({"width": 1280, "height": 800})
    second_tab.page.emulate_media(color_scheme="light", reduced_motion="reduce")
    faults, second_tab.faults = second_tab.faults, []
    assert faults == []
