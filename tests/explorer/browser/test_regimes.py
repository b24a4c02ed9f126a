"""What motions do in the plane, on request; the pointer tells what there is where it points."""

import re

from playwright.sync_api import expect

from helpers.explorer_page import PLANE

WINDOW = "model=duffing&p.W=1.4&p.F=0.25&plane=W~1.3~1.5~F~0.2~0.3"
"""All motions repeat soon there: their pictures take a second."""

REGIMES = ".regimes"


def pointed(explorer, right, up):
    """What is said with the pointer at a place of the plane, as shares of it."""
    box = explorer.page.locator(f"{PLANE} .nsewdrag").bounding_box()
    explorer.page.mouse.move(box["x"] + right * box["width"], box["y"] + (1 - up) * box["height"])
    return explorer.page.locator(".under-pointer")


def test_regimes_are_drawn_and_named_under_the_pointer(explorer):
    page = explorer.open(WINDOW, plane=True).page
    plot = page.locator(f"{PLANE} .nsewdrag")
    before = plot.bounding_box()
    page.get_by_role("button", name="Compute the regimes").click()
    # The pointer rests while the pictures come, and the plot stays where it is.
    words = pointed(explorer, 0.5, 0.1)
    regimes = page.locator(REGIMES)
    expect(regimes).to_have_attribute("data-cells", re.compile("[0-9]+"))
    expect(page.locator(".plane-legend li .shade")).to_have_count(1)
    expect(words).to_contain_text("motion from the start: period 1")
    expect(words).to_contain_text("Ω = 1.4")
    assert plot.bounding_box() == before
    page.get_by_role("button", name="Remove", exact=True).click()
    expect(regimes).to_have_attribute("data-cells", "")
    expect(pointed(explorer, 0.5, 0.2)).not_to_contain_text("motion from")
    page.get_by_role("button", name="Compute the regimes").click()
    expect(regimes).to_have_attribute("data-cells", re.compile("[0-9]+"))
    # What is of other values is not shown.
    explorer.type("d", 0.11)
    expect(regimes).to_have_attribute("data-cells", "")
