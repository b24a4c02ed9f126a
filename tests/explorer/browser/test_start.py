"""The page starts with any model; where it cannot, it says why."""

import pytest
from playwright.sync_api import expect

from helpers.explorer_models import MANY, UNUSUAL
from helpers.explorer_page import DIAGRAM, ExplorerPage, served
from helpers.long_tests import long_except


@pytest.mark.long
def test_a_model_with_an_unusual_name_and_many_parameters_is_shown(context, tmp_path):
    case = tmp_path / "unusual.toml"
    case.write_text(UNUSUAL)
    with served(case, workers=1) as address, context.new_page() as page:
        explorer = ExplorerPage(page, address)
        orbit = explorer.holding(lambda answer: answer["kind"] == "orbit")
        orbit.is_on = True
        page.goto(address)
        expect(page.locator(f"{DIAGRAM}[data-drawn]")).to_have_attribute("aria-busy", "false")
        expect(page.locator("#orbit-title")).to_have_text("Computing the orbit…")
        assert explorer.traces()
        assert page.locator(".parameters .parameter").count() == len(MANY)
        page.reload()  # the link says all that the page shows
        expect(page.locator(f"{DIAGRAM}[data-drawn]")).to_have_attribute("aria-busy", "false")
        assert explorer.faults == []


def _without_what_is_varied(route):
    models = route.fetch().json()
    models[0]["default"]["vary"] = "duration"
    route.fulfill(json=models)


def _half_a_script(route):
    route.fulfill(body="export const", content_type="text/javascript")


FAILURES = {
    "thrown": ("api/models", _without_what_is_varied, "TypeError"),
    "no answer": ("api/models", lambda route: route.abort(), "Failed to fetch"),
    "no script": ("page/dom.js", _half_a_script, "SyntaxError"),
    "no module": (
        "page/dom.js",
        lambda route: route.abort(),
        "/page/main.js could not be loaded",
    ),
    "no plots": ("plotly.min.js", lambda route: route.abort(), "/plotly.min.js could not be"),
}


@pytest.mark.parametrize("failure", long_except(FAILURES, ("thrown", "no plots")))
def test_a_page_that_cannot_start_says_why(context, address, failure):
    part, answer, reason = FAILURES[failure]
    with context.new_page() as page:
        page.route(f"**/{part}", answer)
        page.goto(address)
        alert = page.get_by_role("alert")
        expect(alert).to_contain_text("The page could not start")
        expect(alert).to_contain_text(reason)
        expect(page.locator("#page")).not_to_contain_text("Starting")


def test_the_first_curve_is_requested_before_the_page_can_draw(context, address):
    sent = []

    def listen(socket):
        socket.on("framesent", lambda frame: sent.append(frame))

    with context.new_page() as page:
        page.on("websocket", listen)
        page.route("**/plotly.min.js", lambda route: None)  # it is held up
        page.goto(f"{address}#model=duffing&plane=none")
        while not any('"diagram"' in frame for frame in sent):
            page.wait_for_timeout(20)
        page.unroute("**/plotly.min.js")  # it comes
        page.wait_for_selector("#diagram .plot[data-drawn][aria-busy=false]")
