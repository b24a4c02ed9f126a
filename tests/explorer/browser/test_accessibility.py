"""Everyone can use the page: axe-core finds no violation, and the tabulator stops rarely."""

import pytest
from playwright.sync_api import expect

import slipfold as sf
from helpers.explorer_page import violations
from slipfold.interface.explorer.curves import study_view

pytest.importorskip("axe_playwright_python.sync_playwright", reason="there is no axe-core")

STOPS = """
() => [...document.querySelectorAll("button, input, select, summary, a, [tabindex]")]
  .filter((node) => node.tabIndex >= 0 && !node.disabled)
  .filter((node) => node.checkVisibility({ visibilityProperty: true })).length
"""


STUDY = {
    "model": "duffing",
    "compute": {"what": "simulation", "periods": 1},
    "cases": {"grid": {"W": [1.3, 1.4], "F": [0.2, 0.25]}},
}

MEASURED = "W [rad/s],max q,sweep\n1.2,0.9,up\n1.4,0.7,down\n"


def test_no_panel_has_a_violation_in_either_theme(own_tab):
    page = own_tab.page
    study = study_view(sf.study(STUDY), "duffing")
    page.route("**/api/study", lambda route: route.fulfill(json=study))
    page.set_viewport_size({"width": 1366, "height": 768})
    own_tab.open("model=duffing&p.d=0.3&plane=W~1.3~1.5~F~0.2~0.3", plane=True)

    def press(name):
        page.get_by_role("button", name=name, exact=True).click()

    press("Pin this curve")
    press("From rest")
    press("Compute the basins")
    press("Torus or chaos?")
    press("Compute the regimes")
    file = {"name": "rig.csv", "mimeType": "text/csv", "buffer": MEASURED.encode()}
    page.get_by_label("File of measurements").set_input_files(file)
    page.wait_for_selector(".basins-plot[data-points]")
    page.wait_for_selector(".file-name")
    expect(page.locator("#exponents strong")).to_be_visible()
    press("Sweep up and down")
    page.wait_for_selector(".sweep-control[data-state=running]")
    own_tab.box("d").fill("1,5")
    page.get_by_label("Export the diagram").first.click()
    assert violations(page) == []
    page.get_by_text("Copy as Python").first.click()
    expect(page.locator("dialog[open]")).to_be_visible()
    assert violations(page, "dialog[open]") == []
    page.keyboard.press("Escape")
    page.keyboard.press("p")
    assert violations(page) == []
    page.keyboard.press("Escape")


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
