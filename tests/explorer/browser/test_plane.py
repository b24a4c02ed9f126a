"""The plane beside the diagram: what is dragged in it is followed by diagram and orbit."""

import re
from itertools import combinations_with_replacement

import pytest
from playwright.sync_api import expect

from helpers.explorer_page import PLANE, ExplorerPage, violations
from slipfold.plots.regions import OTHERS, PALE, region_color

WINDOW = "model=sliding&p.f=12.32&p.Nd=0.08&plane=f~12.3~12.5~Nd~0~0.15"
"""Two responses are stable in a part of it: many seconds to compute."""

QUIET = "model=duffing&p.W=1.4&p.F=0.25&plane=W~1.3~1.5~F~0.2~0.3"
"""Nothing happens there: a second to compute."""


@pytest.fixture(scope="module")
def watched(context, address):
    """A tab with a plane, and what was drawn in it before its regions came."""
    explorer = ExplorerPage(context.new_page(), address)
    last = explorer.holding(lambda answer: answer["kind"] == "plane" and answer["done"])
    last.is_on = True
    explorer.open(WINDOW, plane=True)
    expect(legend(explorer).filter(has_text="PD of period 1")).to_have_count(1)
    early = drawn(explorer)
    last.let_go()
    explorer.page.wait_for_function(
        "(selector) => Number(document.querySelector(selector).dataset.loci) > 0", arg=PLANE
    )
    yield explorer, early
    explorer.page.close()
    assert explorer.faults == []


@pytest.fixture
def plane(watched):
    return watched[0]


def drawn(explorer):
    return explorer.page.evaluate(
        "(selector) => document.querySelector(selector).data.map(({ type, name }) => name ?? type)",
        f"{PLANE} .plot-canvas",
    )


def region_names(explorer):
    return explorer.page.locator(f"{PLANE} .annotation-text")


def test_loci_and_regions_and_the_working_point_dragged(plane):
    traces = drawn(plane)
    assert "heatmap" in traces
    assert "PD of period 1, supercritical" in traces
    assert any(str(name).startswith("NS of period 2") for name in traces)
    expect(region_names(plane).filter(has_text=re.compile("^period 1$"))).not_to_have_count(0)
    point = plane.page.locator(".working-point")
    box = point.bounding_box()
    mouse = plane.page.mouse
    mouse.move(box["x"] + 9, box["y"] + 9)
    mouse.down()
    with plane.redrawn():
        mouse.move(box["x"] + 60, box["y"] + 30, steps=3)
    assert plane.parameter("f") > 12.32
    assert plane.parameter("Nd") < 0.08
    expect(plane.page.get_by_label("Undo (Ctrl+Z)")).to_be_disabled()
    mouse.up()
    expect(plane.page.get_by_label("Undo (Ctrl+Z)")).to_be_enabled()
    # It moves by keys too, and it does not make the plane old.
    f = plane.parameter("f")
    plane.page.wait_for_url(re.compile(r"p\.f=12\.[0-9]{1,4}&"))
    with plane.redrawn():
        point.press("ArrowLeft")
    assert plane.parameter("f") == pytest.approx(f - 0.002, abs=1e-4)
    assert "stale" not in plane.page.locator(PLANE).get_attribute("class").split()


def legend(explorer):
    return explorer.page.get_by_label("Lines and areas of the plane").locator("li")


def point_of(explorer, kind):
    """Where in the plane a point of codimension two is on the screen."""
    x, y = explorer.page.evaluate(
        "([selector, kind]) => { const node = document.querySelector(selector);"
        " const { xaxis, yaxis, margin, width, height } = node.layout;"
        " const { x, y, text } = node.data.find(({ mode }) => mode === 'markers+text');"
        " const i = text.map((name) => name.trim()).indexOf(kind);"
        " const box = node.getBoundingClientRect();"
        " const share = (value, [low, high]) => (value - low) / (high - low);"
        " return [box.x + margin.l"
        "  + share(x[i], xaxis.range) * (width - margin.l - margin.r),"
        "  box.y + margin.t + (1 - share(y[i], yaxis.range)) * (height - margin.t - margin.b)]; }",
        [f"{PLANE} .plot-canvas", kind],
    )
    return x, y


def test_a_point_of_codimension_two_says_what_it_means_and_leads_to_both_sides(plane):
    page = plane.page
    page.evaluate("scrollTo(0, 0)")
    x, y = point_of(plane, "GPD")
    page.mouse.move(x, y)
    line = page.locator(".under-pointer")
    expect(line).to_contain_text("Generalized period doubling on the PD of period 1")
    page.mouse.click(x, y)
    card = page.get_by_role("dialog", name="Point of codimension two")
    expect(card).to_contain_text("Here the PD changes from supercritical to subcritical")
    box, around = card.bounding_box(), page.locator(PLANE).bounding_box()
    assert box["y"] >= around["y"]
    assert box["y"] + box["height"] <= around["y"] + around["height"]
    with plane.redrawn():
        card.get_by_role("button", name="f =").first.click()
    expect(page.get_by_label("Vary to")).to_have_value("0.15")
    assert plane.specials()[0].startswith("PD")
    assert plane.specials()[0].endswith("subcritical")  # below the point
    with plane.redrawn():
        card.get_by_role("button", name="f =").last.click()
    assert plane.specials()[0].endswith("supercritical")
    assert plane.parameter("f") < 12.46  # where the PD is lowest
    assert violations(page, ".point-card") == []  # last, since it skips what follows
    card.get_by_role("button", name="Close").click()


def test_a_motion_at_the_ring_is_described_beside_the_plane(plane):
    plane.page.get_by_role("button", name="Simulate at the ring").click()
    plane.page.mouse.move(5, 5)
    line = plane.page.locator(".under-pointer")
    expect(line).to_contain_text(re.compile("At the ring: .*settled"))
    plane.type("Nd", 5)  # beyond the plane there is no ring to speak of
    expect(line).to_have_text("")
    expect(plane.page.get_by_role("button", name="Simulate at the ring")).to_be_disabled()


def test_loci_are_drawn_before_regions_and_explained(watched):
    explorer, early = watched
    page, shown = explorer.page, legend(explorer)
    assert "heatmap" not in early
    expect(shown.filter(has_text="period 1 stable")).to_have_count(1)
    assert "heatmap" in drawn(explorer)
    page.get_by_label("Export the plane").first.click()
    with page.expect_download() as waiting:
        page.locator("#plane .menu").get_by_text("Picture, SVG").click()
    saved = waiting.value.path().read_text()
    assert [key for key in shown.all_inner_texts() if key not in saved] == []


def test_what_a_killed_worker_computed_is_asked_for_again(new_tab):
    def killed(answer):
        head = {name: answer[name] for name in ("kind", "id", "slot")}
        return {**head, "done": True, "error": "the worker was ended", "again": True}

    answers = new_tab.holding(lambda answer: answer["kind"] == "plane", killed)
    answers.is_on = True
    page = new_tab.open(QUIET, plane=True).page
    notice = page.get_by_role("alert")
    expect(notice).to_have_text("the worker was ended")
    page.get_by_label("Close this notice").click()
    expect(notice).to_have_count(0)
    compute = page.get_by_role("button", name="Compute", exact=True)
    compute.click()
    expect(notice).to_have_count(1)
    answers.let_go()
    page.get_by_role("button", name="Ask again").click()
    expect(notice).to_have_count(0)
    expect(legend(new_tab).filter(has_text="period 1 stable")).to_have_count(1)


def test_the_tour_does_not_take_the_plane_of_another_model(explorer):
    page = explorer.open(QUIET, plane=True).page
    title = page.locator(f"{PLANE} .xtitle")
    expect(title).to_contain_text("Ω")
    page.get_by_role("button", name="Tour").click()
    expect(title).to_have_text("f (Hz)")
    page.get_by_role("button", name="Skip the tour").click()
    page.get_by_label("Undo (Ctrl+Z)").click()
    expect(title).to_contain_text("Ω")


@pytest.fixture
def plane_by_hand(new_tab):
    """A page whose plane has no answer yet; how to answer in its place, and how to end that."""
    heads = []

    def is_of_plane(answer):
        if answer["kind"] == "plane":
            heads.append({name: answer[name] for name in ("kind", "id", "slot")})
        return answer["kind"] == "plane"

    answers = new_tab.holding(is_of_plane)
    answers.is_on = True
    page = new_tab.open(QUIET, plane=True).page
    while not answers.waiting:
        page.wait_for_timeout(50)

    def answer(**given):
        answers.say({**heads[-1], "progress": "loci", "done": False, **given})

    return new_tab, answer, answers.let_go


def test_points_of_one_type_within_a_marker_are_one_with_their_number(plane_by_hand):
    explorer, answer, let_go = plane_by_hand
    special = [
        {"type": kind, "x": x, "y": y, "sentence": f"{kind} here", "meaning": ""}
        for kind, x, y in [("ZH", 1.38, 0.23), ("BT", 1.39, 0.24)]
        for y in (y, y + 1e-4, y - 1e-4)
    ]
    line = {"criticality": None, "x": [1.35, 1.4], "y": [0.22, 0.25]}
    hopf = {"type": "HB", "period": 1, "name": "HB", "segments": [line], "special": special}
    answer(lines=[], loci=[hopf])
    explorer.page.wait_for_function(
        "(selector) => document.querySelector(selector).data?.some(({ text }) => text?.length)",
        arg=f"{PLANE} .plot-canvas",
    )
    explorer.page.mouse.move(*point_of(explorer, "3 ZH"))
    expect(explorer.page.locator(".under-pointer")).to_have_text(
        "ZH here. 2 more ZH within this marker. Click it."
    )
    let_go()


@pytest.mark.long
def test_lines_under_way_stay_when_the_view_changes_elsewhere(plane_by_hand):
    explorer, answer, let_go = plane_by_hand
    page = explorer.page

    def lines_of(*numbers):
        given = {"type": "PD", "period": 1, "x": [1.35, 1.4], "y": [0.22, 0.25]}
        return [{**given, "number": number, "name": f"line {number}"} for number in numbers]

    answer(lines=lines_of(1, 2))
    mark = page.locator(f"{PLANE} .draft-mark")
    expect(mark).to_be_visible()
    with explorer.redrawn():
        page.get_by_label("Draw").select_option("min")
    answer(lines=lines_of(2, 3))
    page.wait_for_function(
        "(selector) => document.querySelector(selector).data.some(({ name }) => name === 'line 3')",
        arg=f"{PLANE} .plot-canvas",
    )
    assert {"line 1", "line 2", "line 3"} <= set(drawn(explorer))
    let_go()
    expect(mark).to_be_hidden()


def test_what_is_stopped_is_unfinished_and_is_put_away(new_tab):
    never_done = new_tab.holding(lambda answer: answer["kind"] == "plane" and answer["done"])
    never_done.is_on = True
    explorer = new_tab.open("model=sliding")
    switch = explorer.page.get_by_role("button", name="Plane", exact=True)
    expect(explorer.page.locator("#plane")).to_be_hidden()
    switch.click()
    expect(explorer.page.locator("#plane")).to_be_visible()
    expect(switch).to_have_attribute("aria-pressed", "true")
    expect(legend(explorer).first).to_be_visible()
    explorer.page.locator(".progress").get_by_role("button", name="Stop").click()
    message = "Stopped; the bifurcation set is unfinished."
    expect(explorer.page.locator(".progress [role=status]")).to_have_text(message)
    switch.click()
    expect(explorer.page.locator("#plane")).to_be_hidden()


SHADES = """async ([combinations, sticks]) => {
  const { regionColor } = await import("/page/plane_plot.js");
  const { colors } = await import("/page/theme.js");
  const color = colors();
  return combinations.map((stable) =>
    regionColor({ stable: [stable], sticks: [sticks] }, 0, color));
}"""


def test_each_combination_of_stable_responses_has_its_shade_as_in_figures(plane):
    page = plane.page
    combinations = [
        list(stable)
        for count in range(8)
        for stable in combinations_with_replacement((1, 2), count)
    ]
    combinations += [[4], [3], [1, 4], [1, 3], [2, 4], [1, 1, 4]]
    light = page.evaluate(SHADES, [combinations, False])
    stops = page.evaluate(SHADES, [combinations, True])
    assert len(set(light)) == len(combinations)
    assert not {*light} & {shade for shade in stops if shade.startswith("#")}
    known = {*PALE.values(), *OTHERS}
    for stable, shade in zip(combinations, light, strict=True):
        figure = region_color(tuple(stable))
        assert shade == figure if figure in known else shade.startswith("hsl(")
    page.evaluate("document.documentElement.dataset.theme = 'dark'")
    dark = page.evaluate(SHADES, [combinations, False])
    page.evaluate("document.documentElement.dataset.theme = 'light'")
    assert len({*dark, *light}) == 2 * len(combinations)
