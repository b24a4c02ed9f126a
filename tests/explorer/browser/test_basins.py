"""Basins of attraction become finer while one looks; a click lets a motion go from there."""

import re

from playwright.sync_api import expect

LINK = "model=duffing&p.W=1.2&span=1.1~1.3"


NOTE = """
() => {
  const plot = document.querySelector(".basins-plot");
  window.sizes = [];
  new MutationObserver(() => sizes.push(plot.dataset.points))
    .observe(plot, { attributeFilter: ["data-points"] });
}
"""
"""Note how fine pictures are that come."""


def test_the_picture_becomes_finer_and_a_click_lets_a_motion_go(explorer):
    page = explorer.open(LINK).page
    explorer.orbit_shown(1)
    page.evaluate(NOTE)
    page.get_by_role("button", name="Compute the basins").click()
    plot = page.locator(".basins-plot")
    page.wait_for_function("() => sizes.includes('48')")  # which may be gone soon
    assert page.evaluate("sizes.filter(Boolean).slice(0, 2)") == ["16", "48"]
    *shares, boundary = page.locator(".basins-legend li").all_inner_texts()
    assert len(shares) == 2
    assert 0 < float(re.search(r"boundary: .*, ([\d.]+) %", boundary)[1]) < 100
    veil = page.evaluate("document.querySelector('.basins-plot .plot-canvas').data[1].z.flat()")
    assert {1, None} == set(veil)
    page.get_by_role("button", name="Stop computing").click()  # a third would take seconds
    found = [float(re.search(r"([\d.]+) %", text)[1]) for text in shares]
    assert abs(sum(found) - 100) < 0.2
    plot.click(position={"x": 200, "y": 100})
    verdict = page.locator("#simulation .verdict")
    expect(verdict).to_have_text(re.compile("^Settled on a response of 1"))
    # What is of other values is neither shown nor computed.
    explorer.type("F", 0.19)
    expect(plot).to_be_hidden()
    expect(page.locator("#basins .basins-words")).to_be_empty()
