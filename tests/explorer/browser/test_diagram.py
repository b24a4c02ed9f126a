"""The diagram follows what is set, marks what is found, and can be compared and undone."""

import re

import numpy as np
import pytest
from playwright.sync_api import expect

from helpers.dry_friction import FORCED_SLIDER
from helpers.explorer_page import DIAGRAM, ExplorerPage, served

BASE = [
    "PD 0.04358\u202fN supercritical",
    "NS 0.05669\u202fN subcritical",
    "NS 0.1664\u202fN supercritical",
]


def test_the_base_case_with_its_points_and_its_end(explorer):
    explorer.open()
    assert explorer.specials() == BASE
    expect(explorer.page.locator(".ends")).to_contain_text("Period 1 ends at 0.3759\u202fN: spring")
    expect(explorer.page.locator(".specials .checked")).to_have_text(
        re.compile(r"^Checked: (\d+) of \1 agree to 1e-(09|1\d)\.$")
    )
    dashes = {trace["name"].removeprefix("current, "): trace["dash"] for trace in explorer.traces()}
    assert set(dashes) == {"stable", "period doubling", "fold or torus"}
    assert dashes["stable"] == "solid"
    assert len(set(dashes.values())) == 3
    shown = explorer.page.locator(f"{DIAGRAM} text").all_text_contents()
    # The whole name of a point stands where it crosses no line.
    assert {"PD super", "NS", "NS super", "spring collapsed"} <= {text.strip() for text in shown}


def test_the_curve_follows_a_slider_that_is_not_let_go(new_tab):
    explorer = new_tab.open()
    sight = explorer.ranges()
    before = explorer.traces()
    with explorer.redrawn():
        explorer.slide("Vd", 0.7)
    assert explorer.traces() != before
    assert explorer.specials()[0].startswith("PD 0.040")
    # The axes stand still, nothing is to be undone, and the address waits.
    assert explorer.ranges() == sight
    expect(explorer.page.get_by_label("Undo (Ctrl+Z)")).to_be_disabled()
    assert "Vd" not in explorer.page.url
    explorer.release("Vd")
    expect(explorer.page.get_by_label("Undo (Ctrl+Z)")).to_be_enabled()
    explorer.page.wait_for_url("**p.Vd=0.7*")


def test_what_is_drawn_while_a_slider_moves_lies_where_plotly_draws_it(explorer):
    explorer.open()
    with explorer.redrawn():
        explorer.slide("Vd", 0.66)
    live, plotted = explorer.page.evaluate(
        "(layers) => layers.map((names) => names.map((name) => [...document.querySelectorAll(name)]"
        ".map((node) => node.getBoundingClientRect()).filter(({ width }) => width > 0)"
        ".map(({ left, top, width, height }) => [left, top, left + width, top + height])))",
        [
            [f"{DIAGRAM} .live {name}" for name in ("clipPath + g path", "g + g path", "text")],
            [f"{DIAGRAM} .scatterlayer {name}" for name in (".js-line", ".points path", "text")],
        ],
    )
    for ours, theirs in zip(live, plotted, strict=True):
        boxes = [np.array(boxes).T for boxes in (ours, theirs)]  # plotly draws each piece of a line
        edges = [(*box[:2].min(axis=1), *box[2:].max(axis=1)) for box in boxes]
        assert edges[0] == pytest.approx(edges[1], abs=1.5)  # pixels: markers are a little smaller
    explorer.release("Vd")


def test_a_moved_curve_is_no_draft_and_more_is_to_come(new_tab):
    # Whether one is moved depends on the worker: one is made of the answer.
    whole = new_tab.holding(
        lambda answer: answer["kind"] == "diagram" and answer["done"],
        lambda answer: {**answer, "moved": True, "more": True, "done": False},
    )
    explorer = new_tab.open()
    plot, waiting = explorer.page.locator(DIAGRAM), explorer.page.locator(f"{DIAGRAM} .waiting")
    whole.is_on = True
    explorer.slide("Vd", 0.66)
    expect(explorer.page.locator(".specials .chip").first).not_to_have_text(BASE[0])
    while not whole.waiting:  # until then a response that is not moved may be shown
        explorer.page.wait_for_timeout(20)
    expect(waiting).to_contain_text("Computing the rest of the response")
    expect(waiting).to_be_visible()
    assert explorer.strengths("current") == {1}
    expect(plot).to_have_attribute("aria-busy", "true")
    whole.let_go()
    expect(plot).to_have_attribute("aria-busy", "false")
    assert explorer.strengths("current") == {1}
    # Where the rest fails the curve is as exact as before.
    whole.is_on = True
    explorer.slide("Vd", 0.7)
    while not whole.waiting:
        explorer.page.wait_for_timeout(20)
    expect(waiting).to_contain_text("Computing the rest of the response")
    *_, asked = (request for request in whole.asked if request["kind"] == "diagram")
    whole.say({**asked, "done": True, "error": "the rest took long"})
    expect(explorer.page.get_by_role("alert")).to_contain_text("the rest took long")
    expect(plot).to_have_attribute("aria-busy", "false")
    assert "refused" not in plot.get_attribute("class")
    assert explorer.strengths("current") == {1}


def test_the_whole_response_is_requested_once_and_from_the_last_move_on(own_tab):
    answers = own_tab.holding(
        lambda answer: answer["kind"] == "diagram" and answer["done"] and len(answers.waiting) < 3,
        lambda answer: {**answer, "moved": True, "more": True},
    )
    page = own_tab.page
    page.clock.install()
    own_tab.open()
    page.clock.pause_at(page.evaluate("Date.now()") + 3_600_000)
    answers.is_on = True
    answers.asked.clear()
    for count, value in enumerate((0.66, 0.7, 0.66), start=1):
        own_tab.slide("Vd", value)
        if count == 3:
            page.clock.run_for(100)  # the slider rests before this answer comes
        while len(answers.waiting) < count:
            page.wait_for_timeout(20)
    page.clock.resume()
    expect(page.locator(DIAGRAM)).to_have_attribute("aria-busy", "false")
    rests = [request["rests"] for request in answers.asked if "rests" in request]
    assert rests == [False, False, False, True]


def test_a_curve_that_plotly_drew_late_does_not_hide_a_newer_one(new_tab):
    plot = new_tab.open().page.locator(DIAGRAM)
    plot.evaluate(
        "() => { const { react } = Plotly; window.held = []; Plotly.react = (...given) =>"
        " react(...given).then(() => new Promise((go) => held.push(go))); }"
    )
    for count, value in enumerate((0.66, 0.7), start=1):
        new_tab.slide("Vd", value)
        new_tab.page.wait_for_function("(count) => window.held.length >= count", arg=count)
    plot.evaluate("() => held.shift()()")
    assert "moving" in plot.get_attribute("class")


def test_what_does_not_agree_is_red(new_tab):
    def doubted(answer):
        return {
            **answer,
            "checked": {"sentence": "checked: 5 of 6 agree; PD differs", "agree": False},
        }

    answers = new_tab.holding(lambda answer: "branches" in answer and answer["done"], doubted)
    answers.is_on = True
    checked = new_tab.open().page.locator(".specials .checked")
    expect(checked).to_have_text("Checked: 5 of 6 agree; PD differs.")
    expect(checked).to_have_class("checked disagrees")
    answers.let_go()


def test_another_output_statistic_parameter_and_span(explorer):
    explorer.open()
    page = explorer.page
    with explorer.redrawn():
        page.get_by_label("of", exact=True).select_option("y")
    with explorer.redrawn():
        page.get_by_label("Draw").select_option("min")
    stable = next(trace for trace in explorer.traces() if trace["dash"] == "solid")
    assert stable["y"][0] == pytest.approx(0.061106649797)
    with explorer.redrawn():
        page.get_by_label("Vary", exact=True).select_option("f")
        page.get_by_label("Vary from").fill("12")
        page.get_by_label("Vary from").press("Enter")
    with explorer.redrawn():
        page.get_by_label("Vary to").fill("13")
        page.get_by_label("Vary to").press("Enter")
    assert min(x for x in explorer.traces()[0]["x"] if x is not None) >= 12
    assert explorer.ranges()[1] == pytest.approx(13, abs=0.1)


def test_max_and_min_and_how_an_equilibrium_is_damped(explorer):
    """Closed forms: the cycle is a circle of radius sqrt(r), the eigenvalues are r + i w."""
    page = explorer.open("model=stuart-landau&vary=r&span=-1~1&show=x&p.w=2&p.r=0.64").page
    draw, tip = page.get_by_label("Draw"), page.locator(f"{DIAGRAM} .tip")
    before = draw.input_value()
    with explorer.redrawn():
        draw.select_option("max_and_min")
    page.wait_for_url("**of=max_and_min*")
    lines = [trace for trace in explorer.traces() if trace["dash"] == "solid"]
    ends = [y for line in lines for x, y in zip(line["x"], line["y"], strict=True) if x == 1]
    assert sorted(ends) == pytest.approx([-1, 1], abs=1e-6)
    assert explorer.specials() == ["HB 0\u202f1/s supercritical"]
    page.mouse.move(*explorer.pixel(0.64, -0.8))
    expect(tip).to_contain_text("min x = −0.8")
    page.mouse.move(*explorer.pixel(-0.5, 0))
    expect(tip).to_contain_text("equilibrium, stable\n0.3183\u202fHz, damping ratio 24.")
    with explorer.redrawn():
        page.get_by_label("Undo (Ctrl+Z)").click()
    expect(draw).to_have_value(before)


def test_pinned_curves_stay_and_have_names(explorer):
    explorer.open()
    page = explorer.page
    page.get_by_role("button", name="Pin this curve").click()
    with explorer.redrawn():
        explorer.type("Vd", 0.4)
    page.get_by_role("button", name="Pin this curve").click()
    names = page.get_by_label("Name of the pinned curve")
    assert [names.nth(i).input_value() for i in range(2)] == ["base case", "Vd = 0.4\u202fm/s"]
    names.first.fill("as published")
    names.first.press("Enter")
    with explorer.redrawn():
        explorer.type("Vd", 1)
    page.wait_for_function(
        "([selector, names]) => names.every((wanted) => document.querySelector(selector).data"
        ".some(({ name, x }) => name === wanted && x.length > 0))",
        arg=[
            f"{DIAGRAM} .plot-canvas",
            ["as published, stable", "Vd = 0.4\u202fm/s, stable", "current, stable"],
        ],
    )
    page.get_by_label("Remove as published").click()
    expect(names).to_have_count(1)


def test_undo_and_redo(explorer):
    explorer.open()
    with explorer.redrawn():
        explorer.type("f", 12.2)
    changed = explorer.specials()
    with explorer.redrawn():
        explorer.page.locator("body").click(position={"x": 2, "y": 2})
        explorer.page.keyboard.press("Control+z")
    assert explorer.specials() == BASE
    assert explorer.parameter("f") == 12.5
    with explorer.redrawn():
        explorer.page.get_by_label("Redo (Ctrl+Shift+Z)").click()
    assert explorer.specials() == changed


def test_a_part_of_the_diagram_and_the_whole_again(explorer):
    explorer.open()
    whole = explorer.ranges()
    start, end = explorer.pixel(0.02, 0.1), explorer.pixel(0.2, 0.3)
    mouse = explorer.page.mouse
    mouse.move(*start)
    mouse.down()
    mouse.move(*end, steps=4)
    mouse.up()
    back = explorer.page.get_by_role("button", name="Whole diagram")
    expect(back).to_be_visible()
    assert explorer.ranges() == pytest.approx([0.02, 0.2, 0.1, 0.3], abs=0.01)
    back.click()
    expect(back).to_be_hidden()
    explorer.page.wait_for_function(
        "([selector, end]) => document.querySelector(selector).layout.xaxis.range[1] === end",
        arg=[f"{DIAGRAM} .plot-canvas", whole[1]],
    )


def test_markup_in_a_model_is_shown_as_text(explorer):
    explorer.open("model=hostile")
    choice = explorer.page.get_by_role("combobox", name="Model", exact=True)
    expect(choice).to_contain_text("<img src=x onerror=alert(1)>")
    expect(explorer.page.locator("[data-name=F] .doc")).to_have_text("<script>alert(2)</script>")
    assert explorer.page.locator("main img, main script, aside b").count() == 0
    assert "<u>q</u>" in "".join(explorer.page.locator(f"{DIAGRAM} text").all_text_contents())


def test_the_orbit_that_is_looked_at_stays_along_another_parameter(explorer):
    explorer.open("model=sliding&p.f=12.2&p.Nd=0.15")
    explorer.orbit_shown(2)
    expect(explorer.page.locator("#orbit-title")).to_contain_text("period 2, stable")
    with explorer.redrawn():
        explorer.page.get_by_label("Vary", exact=True).select_option("mu")
    explorer.page.wait_for_url("**also=at**")
    expect(explorer.page.locator("#orbit-title")).to_contain_text("μ = 0.5: period 2, stable")


@pytest.mark.long
def test_a_motion_that_settled_is_followed(context, tmp_path):
    case = tmp_path / "slider.toml"
    case.write_text(FORCED_SLIDER)
    with served(case, workers=1) as address:
        explorer = ExplorerPage(context.new_page(), address).open("model=forced slider&p.F=1.1")
        page = explorer.page
        expect(page.locator(".ends")).to_contain_text(
            re.compile("touches Vrel = 0.*; no orbit was found beyond.")
        )
        expect(page.locator(".ends")).not_to_contain_text("--")
        # What motions settle on is there by itself, and its orbits have pictures.
        expect(page.locator("#orbit-title")).to_contain_text("F = 1.1: period 1, stable")
        page.get_by_role("button", name="From rest").click()
        page.get_by_role("button", name="Follow this motion").click()
        page.wait_for_url("**also=at%3D1.1%26period%3D1%26s.x**")
        page.reload()  # the link has it
        expect(page.locator(DIAGRAM)).to_have_attribute("aria-busy", "false")
        expect(page.get_by_role("alert")).to_have_count(0)
        expect(page.locator("#orbit-title")).to_contain_text("F = 1.1: period 1, stable")
        # Between 0.29 and 0.42 there is a gap that no middle of a gap fills.
        explorer.open("model=forced slider&vary=Vd&span=0.001~2&p.W=0.6")
        way = page.get_by_role("button", name="Follow what motions settle on at 0.323")
        way.click()
        page.wait_for_url("**also=at%3D0.323**")
        page.get_by_label("Undo (Ctrl+Z)").click()
        expect(page).not_to_have_url(re.compile("also="))
        expect(page.locator(DIAGRAM)).to_have_attribute("aria-busy", "false")
        page.close()
        assert explorer.faults == []


def test_a_response_is_offered_where_there_is_none_and_a_bifurcation_where_nothing_bifurcates(
    new_tab,
):
    offer = {"vary": "W", "span": [0.5, 2], "type": None, "value": 1.2544}

    def without_response(answer):
        said = offer if answer["kind"] == "screen" else {"error": "the contact sticks for good"}
        return {"id": answer["id"], "kind": answer["kind"], "done": True, **said}

    # Whatever is answered: a response that is only to be completed would stay.
    answers = new_tab.holding(
        lambda answer: answer["kind"] in ("diagram", "screen"), without_response
    )
    answers.is_on = True
    page = new_tab.page
    page.goto(f"{new_tab.address}#model=duffing&vary=d&span=0.04~0.06&plane=none")
    expect(page.get_by_text("there is a response")).to_contain_text("as at 1.254")
    page.get_by_role("button", name="Show", exact=True).click()
    page.wait_for_url("**p.W=1.254*")  # not rounded away
    offer["type"], new_tab.is_loaded = "LP", True
    answers.matches = lambda answer: answer["kind"] == "screen"
    new_tab.open("model=duffing&vary=d&span=0.04~0.06")
    expect(page.get_by_text("the response has a bifurcation")).to_contain_text("(LP at 1.254")
    with new_tab.redrawn():
        page.get_by_role("button", name="Show", exact=True).click()
    assert new_tab.specials()[0].startswith("LP")
