"""Measurements of a file lie on the diagram of what was measured, and leave with it."""

import pytest
from playwright.sync_api import expect

from helpers.explorer_page import DIAGRAM

TEXT = (
    "Nd [mN],max y,error of max y,max x,sweep\n"
    "10,0.1,0.01,0.05,up\n20,0.15,,0.06,up\n20,0.14,0.01,,down\n"
)

DRAWN = (
    "(selector) => Object.fromEntries(document.querySelector(selector).data"
    ".filter(({ name }) => name?.startsWith('measured'))"
    ".map(({ name, x, y, error_y }) => [name, [x, y, error_y.array]]))"
)


@pytest.fixture
def take(explorer):
    explorer.open("model=sliding&show=y&span=0~0.04&p.Nd=0.01")

    def take(text, name="rig.csv"):
        file = {"name": name, "mimeType": "text/csv", "buffer": text.encode()}
        explorer.page.get_by_label("File of measurements").set_input_files(file)

    yield take
    for button in explorer.page.get_by_label("Remove rig.csv").all():
        button.click()


def drawn(explorer):
    explorer.page.wait_for_selector(f"{DIAGRAM}[aria-busy=false]")
    return explorer.page.evaluate(DRAWN, f"{DIAGRAM} .plot-canvas")


def test_measurements_are_drawn_each_way_with_their_errors_until_they_are_removed(explorer, take):
    assert drawn(explorer) == {}
    take(TEXT)
    expect(explorer.page.locator(".file-name")).to_have_text("rig.csv")
    traces = drawn(explorer)
    assert traces["measured, upward"] == [[0.01, 0.02], [0.1, 0.15], [0.01, 0]]
    assert traces["measured, downward"] == [[0.02], [0.14], [0.01]]
    assert traces["measured"] == [[], [], []]
    # The axis has room for the largest, which the response at these values is not.
    assert explorer.ranges()[3] > 0.15
    assert explorer.page.locator(f"{DIAGRAM} .errorbar").count() == 3
    explorer.page.get_by_label("Remove rig.csv").click()
    expect(explorer.page.locator(".file-name")).to_have_count(0)
    assert drawn(explorer) == {}


def test_what_cannot_be_read_is_said_and_what_was_read_before_stays(explorer, take):
    take(TEXT)
    expect(explorer.page.locator(".file-name")).to_have_text("rig.csv")
    take(TEXT.replace("max y", "max y [mm]"), "other.csv")
    alert = explorer.page.get_by_role("alert")
    expect(alert).to_contain_text("the head 'max y [mm]' has the unit 'mm'; write max y [1]")
    explorer.faults.clear()  # browsers note a refused request
    assert len(drawn(explorer)["measured, upward"][0]) == 2
    take(TEXT + 4000 * "20,0.14,0.01,,down\n", "long.csv")
    expect(alert).to_contain_text("long.csv is larger than 64 kB; leave out lines")
    take(TEXT)
    expect(alert).to_have_count(0)


def test_measurements_leave_with_the_diagram(explorer, take):
    take(TEXT)
    expect(explorer.page.locator(".file-name")).to_have_text("rig.csv")
    menu = explorer.page.locator("#diagram .menu")
    explorer.page.get_by_label("Export the diagram").first.click()
    menu.get_by_text("Copy as Python").click()
    expect(explorer.page.locator("dialog pre")).to_contain_text(
        "measured = sf.read_measurement('rig.csv', model)"
    )
    explorer.page.get_by_role("button", name="Close").click()
    explorer.page.get_by_label("Export the diagram").first.click()
    with explorer.page.expect_download() as waiting:
        menu.get_by_text("Picture, SVG").click()
    assert "measured, upward" in waiting.value.path().read_text()
