"""An orbit in all its pictures, at one moment."""

from urllib.parse import urlencode

import pytest
from playwright.sync_api import expect

from helpers.explorer_models import BRAKE
from helpers.explorer_page import DIAGRAM

PICTURES = ("time", "phase", "path", "spectrum", "multipliers", "forces")


def paths(explorer, picture):
    """The lines of a small plot as drawn."""
    return explorer.page.locator(f"#plot-{picture} .line").evaluate_all(
        "(lines) => lines.map((line) => line.getAttribute('d'))"
    )


def test_a_point_that_is_clicked_is_shown_in_every_picture(explorer):
    explorer.open("model=sliding&p.Nd=0.3")
    assert explorer.orbit_shown(2) == pytest.approx(0.3)
    before = {picture: paths(explorer, picture) for picture in ("time", "phase", "path", "forces")}
    explorer.page.mouse.click(*explorer.pixel(0.025, 0.1318))
    assert explorer.orbit_shown(1) == pytest.approx(0.025, abs=3e-3)
    assert explorer.parameter("Nd") == pytest.approx(0.025, abs=3e-3)
    for picture in PICTURES:
        expect(explorer.page.locator(f"#plot-{picture}")).to_be_visible()
    for picture, lines in before.items():
        assert paths(explorer, picture) != lines
    expect(explorer.page.locator("#plot-multipliers .dot.inside")).to_have_count(4)
    expect(explorer.page.locator("#plot-multipliers .dot.outside")).to_have_count(0)
    expect(explorer.page.locator("#orbit-title")).to_contain_text("period 1, stable")


def test_a_marker_is_the_special_point_that_it_marks(explorer):
    """Both branches pass through the period doubling's marker; it is an orbit of the first."""
    explorer.open("model=sliding&p.Nd=0.3")
    explorer.orbit_shown(2)
    place = explorer.pixel(*explorer.mark("PD super"))
    explorer.page.mouse.move(place[0] + 3, place[1] - 4)
    tip = explorer.page.locator(f"{DIAGRAM} .tip")
    expect(tip).to_contain_text("Supercritical period doubling of period 1 at Nd = 0.0435789 N")
    explorer.page.mouse.click(place[0] + 3, place[1] - 4)
    assert explorer.orbit_shown(1) == pytest.approx(0.0435789, abs=1e-7)
    title = explorer.page.locator("#orbit-title")
    expect(title).to_contain_text("period 1, supercritical period doubling; largest multiplier 1")


def test_keys_move_along_and_between_branches(explorer):
    explorer.open("model=sliding&p.Nd=0.3")
    explorer.orbit_shown(2)
    plot = explorer.page.locator(DIAGRAM)
    plot.focus()
    plot.press("ArrowDown")
    assert explorer.orbit_shown(1) == pytest.approx(0.3)
    expect(explorer.page.locator("#orbit-title")).to_contain_text("unstable")
    plot.press("ArrowLeft")
    expect(explorer.box("Nd")).to_have_value("0.295")
    plot.press("End")
    expect(explorer.page.locator("#orbit-title")).to_contain_text("0.98")


def test_one_moment_in_all_pictures(explorer):
    """Cursor, dots and mechanism are at the same phase; the pointer moves all of them."""
    explorer.open("model=sliding&p.Nd=0.3")
    explorer.orbit_shown(2)
    page = explorer.page
    tip = page.locator("#orbit .tip-group")
    rest = tip.get_attribute("transform")
    moment = page.get_by_label("Moment in the orbit")
    moment.evaluate("(input) => { input.value = 0.25; input.dispatchEvent(new Event('input')); }")
    moved = tip.get_attribute("transform")
    assert moved != rest
    # A quarter of an orbit of period 2 is half a forcing period: N is least there.
    expect(page.locator("#orbit .reading")).to_contain_text("N = 0.7\u202fN")
    box = page.locator("#plot-time .box").bounding_box()
    cursor = page.locator("#plot-time .across").bounding_box()
    assert cursor["x"] - box["x"] == pytest.approx(box["width"] / 4, abs=2)
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 10)
    expect(page.locator("#orbit .reading")).to_contain_text("N = 1.3\u202fN")
    assert tip.get_attribute("transform") != moved


def test_motion_plays_in_slow_motion_unless_less_motion_is_wished(explorer):
    explorer.open("model=duffing&p.W=1.2&span=1.1~1.3")
    explorer.orbit_shown(1)
    expect(explorer.page.locator("#orbit .player label")).to_have_text("fast motion")
    explorer.open("model=sliding&p.Nd=0.3")
    explorer.orbit_shown(2)
    page = explorer.page
    play = page.get_by_role("button", name="Play the motion")
    expect(play).to_be_visible()
    start = page.locator("#orbit .tip-group").get_attribute("transform")
    play.click()
    page.wait_for_function(
        "(start) => document.querySelector('.tip-group').getAttribute('transform') !== start",
        arg=start,
    )
    speed = page.locator("#orbit").get_by_label("Speed of the motion")
    factor = page.locator("#orbit .factor").inner_text()
    speed.press("ArrowRight")
    expect(page.locator("#orbit .factor")).not_to_have_text(factor)
    expect(page.locator("#orbit .player label")).to_have_text("slow motion")
    speed.press("Home")
    expect(page.locator("#orbit .player label")).to_have_text("fast motion")
    expect(page.locator("#orbit .factor")).to_have_text("32 : 1")
    page.get_by_role("button", name="Pause the motion").click()
    expect(play).to_be_visible()


CUT = """
() => {
  const title = document.querySelector("#orbit-title");
  const isCut = ({ scrollHeight, clientHeight }) => scrollHeight > clientHeight;
  return [title, title.parentElement].filter(isCut).map(({ textContent }) => textContent);
}
"""


def test_an_equilibrium_has_frequencies_and_damping_ratios_on_a_line_that_is_whole(explorer):
    page, rest = explorer.page, explorer.page.viewport_size
    page.set_viewport_size({"width": 1366, "height": 768})
    explorer.open(urlencode({"model": "brake", "text": BRAKE}))
    title = page.locator("#orbit-title")
    expect(title).to_contain_text("rightmost eigenvalue: 31.8")  # Hz: 200 rad/s
    expect(title).to_contain_text("Hz, damping ratio 1.874")
    expect(page.locator("#plot-eigenvalues .dot")).to_have_count(1)
    assert page.evaluate(CUT) == []
    page.keyboard.press("p")
    assert page.evaluate(CUT) == []
    page.keyboard.press("Escape")
    page.set_viewport_size(rest)
