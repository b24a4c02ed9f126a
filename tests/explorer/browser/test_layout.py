"""Nothing moves where a reader looks, points or types: what is aimed at is what is hit."""

import pytest
from playwright.sync_api import expect

from helpers.explorer_page import DIAGRAM, ExplorerPage

CONTROLS = "button, input, select, summary, label, h2, p, figure, .plot, .small-plot, .unit"

PLACES = """
(selector) => {
  const [down, right] = [scrollY, scrollX];
  const named = (node) =>
    node.id || node.getAttribute("aria-label") || node.textContent.slice(0, 30);
  return [...document.querySelectorAll(selector)]
    .filter((node) => !node.closest(".tip, .unseen"))
    .map((node) => [node, node.getBoundingClientRect()])
    .map(([node, { x, y, width, height }]) =>
      [node.tagName, named(node), x + right, y + down, width, height]);
}
"""

FOCUS = f"""
(selector) => {{
  const places = {PLACES};
  const rest = places(selector);
  const moved = [];
  for (const node of document.querySelectorAll("button, input, select, summary, [tabindex='0']")) {{
    node.focus({{ preventScroll: true }});
    if (document.activeElement !== node) continue;
    const now = places(selector);
    const first = now.findIndex((place, i) => String(place.slice(2)) !== String(rest[i].slice(2)));
    if (first >= 0) moved.push([node.outerHTML.slice(0, 80), rest[first], now[first]]);
  }}
  document.activeElement.blur();
  return moved;
}}
"""


def places(explorer, selector=CONTROLS):
    """Where every control and heading is, without its text: the pictures' titles may change."""
    found = explorer.page.evaluate(PLACES, selector)
    return [(tag, *numbers) for tag, _, *numbers in found]


@pytest.fixture(scope="module")
def still(context, address):
    """A page that shows all its panels and computes nothing more."""
    explorer = ExplorerPage(context.new_page(), address)
    explorer.page.set_viewport_size({"width": 1280, "height": 1700})
    explorer.open("model=sliding&p.Nd=0.3", plane=True)
    explorer.page.get_by_role("button", name="Stop", exact=True).click()
    explorer.orbit_shown(2)
    yield explorer
    explorer.page.close()
    assert explorer.faults == []


def test_focus_moves_nothing(still):
    assert still.page.evaluate(FOCUS, CONTROLS) == []


def test_pointing_moves_nothing(still):
    rest = places(still)
    controls = still.page.locator("button, input, select, summary").all()
    boxes = [box for box in (control.bounding_box() for control in controls) if box]
    assert len(boxes) > 60
    for box in boxes:
        still.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        assert places(still) == rest
    # Orbits on both branches are shown for as long as the pointer is on them.
    for x, y, period in [(0.025, 0.1318, 1), (0.6, 0.4278, 2), (0.3, 0.2555, 1)]:
        still.page.mouse.move(*still.pixel(x, y))
        still.orbit_shown(period)
        expect(still.page.locator(f"{DIAGRAM} .tip")).to_be_visible()
        assert places(still) == rest
    still.page.mouse.move(5, 5)
    still.orbit_shown(2)
    assert places(still) == rest


def test_what_is_pointed_at_is_explained(still):
    meaning = still.page.locator(".meaning")
    still.box("f1").focus()
    expect(meaning).to_contain_text("f₁: ")
    still.slider("Ns").hover()
    expect(meaning).to_contain_text("Ns: static normal force")
    still.page.mouse.move(5, 5)
    expect(meaning).to_contain_text("f₁: ")
    still.box("f1").blur()
    expect(meaning).to_be_empty()


def test_what_is_typed_lands_where_it_was_aimed_at(still):
    """The second click is on the lower half of a row below the first one."""
    still.box("f1").click()
    place = still.box("Ns").bounding_box()
    still.page.mouse.dblclick(place["x"] + place["width"] / 2, place["y"] + 0.8 * place["height"])
    with still.redrawn():
        still.page.keyboard.type("0.3")
        still.page.keyboard.press("Enter")
    assert still.parameter("Ns") == 0.3
    assert still.parameter("mu") == 0.5
