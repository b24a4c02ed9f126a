"""A simulation is drawn on the diagram while it is computed."""

import re
from urllib.parse import urlencode

from playwright.sync_api import expect

from helpers.explorer_page import DIAGRAM

SETTLED = re.compile("^Settled")

LONG_TASKS = """
() => {
  window.busy = 0;
  new PerformanceObserver((list) => {
    for (const { duration } of list.getEntries()) busy = Math.max(busy, duration);
  }).observe({ entryTypes: ["longtask"] });
}
"""


def dots(explorer):
    """Where on the screen the dots in the diagram are, one a period."""
    box = explorer.page.locator(DIAGRAM).bounding_box()
    paths = explorer.page.locator(".motion-layer .simulated").all()
    text = "".join(path.get_attribute("d") or "" for path in paths)
    places = [map(float, place) for place in re.findall(r"M([\d.]+) ([\d.]+)h0", text)]
    return [(box["x"] + x, box["y"] + y) for x, y in places]


def test_from_rest_it_settles_on_the_stable_branch(explorer):
    explorer.open("model=sliding&p.Nd=0.02")
    explorer.orbit_shown(1)
    before = explorer.drawn
    explorer.page.get_by_role("button", name="From rest").click()
    expect(explorer.page.locator(".verdict")).to_have_text(SETTLED)
    places = dots(explorer)
    drawn = explorer.page.locator("#plot-settling .dot:not(.other)").get_attribute("d")
    assert drawn.count("h0") == len(places) > 100
    chosen = explorer.page.locator(f"{DIAGRAM} .place.chosen").bounding_box()
    middle = chosen["x"] + chosen["width"] / 2, chosen["y"] + chosen["height"] / 2
    assert {abs(x - middle[0]) < 1 for x, _ in places} == {True}
    assert abs(places[-1][1] - middle[1]) < 3
    assert abs(min(y for _, y in places[:5]) - middle[1]) > 10
    assert explorer.drawn == before
    with explorer.redrawn():
        explorer.page.get_by_role("button", name="Follow this motion").click()
    explorer.page.wait_for_url("**also=at%3D0.02%26period%3D1%26s.x**")


def test_what_has_not_settled_goes_on_from_where_it_is(explorer):
    explorer.open("model=sliding&p.Nd=0.06")
    page = explorer.page
    page.get_by_role("button", name="From rest").click()
    expect(page.locator(".verdict")).to_contain_text("after 600 forcing periods")
    periods = page.get_by_label("Periods to go on for")
    expect(periods).to_have_value("6000")  # the sentence says so
    periods.fill("0")
    page.get_by_role("button", name="Go on").click()
    assert page.evaluate("document.activeElement.validationMessage") != ""
    periods.fill("40")
    periods.press("Enter")
    expect(page.locator(".verdict")).to_contain_text("after 40 forcing periods")
    drawn = page.locator("#plot-settling .dot:not(.other)")
    assert drawn.get_attribute("d").count("h0") == 640
    page.get_by_role("button", name="Clear").click()
    expect(page.get_by_role("button", name="Go on")).to_be_hidden()


def test_what_still_settles_goes_on_for_as_long_as_its_sentence_says(explorer):
    page = explorer.open("model=duffing&p.W=1.2&p.d=0.01&span=1.1~1.3").page
    page.get_by_role("button", name="From rest").click()
    verdict = page.locator(".verdict")
    expect(verdict).to_contain_text("more periods are needed")
    more = re.search(r"about (\d+) more periods", verdict.inner_text())[1]
    expect(page.get_by_label("Periods to go on for")).to_have_value(more)


def test_a_long_motion_never_holds_the_page_up(explorer):
    page = explorer.open("model=duffing&p.W=1.2&span=1.1~1.3").page
    explorer.orbit_shown(1)
    page.evaluate(LONG_TASKS)
    page.get_by_role("button", name="From rest").click()
    page.get_by_label("Periods to go on for").fill("20000")
    page.get_by_role("button", name="Go on").click()
    expect(page.locator(".verdict")).to_contain_text("response of 1")
    expect(page.locator(".motion")).to_have_attribute("data-drawn", re.compile("20000"))
    # A millisecond a dot, as when each is an element of its own, would be seconds.
    assert page.evaluate("busy") < 500


def test_views_of_a_torus_follow_what_is_chosen(explorer):
    page = explorer.open("model=sliding&p.Nd=0.06").page
    motion = page.locator(".motion")
    page.get_by_role("button", name="From rest").click()
    expect(page.locator("#plot-motion-section svg")).to_have_attribute(
        "aria-label", re.compile("at phase zero of the forcing, 300 points")
    )
    assert page.locator("#plot-motion-section .dot").get_attribute("d").count("h0") == 300
    expect(page.locator("#plot-motion-spectrum .note")).to_have_text(["f", "f/2", "2f"])
    before = motion.get_attribute("data-drawn")
    motion.get_by_label("of output").select_option("N")
    expect(motion).not_to_have_attribute("data-drawn", before)
    expect(page.locator("#plot-motion-time .title").last).to_have_text("N (N)")
    expect(page.locator("#plot-motion-portrait .title").first).to_have_text("N (N)")
    motion.get_by_label("spectrum in").select_option("reference")
    expect(page.locator("#plot-motion-spectrum .title").last).to_have_text("N (dB re 1 µN)")
    motion.get_by_label("View").select_option("spectrum")
    expect(page.locator(".motion .small:visible")).to_have_count(1)
    page.get_by_role("button", name="Clear").click()
    expect(motion).to_be_hidden()


def test_the_usual_window_has_words_before_its_number_is_known(new_tab):
    views = new_tab.holding(lambda answer: answer["kind"] == "motion")
    views.is_on = True
    page = new_tab.open("model=sliding&p.Nd=0.3").page
    page.get_by_role("button", name="From rest").click()
    usual = page.get_by_label("in the last").locator("option").first
    expect(usual).to_have_text("usual number of periods")
    views.let_go()
    expect(usual).to_have_text("32 periods")


PID = """
[parameters]
k = { value = 0.1, unit = "N" }
[states]
i = { rate = "x" }
x = { rate = "v" }
v = { rate = "-k*i - x - 0.4*v + 0.1*cos(t)" }
[forcing]
period = "2*pi"
[outputs]
load = { formula = "k", unit = "N" }
"""


def test_a_displacement_over_a_constant_and_beside_its_integral_is_drawn(explorer):
    page = explorer.open(urlencode({"model": "own", "text": PID})).page
    expect(page.locator("#plot-time .line")).to_have_count(2)
    page.get_by_role("button", name="From rest").click()
    motion = page.locator(".motion")
    motion.get_by_label("of output").select_option("load")
    expect(page.locator("#plot-motion-spectrum .note")).to_have_text(["It is constant."])
    motion.get_by_label("against").select_option("x")
    expect(page.locator("#plot-motion-portrait .line")).to_have_count(1)
    expect(page.locator("#plot-motion-section svg")).to_have_attribute(
        "aria-label", re.compile(r"at phase zero of the forcing, \d+ points")
    )


def test_a_sweep_is_drawn_as_it_comes_and_stays_when_it_is_stopped(explorer):
    page = explorer.open("model=duffing&span=0.8~1.4").page
    page.get_by_role("button", name="Sweep up and down").click()
    up = page.locator(".motion-layer .up")
    # Within the page: a sweep may end before a click from outside arrives.
    page.wait_for_function(
        """() => {
            if (!(document.querySelector(".motion-layer .up").dataset.count >= 10)) return false;
            const buttons = [...document.querySelectorAll(".sweep-control button")];
            buttons.find((button) => button.textContent === "Stop the sweep").click();
            return true;
        }"""
    )
    expect(page.locator(".sweep-control [role=status]")).to_have_text("Stopped.")
    count = int(up.get_attribute("data-count"))
    assert up.get_attribute("d").count("M") == count >= 10
    # From rest at the lower end: the first arrow points at its place on the curve.
    left, top = map(float, re.match(r"M([\d.]+) ([\d.]+)l", up.get_attribute("d")).groups())
    box = page.locator(DIAGRAM).bounding_box()
    x, y = explorer.traces()[0]["x"][0], explorer.traces()[0]["y"][0]
    at = explorer.pixel(x, y)
    assert abs(box["x"] + left + 3.2 - at[0]) < 3
    assert abs(box["y"] + top + 3.2 - at[1]) < 3
    page.get_by_role("button", name="Copy the sweep as Python").click()
    dialog = page.locator(".text-dialog")
    expect(dialog.locator("pre")).to_contain_text("sf.simulate(model, periods, motion, W=value)")
    dialog.get_by_role("button", name="Close").click()
    # The motion that is shown begins where it is: in the middle of the span.
    page.get_by_role("button", name="Sweep from this motion").click()
    page.wait_for_function("() => document.querySelector('.motion-layer .up').dataset.count >= 1")
    begun = re.match(r"M([\d.]+) ", up.get_attribute("d"))[1]
    assert abs(box["x"] + float(begun) + 3.2 - explorer.pixel(explorer.parameter("W"), 0)[0]) < 3
    explorer.type("F", 0.19)
    expect(up).to_have_attribute("data-count", "0")


def test_from_an_orbit_nudged_off_it_and_cleared(explorer):
    explorer.open("model=sliding&p.Nd=0.02")
    explorer.orbit_shown(1)
    page = explorer.page
    page.get_by_label("Perturbation").select_option("10 %")
    page.get_by_role("button", name="From this orbit").click()
    expect(page.locator(".verdict")).to_have_text(SETTLED)
    page.get_by_role("button", name="Clear").click()
    expect(page.locator("#plot-settling")).to_be_hidden()
    expect(page.locator(".verdict")).to_be_empty()
