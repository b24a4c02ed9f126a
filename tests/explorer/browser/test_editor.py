"""The editor of the model: what is written there is what the page shows."""

import re
from pathlib import Path
from urllib.parse import urlencode

import pytest
from playwright.sync_api import expect

from helpers.explorer_models import BRAKE_OF_FILE, HOSTILE, STIFFNESS
from helpers.explorer_page import FOLLOW, ExplorerPage, served, violations

TEXT = ".editor textarea"

HELD = """() => { const ask = fetch, answers = []; let open;
  const opened = new Promise((resolve) => { open = resolve; });
  window.fetch = (...all) => {
    answers.push(opened.then(() => ask(...all))); return answers.at(-1); };
  window.release = async () => { open(); await Promise.all(answers);
    await new Promise((resolve) => setTimeout(resolve, 100)); }; }"""
"""Hold requests back until they are released."""


@pytest.fixture
def editor(new_tab):
    """The editor with the text of Duffing's oscillator."""
    new_tab.open("model=duffing&p.F=0.2")
    new_tab.page.get_by_role("button", name="Edit the model").click()
    expect(new_tab.page.locator(TEXT)).to_have_value(re.compile("Duffing's oscillator"))
    return new_tab


def write(explorer, text):
    explorer.page.locator(TEXT).fill(text)
    explorer.page.keyboard.press("Control+Enter")


def test_a_model_is_edited_undone_linked_saved_and_opened(editor, tmp_path):
    page = editor.page
    given = page.locator(TEXT).input_value()
    assert page.locator(TEXT).evaluate("(area) => area.selectionStart") == 0
    quintic = given.replace("- g*q^3", "- g*q^3 - e*q^5").replace("d = {", "e = 0.02\nd = {")
    write(editor, given.replace("k*q ", "k*qq "))
    expect(page.locator(".fault p")).to_contain_text("line 17, column 36: there is no name 'qq'")
    expect(page.locator(".lined .wrong")).to_have_text("17\n")
    assert page.locator(TEXT).evaluate("(area) => area.value.slice(area.selectionStart)[0]") == "q"
    editor.faults.clear()  # browsers note a refused request
    before = editor.specials()
    with editor.redrawn():
        with page.expect_request("**/api/model"):
            write(editor, quintic)
        editor.slide("F", 0.15, "change")  # while the model is built
        expect(page.locator("header select")).to_have_value("duffing (edited)")
    assert editor.specials() != before
    assert editor.parameter("F") == 0.15  # what is set on the page stays
    assert editor.slider("e").count() == 1
    after = editor.specials()
    page.get_by_role("button", name="Equations").click()
    expect(page.locator(".equations td").filter(has_text="g q³ − e q⁵")).to_be_visible()
    page.get_by_role("button", name="Text", exact=True).click()
    page.get_by_role("button", name="Close the editor").click()
    with editor.redrawn():
        page.keyboard.press("Control+z")
        page.keyboard.press("Control+z")
    assert editor.specials() == before
    with editor.redrawn():
        page.keyboard.press("Control+Shift+z")
        page.keyboard.press("Control+Shift+z")
    page.get_by_role("button", name="Edit the model").click()
    with page.expect_download() as saving:
        page.get_by_role("button", name="Save", exact=True).click()
    saved = tmp_path / "saved.toml"
    saving.value.save_as(saved)
    assert saved.read_text().startswith("# slipfold explore: p.F=0.15")
    page.reload()  # another page knows nothing of the model
    page.wait_for_selector(".plot[aria-busy=false]")
    assert editor.specials() == after
    # What is saved before its text has come waits for it.
    page.evaluate(HELD)
    page.get_by_role("button", name="Edit the model").click()
    with page.expect_download() as saving:
        page.get_by_role("button", name="Save", exact=True).click()
        page.evaluate("release()")
    assert Path(saving.value.path()).read_text() == saved.read_text()
    editor.open("model=duffing&p.F=0.2")
    with editor.redrawn():
        page.get_by_label("File with a model").set_input_files(saved)
    assert editor.specials() == after
    assert editor.parameter("F") == 0.15
    # A link whose model is built late does not replace a newer one.
    page.evaluate(HELD)
    page.evaluate(FOLLOW, urlencode({"model": "late", "text": f"{quintic}\n"}))
    editor.open("model=duffing&p.F=0.16")
    page.evaluate("release()")
    assert page.locator("header select").input_value() == "duffing"


def test_the_file_of_the_server_is_read_again(explorer, new_tab, case_file):
    page = explorer.open("model=hostile").page
    page.get_by_role("button", name="Edit the model").click()
    expect(page.locator(TEXT)).to_have_value(HOSTILE)
    try:
        case_file.write_text(HOSTILE.replace("value = 0.2,", "value = 0.3,"))
        with explorer.redrawn():
            page.get_by_role("button", name="Reload").click()
        assert explorer.parameter("F") == 0.3
        # A page whose editor is opened after that has the model that was.
        other = new_tab.open("model=hostile").page
        other.get_by_role("button", name="Edit the model").click()
        expect(other.locator(".editor .actions")).to_contain_text("The file has changed")
        assert new_tab.parameter("F") == 0.2
        with new_tab.redrawn():
            other.get_by_role("button", name="Apply").click()
        assert new_tab.parameter("F") == 0.3
    finally:
        case_file.write_text(HOSTILE)
    page.get_by_role("button", name="Close the editor").click()


@pytest.mark.long
def test_files_that_the_file_of_the_server_names_are_read_again(context, tmp_path):
    file, matrix = tmp_path / "one's own.toml", tmp_path / "K.mtx"
    file.write_text(BRAKE_OF_FILE)
    matrix.write_text(STIFFNESS)
    with served(file, workers=1) as address, context.new_page() as page:
        brake = ExplorerPage(page, address).open("model=brake")
        page.get_by_role("button", name="Edit the model").click()
        expect(page.locator(TEXT)).to_have_value(BRAKE_OF_FILE)
        state = page.locator(".editor .actions [role=status]")
        page.get_by_role("button", name="Reload").click()
        expect(state).to_have_text("Nothing was changed.")
        file.write_text(BRAKE_OF_FILE.replace("load = 5", "load = 6"))
        with brake.redrawn():
            page.get_by_role("button", name="Reload").click()
        # The matrices of a text that is the model now are read again as well.
        matrix.write_text(STIFFNESS.replace("2000.0", "2500.00"))
        page.get_by_role("button", name="Apply").click()
        expect(state).to_have_text("Applied.")
        page.get_by_role("button", name="Apply").click()
        expect(state).to_have_text("Nothing was changed.")
        brake.open("model=brake")
        file.write_text("names =\n")
        page.get_by_role("button", name="Reload").click()
        expect(page.get_by_role("alert")).to_contain_text("line 1, column 8: this is not TOML")


BELT = (Path(__file__).parents[1] / "models/two-on-a-belt.toml").read_text()


def test_the_mechanism_of_a_file_is_drawn_and_moves(explorer):
    explorer.open(urlencode({"model": "belt", "text": BELT, "vary": "Vd_rear", "span": "1.6~1.4"}))
    page = explorer.page
    stage = page.locator(".orbit .schematic")
    expect(stage).to_have_attribute(
        "aria-label", "The mechanism: 2 masses, 3 springs, 2 friction contacts"
    )
    counts = [stage.locator(part).count() for part in (".block", ".spring", ".dashpot", ".belt")]
    assert counts == [2, 3, 3, 2]
    page.get_by_role("button", name="From rest").click()
    page.wait_for_selector(".contacts[data-drawn]")
    moving = page.locator(".contacts .schematic .belt").first
    before = moving.get_attribute("d")
    page.get_by_label("Moment at the end").evaluate(
        "(slider) => { slider.value = 0.123; slider.dispatchEvent(new Event('input')); }"
    )
    assert moving.get_attribute("d") != before
    assert violations(page, ".contacts") == []  # last, since it skips what follows


def test_a_law_is_chosen_and_its_coefficient_follows_the_sliders(explorer):
    explorer.open(urlencode({"model": "belt", "text": BELT, "span": "1.6~1.4"}))
    page = explorer.page
    curve = page.locator("#plot-law svg")
    page.get_by_label("Contact", exact=True).select_option("1")
    expect(curve).to_have_attribute("aria-label", re.compile("of rear: 0.5 at rest"))
    explorer.slide("mu_s_rear", 0.7)
    expect(curve).to_have_attribute("aria-label", re.compile("of rear: 0.7 at rest"))
    explorer.release("mu_s_rear")
    page.get_by_label("Friction", exact=True).evaluate(  # the second before the first is there
        "(select) => ['LuGre', 'RationalStribeck'].forEach((law) => {"
        " select.value = law; select.dispatchEvent(new Event('change')); })"
    )
    expect(explorer.slider("d_rear")).to_have_count(1)
    assert explorer.slider("vs_rear").count() == 0
    assert explorer.slider("vs_front").count() == 1
    page.keyboard.press("Control+z")
    page.keyboard.press("Control+z")
    expect(explorer.slider("d_rear")).to_have_count(0)
    expect(explorer.slider("vs_rear")).to_have_count(1)


def test_a_link_with_a_text_that_is_no_model_says_so(explorer):
    explorer.open(urlencode({"model": "own", "text": "[states]\nq = 'v'\n"}))
    alert = explorer.page.get_by_role("alert")
    expect(alert).to_contain_text("The model of this link cannot be used: line 2, column 6: there")
    explorer.faults.clear()  # browsers note a refused request
    # The page may write its own address before it hears of a link.
    explorer.page.evaluate(
        "() => { const own = location.href; location.hash = 'model=duffing';"
        " history.replaceState(null, '', own); }"
    )
    expect(alert).to_have_count(0)
