"""A simulation is drawn on the diagram while it is computed."""

import re

import pytest
from playwright.sync_api import expect

import slipfold as sf
from helpers.explorer_page import DIAGRAM

SETTLED = re.compile("^(settled|Settled)")

DOTS = (  # the trace of a simulation is that with fading markers
    "(selector) => document.querySelector(selector).data"
    ".filter(({ marker }) => Array.isArray(marker?.opacity)).map(({ x, y }) => [x, y])[0]"
)


def dots(explorer):
    """The dots in the diagram, once those that have come are drawn."""
    explorer.page.wait_for_selector(f"{DIAGRAM}[aria-busy=false]")
    x, y = explorer.page.evaluate(DOTS, f"{DIAGRAM} .plot-canvas")
    return x, y


def test_from_rest_it_settles_on_the_stable_branch(explorer):
    explorer.open("model=sliding&p.Nd=0.02")
    explorer.orbit_shown(1)
    explorer.page.get_by_role("button", name="From rest").click()
    expect(explorer.page.locator(".verdict")).to_have_text(SETTLED)
    x, y = dots(explorer)
    assert explorer.page.locator("#plot-settling .dot").count() == len(y) > 100
    assert set(x) == {0.02}
    chosen = explorer.page.locator(f"{DIAGRAM} .place.chosen").bounding_box()
    height = chosen["y"] + chosen["height"] / 2
    assert abs(explorer.pixel(0.02, y[-1])[1] - height) < 3
    assert abs(explorer.pixel(0.02, max(y[:5]))[1] - height) > 10


def test_from_an_orbit_nudged_off_it_and_cleared(explorer):
    explorer.open("model=sliding&p.Nd=0.02")
    explorer.orbit_shown(1)
    page = explorer.page
    page.get_by_label("Nudge").select_option("10 %")
    page.get_by_role("button", name="From this orbit").click()
    expect(page.locator(".verdict")).to_have_text(SETTLED)
    page.get_by_role("button", name="Clear").click()
    expect(page.locator("#plot-settling")).to_be_hidden()
    expect(page.locator(".verdict")).to_be_empty()


@pytest.mark.parametrize("model", ["vanderpol-free", "squeal"])
def test_what_nothing_forces_settles_on_its_cycle(explorer, model):
    """From the model's own start; the largest displacement of every round is that of the cycle."""
    explorer.open(f"model={model}&p.mu=1")
    page = explorer.page
    page.get_by_role("button", name="From rest").click()
    verdict = page.locator(".verdict")
    expect(verdict).to_have_text(re.compile(r"^settled on a cycle of [0-9.]+ s"))
    assert page.locator("#plot-settling svg").get_by_text("time (s)").count() == 1
    words = [page.locator(f"#{panel}").inner_text() for panel in ("diagram", "orbit", "simulation")]
    assert "forcing" not in "".join(words)
    duration = float(verdict.inner_text().split(" of ")[1].split(" s")[0])
    built_in = sf.built_in_models()[model](mu=1.0)
    cycle = sf.periodic_orbit(built_in, state=sf.simulate(built_in).strobe[-1])
    assert duration == pytest.approx(cycle.duration, rel=1e-7)
    _, y = dots(explorer)
    # Sixty-four samples an interval miss a maximum by a little.
    assert y[-50:] == pytest.approx([cycle.extrema.maximum[0][0]] * 50, rel=5e-3)
