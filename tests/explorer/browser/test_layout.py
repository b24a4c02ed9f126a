"""Nothing moves where a reader looks, points or types; axe-core finds nothing that bars anyone."""

import re
from urllib.parse import urlencode

import pytest
from playwright.sync_api import expect

from helpers.dry_friction import FORCED_SLIDER
from helpers.explorer_page import CONTROLS, DIAGRAM, ORBIT, PLACES, ExplorerPage, places, violations

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


STOPPED = """() => {
  const stop = [...document.querySelectorAll(".progress button")].find(
    ({ textContent }) => textContent === "Stop");
  const isDrawn = document.querySelector("[aria-label='Lines and areas of the plane'] li") !== null;
  if (isDrawn && stop.checkVisibility()) stop.click();
  return isDrawn && !stop.checkVisibility();
}"""
"""Stop a plane that shows something, unless it is complete."""


@pytest.fixture(scope="module")
def still(context, address):
    """A page that shows all its panels and computes nothing more."""
    explorer = ExplorerPage(context.new_page(), address)
    explorer.page.set_viewport_size({"width": 1280, "height": 1700})
    explorer.open("model=sliding&p.Nd=0.3", plane=True)
    explorer.page.wait_for_function(STOPPED)
    explorer.orbit_shown(2)
    yield explorer
    explorer.page.close()
    assert explorer.faults == []


def test_focus_moves_nothing(still):
    assert still.page.evaluate(FOCUS, CONTROLS) == []


@pytest.mark.long
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


SCREEN = """
() => ["#diagram .plot", "#orbit .stage", ".parameter:last-child", "#plane .plot", "#plot-time"]
  .map((selector) => document.querySelector(selector).getBoundingClientRect())
  .map(({ top, right, bottom }) => [top >= 0, right <= innerWidth, bottom <= innerHeight])
"""

APART = """
() => {
  const [plot, side, next] = ["#plane .plot", ".plane-side", "#simulation"]
    .map((selector) => document.querySelector(selector).getBoundingClientRect());
  return Math.max(plot.bottom, side.bottom) < next.top;
}
"""

ORDER = """
() => ["#diagram .plot", "#orbit .stage", "#parameters", "#plane", "#simulation", "#basins"]
  .map((selector) => document.querySelector(selector).getBoundingClientRect())
  .map(({ top, height }) => (height ? top : null))
"""


def test_a_laptop_shows_curves_mechanism_and_sliders_and_a_phone_stacks_them(still):
    rest = still.page.viewport_size
    still.page.set_viewport_size({"width": 1366, "height": 768})
    assert still.page.evaluate(SCREEN) == [[True] * 3] * 5
    still.page.set_viewport_size({"width": 1280, "height": 720})
    assert still.page.evaluate(APART)
    still.page.set_viewport_size({"width": 400, "height": 800})
    wide = still.page.evaluate("() => document.documentElement.scrollWidth - innerWidth")
    places = still.page.evaluate(ORDER)
    still.page.set_viewport_size(rest)
    assert wide <= 0
    assert places == [*sorted(places[:3]), None, None, None]


LABELS = """
async ([texts, lines]) => {
  const { labelPlaces } = await import("/page/plot_tools.js");
  return labelPlaces(texts, lines, { left: 0, top: 0, width: 400, height: 300 })
    .map(({ text }) => text);
}
"""


def labeled(text, *at):
    return {"text": text, "short": text.split()[0], "at": at}


def test_labels_of_one_place_become_one_and_labels_without_room_are_left_out(still):
    piled = [labeled("PD super", 50, 50 + i) for i in range(3)]
    mixed = [labeled("NS sub", 200, 50), labeled("PD super", 202, 51)]
    apart = [labeled("LP", 300, 200), labeled("LP", 330, 200)]
    twice = [labeled("BP", 300, 50 + i) | {"of": "max and min"} for i in range(2)]
    shown = still.page.evaluate(LABELS, [[*piled, *mixed, *apart, *twice], []])
    assert shown == ["3 PD", "", "", "NS, PD", "", "LP", "LP", "BP", ""]
    # A text stands beside the marker of several where there is room.
    pair = [labeled("PD", 100, 50), labeled("GRAZE", 107, 50)]
    walls = [[[0, y], [400, y]] for y in (38, 62)]
    assert still.page.evaluate(LABELS, [pair, walls]) == ["", "PD, GRAZE"]
    crowd = [labeled("Neimark", 100 + 12 * (i % 6), 100 + 12 * (i // 6)) for i in range(36)]
    shown = still.page.evaluate(LABELS, [crowd, []])
    assert 4 < sum(map(bool, shown)) < 36
    # Between two lines there is room for the short text only.
    lines = [[[x, 0], [x, 300]] for x in (30, 70)]
    assert still.page.evaluate(LABELS, [[labeled("NS super", 50, 150)], lines]) == ["NS"]
    assert still.page.evaluate(LABELS, [[labeled("NS super", 50, 150)], []]) == ["NS super"]


FILLS = """
async ([known, names]) => {
  const { markTrace } = await import("/page/diagram_data.js");
  const special = known.map((each, i) => ({ type: "HB", value: i, y: 0, arclength: i, ...each }));
  const branch = { id: 1, x: [0], y: [0], special, stopped: { kind: "span" } };
  const diagram = { x: { unit: "N" }, y: { unit: "m" }, branches: [branch] };
  const traceOf = (texts) => markTrace(diagram, "#000000", "#ffffff",
    texts.map((text) => ({ text, position: "top center" })));
  const node = document.body.appendChild(document.createElement("div"));
  const size = { width: 300, height: 200 };
  for (const texts of names) await Plotly.react(node, [traceOf(texts)], size);
  const drawn = [...node.querySelectorAll(".textpoint")].map((name) => name.textContent.trim());
  node.remove();
  return [traceOf(names[0]).marker.color, drawn];
}
"""


def test_a_marker_is_pale_where_it_is_not_known_whether_a_point_is_subcritical_and_named(still):
    kinds = {"supercritical": False, "subcritical": False, None: True}
    known = [{"criticality": kind, "undecided": is_it} for kind, is_it in kinds.items()]
    # A name that had no place, and has one after all, is drawn.
    names = [["HB super", "HB", ""], ["HB super", "", "HB"]]
    fills, drawn = still.page.evaluate(FILLS, [known, names])
    assert fills == ["#000000", "#ffffff", "#999999"]
    assert drawn == ["HB super", "", "HB"]


def test_a_presentation_has_large_type_and_no_controls(still):
    page = still.open().page
    size = "(selector) => document.querySelector(selector).layout.font.size"
    page.evaluate("document.activeElement.blur()")  # of a box it would be a letter
    page.keyboard.press("p")
    for hidden in (".masthead .tools", "#diagram .tools", "#diagram > .sentence", "#simulation"):
        expect(page.locator(hidden)).to_be_hidden()
    for shown in (DIAGRAM, "#orbit .stage", "#parameter-Nd-slider"):
        expect(page.locator(shown)).to_be_visible()
    page.wait_for_function(f"(selector) => ({size})(selector) > 19", arg=f"{DIAGRAM} .plot-canvas")
    assert page.locator(".specials").evaluate("(list) => list.scrollHeight <= list.clientHeight")
    still.box("Nd").press("p")
    expect(page.locator(".masthead .tools")).to_be_hidden()
    still.box("Nd").press("Escape")  # it restores the box first
    expect(page.locator(".masthead .tools")).to_be_hidden()
    still.box("Nd").press("Escape")
    expect(page.locator(".masthead .tools")).to_be_visible()
    expect(page.get_by_role("button", name="Present")).to_be_focused()


MOVED = """
() => {
  const boxes = new Map();
  window.moved = [];
  const look = () => {
    for (const node of document.querySelectorAll("main :is(.plot, .small-plot, .stage)")) {
      const before = boxes.get(node);
      boxes.delete(node);
      if (!node.checkVisibility({ visibilityProperty: true })) continue;
      const { x, y, width, height } = node.getBoundingClientRect();
      const box = [x + scrollX, y + scrollY, width, height].map(Math.round).join();
      boxes.set(node, box);
      if (before && before !== box) moved.push([node.parentNode.id || node.className, before, box]);
    }
    requestAnimationFrame(look);
  };
  look();
}
"""
"""Note at each frame which plots are no longer where they were."""


SLIDER = urlencode({"model": "own", "text": FORCED_SLIDER, "vary": "F", "span": "0.5~0.7"})
SMOOTH = "model=duffing&p.d=0.3&plane=W~1.3~1.5~F~0.2~0.3"


def press(page, name):
    page.get_by_role("button", name=name, exact=True).click()


@pytest.fixture(scope="module")
def computed(context, address, request):
    """A page on which everything was computed, and which plots moved on the way."""
    link, explorer = request.param, ExplorerPage(context.new_page(), address)
    page = explorer.page
    page.set_viewport_size({"width": 1366, "height": 768})
    page.add_init_script(f"addEventListener('DOMContentLoaded', {MOVED})")
    explorer.open(link, plane=link is not SLIDER)
    page.wait_for_selector(f"{ORBIT}[data-drawn][aria-busy=false]")
    press(page, "From rest")
    page.wait_for_selector(".motion[data-drawn]:not(.former-motion)")
    press(page, "Torus or chaos?")
    if link is SLIDER:
        page.wait_for_selector(".contacts[data-drawn]")
    else:
        press(page, "Compute the basins")
        page.wait_for_selector(".basins-plot[data-points]")
    expect(page.locator(".exponents strong")).to_be_visible()
    for again in ("Go on", "From this orbit", "Sweep up and down"):
        press(page, again)
        expect(page.locator(".former-motion")).to_have_count(0)
        expect(page.locator(".verdict")).to_have_text(re.compile("^Settled"))
    page.wait_for_selector(".sweep-control:not([data-state=none])")
    yield explorer
    page.close()
    assert explorer.faults == []


@pytest.mark.parametrize(
    "computed", [pytest.param(SLIDER, marks=pytest.mark.long), SMOOTH], indirect=True
)
def test_no_plot_moves_while_the_page_computes(computed):
    page = computed.page
    assert page.locator("main :is(.plot, .small-plot, .stage):visible").count() > 11
    assert page.evaluate("moved") == []


MEASURED = "W [rad/s],max q,sweep\n1.2,0.9,up\n1.4,0.7,down\n"


@pytest.mark.parametrize("computed", [SMOOTH], indirect=True)
def test_no_panel_has_a_violation_in_either_theme(computed):
    page = computed.page
    press(page, "Pin this curve")
    press(page, "Compute the regimes")
    file = {"name": "rig.csv", "mimeType": "text/csv", "buffer": MEASURED.encode()}
    page.get_by_label("File of measurements").set_input_files(file)
    page.wait_for_selector(".file-name")
    press(page, "Sweep up and down")
    page.wait_for_selector(".sweep-control[data-state=running]")
    computed.box("d").fill("1,5")
    page.get_by_label("Export the diagram").first.click()
    assert violations(page) == []
    page.get_by_text("Copy as Python").first.click()
    expect(page.locator("dialog[open]")).to_be_visible()
    assert violations(page, "dialog[open]") == []


STOPS = """
() => [...document.querySelectorAll("button, input, select, summary, a, [tabindex]")]
  .filter((node) => node.tabIndex >= 0 && !node.disabled)
  .filter((node) => node.checkVisibility({ visibilityProperty: true })).length
"""


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
