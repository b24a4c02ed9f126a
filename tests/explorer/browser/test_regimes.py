"""What motions do in the plane, on request; the pointer tells what there is where it points."""

import re

import pytest
from playwright.sync_api import expect

from helpers.explorer_page import PLANE, ExplorerPage

WINDOW = "model=sliding&p.f=12.5&p.Nd=0.02&span=0.01~0.03&plane=f~12.45~12.55~Nd~0~0.16"
REGIMES = ".regimes"


@pytest.fixture
def plane(context, address):
    """A tab with a plane whose bifurcation set is not waited for."""
    explorer = ExplorerPage(context.new_page(), address)
    explorer.open(WINDOW, plane=True)
    yield explorer
    explorer.page.close()
    assert explorer.faults == []


def pointed(explorer, right, up):
    """What is said with the pointer at a place of the plane, as shares of it."""
    box = explorer.page.locator(f"{PLANE} .nsewdrag").bounding_box()
    explorer.page.mouse.move(box["x"] + right * box["width"], box["y"] + (1 - up) * box["height"])
    return explorer.page.locator(".under-pointer")


def test_regimes_are_drawn_and_told_under_the_pointer(plane):
    page = plane.page
    page.get_by_role("button", name="What do motions do?").click()
    regimes = page.locator(REGIMES)
    expect(regimes).to_have_attribute("data-cells", re.compile("[0-9]+"))
    legend = page.locator(".plane-legend li")
    expect(legend.filter(has_text="torus")).to_have_count(1)
    told = pointed(plane, 0.5, 0.1)
    expect(told).to_contain_text("motion from the start: period 1")
    expect(told).to_contain_text("f = 12.5")
    page.get_by_role("button", name="Stop simulating").click()
    expect(regimes).to_contain_text("Stopped.")
    # What is of other values is not shown.
    plane.type("Vd", 0.55)
    expect(legend.filter(has_text="torus")).to_have_count(0)
    expect(regimes).to_have_attribute("data-cells", "")
    expect(pointed(plane, 0.5, 0.1)).not_to_contain_text("motion from")
