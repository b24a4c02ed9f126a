"""Everyone can use the page: axe-core finds no violation, and the tabulator stops rarely."""

import pytest
from playwright.sync_api import expect

axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="there is no axe-core")

STOPS = """
() => [...document.querySelectorAll("button, input, select, summary, a, [tabindex]")]
  .filter((node) => node.tabIndex >= 0 && !node.disabled)
  .filter((node) => node.checkVisibility({ visibilityProperty: true })).length
"""


def violations(page, where=None):
    found = axe.Axe().run(page, where).response["violations"]
    return [(item["id"], [node["html"][:120] for node in item["nodes"]]) for item in found]


def test_no_panel_has_a_violation_in_either_theme(new_tab):
    page = new_tab.open("model=duffing&plane=W~1.3~1.5~F~0.2~0.3", plane=True).page
    page.set_viewport_size({"width": 1366, "height": 768})
    assert violations(page) == []
    page.get_by_role("button", name="Pin this curve").click()
    new_tab.box("d").fill("1,5")
    page.get_by_role("button", name="From rest", exact=True).click()
    page.get_by_role("button", name="Compute the basins").click()
    page.wait_for_selector(".basins-plot[data-points]")
    page.get_by_label("Export the diagram").first.click()
    for theme in ("dark", "light"):
        page.emulate_media(color_scheme=theme)
        assert violations(page) == []
    page.get_by_text("Copy as Python").first.click()
    expect(page.locator("dialog[open]")).to_be_visible()
    assert violations(page, "dialog[open]") == []


def test_the_tabulator_stops_at_each_parameter_and_each_toolbar_once(explorer):
    page = explorer.open("model=sliding&p.Nd=0.3").page
    explorer.orbit_shown(2)
    assert page.evaluate(STOPS) < 50
    pin = page.get_by_role("button", name="Pin this curve")
    pin.focus()
    page.keyboard.press("ArrowRight")
    expect(page.get_by_role("button", name="Measurements")).to_be_focused()
    page.keyboard.press("End")
    expect(page.locator("summary[aria-label='Export the diagram']")).to_be_focused()
    page.keyboard.press("Tab")
    expect(page.get_by_label("Vary", exact=True)).to_be_focused()
    chips = page.locator(".specials .chip")
    chips.first.focus()
    page.keyboard.press("ArrowRight")
    expect(chips.nth(1)).to_be_focused()
    assert [chip.get_attribute("tabindex") for chip in chips.all()] == ["-1", "0", "-1"]
