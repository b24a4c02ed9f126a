"""The motion at the working point is judged by its Lyapunov exponents."""

import re

from playwright.sync_api import expect

NOTE = """
() => {
  const panel = document.querySelector(".exponents");
  window.told = [];
  new MutationObserver(() => told.push(panel.innerText))
    .observe(panel, { childList: true, subtree: true });
}
"""
"""Note what is told on the way, which may be there for a moment."""


def test_a_torus_tells_how_far_it_is_known_and_is_forgotten_when_the_point_moves(explorer):
    page = explorer.open("model=vanderpol&p.a=0.3&p.e=0.2&p.w=1.1&vary=w&span=1.05~1.15").page
    page.evaluate(NOTE)
    page.get_by_role("button", name="Torus or chaos?").click()
    told = page.locator("#exponents")
    expect(told).to_have_text(
        re.compile(
            r"^Torus: quasi-periodic, on a torus of 2 frequencies; "
            r"its rotation number is 0\.0718252 .*"
            r"Exponents per forcing period: 0, −0\.5738\.$"
        )
    )
    on_the_way = re.compile(r"Stop classifying\s+After \d+ of at most 128000 periods")
    assert any(map(on_the_way.search, page.evaluate("told")))
    expect(page.get_by_role("button", name="Stop classifying")).to_be_hidden()
    explorer.type("w", 1.11)
    expect(told).to_be_empty()
