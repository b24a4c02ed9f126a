"""A motion and a sweep are heard; no sound card is needed to tell."""

import re

import pytest
from playwright.sync_api import expect

from helpers.ways_out import KEEP, RENDERED


def test_a_motion_and_a_sweep_are_heard(explorer):
    page = explorer.open("model=duffing&p.d=0.3&p.W=1.2&span=1.1~1.3").page
    page.evaluate(KEEP)
    page.get_by_role("button", name="From rest").click()
    sound = page.locator(".sound")
    expect(sound.get_by_label("Hear")).to_have_value("v")
    sound.get_by_role("button", name="Listen").click()
    # 0.19 Hz is heard nine octaves above.
    expect(sound.get_by_role("status")).to_have_text(
        re.compile(r"^0\.191.Hz, played 512 times faster at 97\.78.Hz$")
    )
    expect(sound.get_by_role("button", name="Silence")).to_be_visible()
    measured = page.evaluate(RENDERED)
    assert measured["seconds"] == 3
    assert measured["rising"] == pytest.approx(3 * 97.78, abs=2)
    assert measured["peak"] == pytest.approx(0.8, abs=0.01)
    assert max(measured["ends"]) < 0.01
    sound.get_by_role("button", name="Silence").click()
    expect(sound.get_by_role("button", name="Silence")).to_be_hidden()
    page.get_by_role("button", name="Sweep up and down").click()
    page.get_by_role("button", name="Hear the sweep").click()
    expect(page.locator(".sweep-control [role=status]")).to_have_text(
        "Played 512 times faster: up, then down."
    )
    page.locator(".sweep-control").get_by_role("button", name="Silence").click()
