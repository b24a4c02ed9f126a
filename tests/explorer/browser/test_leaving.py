"""What is shown leaves as the text that makes it, as pictures and data; a link brings it back."""

import re
import tomllib
from xml.etree import ElementTree

import pytest
from playwright.sync_api import expect

from helpers.ways_out import menu, saved

VIEW = "model=sliding&p.Vd=0.7&p.Nd=0.3"


@pytest.fixture
def shown(explorer):
    explorer.open(VIEW)
    explorer.orbit_shown(2)
    return explorer


def test_python_and_toml_are_copied(shown):
    menu(shown.page, "diagram", "Copy as Python").click()
    dialog = shown.page.locator("dialog")
    expect(dialog).to_be_visible()
    expect(dialog).to_contain_text("Copied.")
    text = shown.page.evaluate("navigator.clipboard.readText()")
    assert dialog.locator("pre").inner_text().strip() == text.strip()
    compile(text, "copied.py", "exec")
    assert "Vd=0.7" in text
    dialog.get_by_role("button", name="Close").click()
    menu(shown.page, "diagram", "Copy as TOML").click()
    expect(dialog.locator("h2")).to_have_text("The diagram in TOML")
    case = tomllib.loads(dialog.locator("pre").inner_text())
    assert "0.7" in str(case)
    dialog.get_by_role("button", name="Close").click()
    expect(dialog).to_be_hidden()


def test_what_a_menu_does_not_have_is_marked_with_the_reason(shown):
    item = menu(shown.page, "simulation", "netCDF")
    expect(item).to_have_attribute("aria-disabled", "true")
    expect(item).to_have_attribute("title", "There is no simulation yet.")
    item.press("Escape")
    item = menu(shown.page, "orbit", "Copy as Python")
    assert item.get_attribute("aria-disabled") is None
    # No command computes a single orbit.
    texts = shown.page.locator("#orbit .menu button").all_inner_texts()
    assert [text for text in texts if "TOML" in text or "Figure" in text] == []
    item.press("Escape")


def test_a_figure_has_the_pinned_curves_and_is_that_of_the_package(shown):
    page = shown.page
    page.get_by_role("button", name="Pin this curve").click()
    page.get_by_label("Name of the pinned curve").fill("slower")
    page.get_by_label("Name of the pinned curve").press("Enter")
    assert saved(shown.page, "diagram", "Figure, PDF").read_bytes().startswith(b"%PDF")
    content = "".join(
        ElementTree.parse(saved(shown.page, "diagram", "Figure, SVG")).getroot().itertext()
    )
    assert [word for word in ("slower", "current", "PD") if word not in content] == []


@pytest.mark.parametrize(
    ("panel", "words"),
    [
        ("diagram", ["Nd (N)"]),
        ("orbit", ["Nd = 0.3", "Time series", "Floquet multipliers", "Forces", "Fx"]),
        ("simulation", ["simulated from rest", "Settling", "forcing period"]),
    ],
)
def test_pictures_say_what_they_show(shown, panel, words):
    if panel == "simulation":
        shown.page.get_by_role("button", name="From rest").click()
        expect(shown.page.locator(".verdict")).to_have_text(re.compile("ettled"))
    assert saved(shown.page, panel, "Picture, PNG").read_bytes().startswith(b"\x89PNG")
    text = saved(shown.page, panel, "Picture, SVG").read_text()
    assert text.startswith("<svg")
    assert "</svg>" in text
    sheet = ElementTree.fromstring(text)
    content = "".join(sheet.itertext())
    assert [word for word in words if word not in content] == []
    drawings = sheet.findall("{http://www.w3.org/2000/svg}svg")
    # No controls of the page leave a blank at the left of the first row.
    tops = {float(item.get("y")): float(item.get("x")) for item in reversed(drawings)}
    assert panel == "diagram" or tops[min(tops)] < 20


def test_a_link_gives_the_same_page(shown, new_tab):
    page = shown.page
    page.get_by_role("button", name="Pin this curve").click()
    page.get_by_label("of", exact=True).select_option("y")
    with shown.redrawn():
        shown.type("f", 12.4)
    page.get_by_label("Copy the link").click()
    expect(page.get_by_text("Link copied.")).to_be_visible()
    link = page.evaluate("navigator.clipboard.readText()")
    assert "token" not in link
    other = new_tab
    other.open(link.split("#")[1], plane=True)
    assert other.specials() == shown.specials()
    assert other.parameter("f") == 12.4
    assert other.parameter("Vd") == 0.7
    assert other.page.get_by_label("of", exact=True).input_value() == "y"
    name = other.page.get_by_label("Name of the pinned curve")
    assert name.input_value() == "Vd = 0.7\u202fm/s"


WRONG = {
    "model=nothing": "there is no model 'nothing'",
    "model=sliding&p.Vd=fast": "Vd = 'fast' is not a number; give a number, or",
    "model=sliding&p.Vd=1e999": "Vd = 1e999 is not a finite number; give > 0 m/s",
    "model=sliding&p.V=1": "sliding has no parameter 'V'",
    "model=sliding&vary=speed": "vary = 'speed' is none of k1, zeta1",
    "model=sliding&span=1~1": "span = '1~1' is empty",
    "model=sliding&show=z": "show = 'z' is none of x, y",
    "model=sliding&of=mean": "of = 'mean' is none of max, min",
    "model=sliding&zoom=1~2": "zoom = '1~2' is not 4 numbers",
    "model=sliding&plane=f~1~2~f~1~2": "plane = 'f~1~2~f~1~2' is not two parameters",
    "model=sliding&pin=name%3Da%26Q%3D1": "sliding has no parameter 'Q'",
    "model=sliding&color=red": "color = 'red' is no part of a link",
}


READ = """
async (links) => {
  const { readLink } = await import("/page/model/editor.js");
  const models = await (await fetch("/api/models")).json();
  return Promise.all(links.map(async (link) => (await readLink(link, models)).sentence));
}
"""


def test_what_is_wrong_with_a_link_is_said(explorer):
    *_, last = WRONG
    page = explorer.open(last).page
    said = page.evaluate(READ, [*WRONG])
    for words, sentence in zip(WRONG.values(), said, strict=True):
        assert sentence.startswith(f"Not all of this link could be read: {words}")
    alert = page.get_by_role("alert")
    expect(alert).to_contain_text(said[-1])
    explorer.open("model=sliding&p.alpha=30deg")
    expect(alert).to_have_count(0)
    assert explorer.parameter("alpha") == 30
