"""Boxes take the numbers and units that the command line takes, and say what they do not take."""

import random
import re

import pytest
from playwright.sync_api import expect

from slipfold import InputError, Parameter
from slipfold.models.units import parse_quantity, units_of, wanted_text

UNITS = ("N", "rad", "m/s", "", "Hz", "Pa/m", "1/s")

READ = """
async (cases) => {
  const { parsed } = await import("/page/quantities.js");
  return cases.map(([text, quantity]) => parsed(text, quantity));
}
"""


def _cases():
    """Numbers with units, whole and damaged; seeded, so always the same."""
    chance = random.Random(7)
    signs = ["", "", "-", "+", "−", "--"]
    digits = ["1", "12", "0.5", ".5", "5.", "", "1.2.3", "inf", "nan", "1_0"]
    exponents = ["", "", "e3", "E-2", "e−2", "e", "e400"]
    for _ in range(600):
        unit = chance.choice(UNITS)
        suffixes = ["", *units_of(unit), *units_of(unit), "mn", "12", ",3", ".", "furlong"]
        parts = signs, digits, exponents, ["", " ", "\t", "\u202f"], suffixes, ["", " "]
        yield "".join(chance.choice(part) for part in parts), unit


def _read(text, unit):
    """What Python makes of a text: a value, or the sentence of a refusal."""
    quantity = Parameter("q", 1.0, unit)
    try:
        return {"value": quantity.check(parse_quantity(text, unit, "q"))}
    except InputError as error:
        return {"sentence": str(error)}


def test_the_page_reads_quantities_as_the_command_line_does(explorer):
    explorer.open()
    described = {
        unit: {
            "name": "q",
            "units": units_of(unit),
            "wanted": wanted_text(unit),
            "bounds": "any finite number",
        }
        for unit in UNITS
    }
    cases = list(_cases())
    answers = explorer.page.evaluate(READ, [(text, described[unit]) for text, unit in cases])
    values = 0
    for (text, unit), answer in zip(cases, answers, strict=True):
        expected = _read(text, unit)
        values += "value" in expected
        if text.isprintable() and "finite" not in str(expected):
            assert answer == expected, text
        else:  # Python writes such texts and numbers in its own way
            assert answer.keys() == expected.keys(), text
    assert 60 < values < 540  # a tenth are quantities, and a tenth are refused


@pytest.mark.parametrize(
    ("name", "text", "sentence"),
    [
        ("f", "12,3", "f = '12,3' has a decimal comma, write 12.3; give a number, or a number"),
        ("f", "13 .. 12", "f = '13 .. 12' is no range; give the smaller end first"),
        ("mu", "1e999", "mu = 1e999 is not a finite number; give >= 0"),
    ],
)
def test_what_is_no_quantity_is_refused_beside_its_box(explorer, name, text, sentence):
    explorer.open()
    box, alert = explorer.box(name), explorer.page.get_by_role("alert")
    before = box.input_value()
    box.fill(text)
    box.press("Tab")
    expect(alert).to_contain_text(sentence)
    place, beside = box.bounding_box(), alert.bounding_box()
    assert 0 < beside["x"] - place["x"] - place["width"] < 20
    assert abs(beside["y"] - place["y"]) < 20
    expect(box).to_have_value(text)
    expect(box).not_to_be_focused()
    box.press("Escape")
    expect(box).to_have_value(before)
    expect(alert).to_have_count(0)
    box.fill(text)
    box.press("Tab")
    with explorer.redrawn():
        explorer.type("f", "12.4")
    expect(explorer.page.get_by_role("alert")).to_have_count(0)


def test_every_value_that_cannot_be_had_is_marked_and_says_why(explorer):
    explorer.open()
    reasons = {name: f"{name} = -1 is outside its bounds; {name} must be" for name in ("Vd", "mu")}
    alert = explorer.page.get_by_role("alert")
    for name in reasons:
        explorer.type(name, -1)
    for name, reason in reasons.items():
        expect(alert.filter(has_text=reason)).to_have_count(1)
        expect(explorer.box(name)).to_have_attribute("aria-invalid", "true")
        expect(explorer.box(name)).to_have_attribute("title", re.compile(reason))
    expect(alert).to_have_count(2)
    expect(explorer.page.locator(".number[aria-invalid]")).to_have_count(2)
    explorer.type("mu", 0.5)
    expect(alert).to_have_count(1)
    expect(explorer.page.locator(".number[aria-invalid]")).to_have_id("parameter-Vd-box")
    explorer.type("Vd", 0.6)
    explorer.type("Nd", 5)  # each may be had, not both
    expect(alert.filter(has_text="Nd = 5 N is not below Ns = 1 N")).to_have_count(1)
    expect(alert).to_have_count(1)
    expect(explorer.page.locator(".number[aria-invalid]")).to_have_id("parameter-Nd-box")


def test_a_value_that_cannot_be_had_is_neither_in_the_link_nor_undone_to(explorer):
    explorer.open("model=sliding&p.Nd=0.3")
    with explorer.redrawn():
        explorer.type("Vd", 0.7)
    explorer.type("Vd", -1)
    expect(explorer.page.get_by_role("alert")).to_contain_text("Vd = -1 is outside its bounds")
    explorer.page.wait_for_url("**p.Vd=0.7*")
    with explorer.redrawn():
        explorer.type("Vd", 0.8)
    explorer.page.wait_for_url("**p.Vd=0.8*")
    explorer.page.get_by_role("button", name="Undo").click()
    expect(explorer.box("Vd")).to_have_value("0.7")


def test_a_refusal_moves_nothing_under_the_pointer(explorer):
    explorer.open()
    explorer.box("f1").fill("abc")
    place = explorer.box("Ns").bounding_box()
    explorer.page.mouse.dblclick(
        place["x"] + place["width"] / 2, place["y"] + 0.8 * place["height"]
    )
    explorer.page.keyboard.type("1.5")
    with explorer.redrawn():
        explorer.page.keyboard.press("Enter")
    assert [explorer.parameter(name) for name in ("Ns", "mu")] == [1.5, 0.5]
    expect(explorer.box("f1")).to_have_value("abc")
    explorer.box("f1").press("Escape")
    expect(explorer.box("f1")).to_have_value("6.12")


def test_keys_and_sliders_move_by_round_and_equal_steps(explorer):
    explorer.open()
    box = explorer.box("f")
    seen = []
    for _ in range(4):
        box.press("ArrowUp")
        seen.append(box.input_value())
    assert seen == ["12.502", "12.504", "12.506", "12.508"]
    box.press("PageDown")
    expect(box).to_have_value("12.488")
    explorer.type("f", "12.5013")
    box.press("ArrowDown")
    expect(box).to_have_value("12.5")
    explorer.slider("f").press("ArrowRight")
    expect(box).to_have_value("12.52")
    explorer.slide("Nd", 0.719473293769)
    explorer.release("Nd")
    expect(explorer.box("Nd")).to_have_value("0.72")  # a pixel is worth 0.014
    explorer.page.wait_for_url("**p.Nd=0.72&**")
    explorer.slide("Nd", 0.98)
    expect(explorer.box("Nd")).to_have_value("0.98")
    explorer.release("Nd")


def test_a_range_that_is_typed_is_the_sliders_and_goes_with_the_link(explorer):
    explorer.open("model=sliding&p.Nd=0.3")
    slider, meaning = explorer.slider("Ns"), explorer.page.locator(".meaning")
    with explorer.redrawn():
        explorer.type("Ns", "1500 .. 2500 mN")
    explorer.page.wait_for_url("**range.Ns=1.5~2.5*")
    assert [slider.get_attribute(end) for end in ("min", "max")] == ["1.5", "2.5"]
    expect(explorer.box("Ns")).to_have_value("1.5")
    expect(meaning).to_contain_text("Slider 1.5 .. 2.5; type another range like this.")
    explorer.type("Nd", "0.1 .. 0.5")
    expect(explorer.page.get_by_label("Vary to")).to_have_value("0.5")
    explorer.page.get_by_label("Undo").click()
    explorer.page.get_by_label("Undo").click()
    assert slider.get_attribute("max") != "2.5"
    explorer.open("model=sliding&range.Ns=3~1")
    expect(explorer.page.get_by_role("alert")).to_contain_text("range.Ns = '3~1' does not grow")
    explorer.open("model=sliding&p.Nd=0.3")  # what was read of that link is the plain one
    expect(explorer.page.get_by_role("alert")).to_have_count(0)
