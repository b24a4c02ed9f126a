"""Contacts of a simulated motion: the mechanism stops where it sticks, with its pictures below."""

import re
from pathlib import Path
from urllib.parse import urlencode

import pytest
from playwright.sync_api import expect

CONTACTS = ".contacts[data-drawn]"


def let_go(explorer):
    """Let a motion go and wait for its last round."""
    panel = explorer.page.locator("#simulation")
    panel.get_by_role("button", name="From rest").click()
    explorer.page.wait_for_selector(CONTACTS)
    return panel.locator(".verdict").inner_text()


def moment(explorer, phase):
    """Show a moment of the round; return what contacts do then."""
    explorer.page.get_by_label("Moment at the end").evaluate(
        "(slider, value) => { slider.value = value; slider.dispatchEvent(new Event('input')); }",
        phase,
    )
    return explorer.page.locator(CONTACTS).get_attribute("data-doing").split()


def tip(explorer):
    """Where the tip is in the mechanism, x and y upwards over L."""
    transform = explorer.page.locator(".contacts .tip-group").get_attribute("transform")
    x, y = map(float, re.findall(r"-?[\d.]+(?:e-\d+)?", transform))
    return x, -y


def test_an_orbit_has_the_friction_loop_of_a_contact_that_never_sticks(explorer):
    bristles = (Path(__file__).parents[1] / "models" / "bristles.toml").read_text()
    explorer.open(urlencode({"model": "own bristles", "text": bristles}))
    loop = explorer.page.locator("#plot-loop")
    expect(loop.locator(".tint-1")).not_to_have_count(0)
    expect(loop).to_contain_text("x (m)")
    explorer.open("model=sliding")
    explorer.page.wait_for_selector(".orbit[data-drawn][aria-busy=false]")
    expect(loop).to_be_hidden()


@pytest.mark.long
def test_the_tip_stands_still_on_the_plate_while_it_sticks(explorer):
    explorer.open("model=sliding&p.Nd=0.9")
    explorer.type("Vd", 0.02)  # of such a slow plate the diagram takes long; nothing waits for it
    verdict = let_go(explorer)
    assert "Settled on a response of 1 forcing period" in verdict
    assert "tip sticks once, 34.9\u202f% of the time" in verdict
    page = explorer.page
    assert moment(explorer, 0.05) == ["stick"]
    expect(page.locator(".contacts .tip-group")).to_have_class(re.compile("sticks"))
    first = tip(explorer)
    assert moment(explorer, 0.2) == ["stick"]
    x, y = (b - a for a, b in zip(first, tip(explorer), strict=True))
    gone = 0.02 / 5e-3 * 0.15 / 12.5  # of the plate, over L
    assert (x, y) == pytest.approx((gone / 2, gone * 3**0.5 / 2), abs=1e-4)
    assert moment(explorer, 0.5) == ["forth"]
    expect(page.locator(".contacts .reading")).to_contain_text("slips")
    pictures = ["timeline", "hysteresis", "friction", "contact-path"]
    boxes = [page.locator(f"#plot-{picture} .small-plot").bounding_box() for picture in pictures]
    corners = {(round(box["x"]), round(box["y"])) for box in boxes if box["height"] > 80}
    assert len(corners) == len(pictures)  # none lies on another
    assert page.locator("#plot-settling .dot").first.get_attribute("d").count("h0") > 100
    assert page.locator("#plot-timeline .band.stick").count() == 2  # one goes on over the end
    assert page.locator("#plot-hysteresis .line.stuck").count() == 4
    page.get_by_role("button", name="Clear").click()
    expect(page.locator(".contacts .stage")).to_be_hidden()
