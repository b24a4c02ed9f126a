"""The page starts with any model; where it cannot, it says why."""

import re

import pytest
from playwright.sync_api import expect

from helpers.explorer_models import MANY, UNUSUAL
from helpers.explorer_page import DIAGRAM, ExplorerPage, served


def test_an_unforced_structure_of_ones_own_is_shown(brake, brake_file):
    brake.page.goto(brake.address)
    names = brake.page.get_by_label("Vary", exact=True).locator("option")
    expect(names).to_have_count(6)
    values = names.evaluate_all("(options) => options.map(({ value }) => value)")
    assert values == ["Ns", "Vd", "mu_s", "mu_k", "vs", "s2"]
    brake.open("model=brake&vary=Vd&span=0.4~2")
    assert brake.specials() == ["HB 0.8952\u202fm/s subcritical"]
    brake.page.get_by_label("Export the diagram").first.click()
    brake.page.locator("#diagram .menu").get_by_text("Copy as Python", exact=True).click()
    copied = brake.page.locator("dialog pre")
    expect(copied).to_contain_text(f"sf.Structure.from_toml({str(brake_file)!r})")
    brake.page.keyboard.press("Escape")


def test_a_model_with_an_unusual_name_and_many_parameters_is_shown(context, tmp_path):
    case = tmp_path / "unusual.toml"
    case.write_text(UNUSUAL)
    with served(case, workers=1) as address, context.new_page() as page:
        explorer = ExplorerPage(page, address)
        page.goto(address)
        expect(page.locator(f"{DIAGRAM}[data-drawn]")).to_have_attribute("aria-busy", "false")
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
    "no script": ("page/controls/dom.js", _half_a_script, "SyntaxError"),
    "no module": (
        "page/controls/dom.js",
        lambda route: route.abort(),
        "/page/main.js could not be loaded",
    ),
    "no plots": ("plotly.min.js", lambda route: route.abort(), "/plotly.min.js could not be"),
}


@pytest.mark.parametrize(("part", "answer", "reason"), FAILURES.values(), ids=FAILURES)
def test_a_page_that_cannot_start_says_why(context, address, part, answer, reason):
    with context.new_page() as page:
        page.route(f"**/{part}", answer)
        page.goto(address)
        alert = page.get_by_role("alert")
        expect(alert).to_contain_text("The page could not start")
        expect(alert).to_contain_text(reason)
        expect(page.locator("#page")).not_to_contain_text("Starting")


def test_what_fails_later_is_said_too(context, address):
    with context.new_page() as page:
        explorer = ExplorerPage(page, address).open()
        with page.expect_event("pageerror"):
            page.evaluate(
                "() => { queueMicrotask(() => { throw new Error('a plot fell over'); }); }"
            )
        expect(page.get_by_role("alert")).to_contain_text(re.compile("defect.*a plot fell over"))
        assert explorer.faults == ["a plot fell over"]
