"""The motion at the working point is judged by its Lyapunov exponents."""

import re

from playwright.sync_api import expect


def judged(explorer):
    explorer.page.get_by_role("button", name="Torus or chaos?").click()
    return explorer.page.locator("#exponents")


def test_a_torus_tells_how_far_it_is_known_and_is_forgotten_when_the_point_moves(explorer):
    explorer.open("model=sliding&p.Nd=0.06&span=0~0.07")
    told = judged(explorer)
    stop = explorer.page.get_by_role("button", name="Stop classifying")
    expect(told).to_have_text(re.compile(r"^After \d+ of at most 128000 periods"))
    expect(stop).to_be_visible()
    expect(told).to_have_text(
        re.compile(
            r"^Torus: quasi-periodic, on a torus of 2 frequencies; "
            r"its rotation number is 0\.495939 .*"
            r"Exponents per forcing period: 0, −0\.005012, −0\.1171, −0\.2698\.$"
        )
    )
    expect(stop).to_be_hidden()
    explorer.type("Nd", 0.061)
    expect(told).to_be_empty()
