"""Every built-in model, and models of a user's kind, go through every panel and every way out."""

import re
from pathlib import Path
from urllib.parse import urlencode

import pytest
from playwright.sync_api import expect

import slipfold as sf
from helpers.copied import run_python
from helpers.explorer_models import RAYLEIGH
from helpers.explorer_page import DIAGRAM, ORBIT, ExplorerPage, served
from helpers.ways_out import KEEP, RENDERED, leave, read, same_bifurcations, same_branches
from slipfold.interface.explorer.plain import short

FILES = {item.stem: item for item in sorted(Path(__file__).parents[1].glob("models/*.toml"))}
"""Two that nothing forces, ten masses, friction with memory, a stiff one."""

SLOW = 600_000
"""Milliseconds that chaos may take until it is known as such."""


@pytest.fixture(scope="module")
def pages(context, address):
    """A page, and another one on which what leaves it is opened again."""
    both = []
    for _ in range(2):
        page = context.new_page()
        page.add_init_script(f"({KEEP})()")
        both.append(ExplorerPage(page, address))
        page.set_default_timeout(SLOW)
    yield both
    for explorer in both:
        explorer.page.close()
        assert explorer.faults == []


def answered(explorer, kind):
    """Wait for the last answer about a panel."""
    explorer.page.wait_for_function("(kind) => answers[kind]?.done", arg=kind)
    return explorer.page.evaluate("(kind) => answers[kind]", kind)


def opened(explorer, fragment, kind="diagram"):
    """Open a link; return what is answered about a panel of it."""
    if explorer.is_loaded:
        explorer.page.evaluate("Object.assign(window, { answers: {}, swept: [] })")
    explorer.open(fragment, plane=True)
    return answered(explorer, kind)


def looked_at(explorer, link):
    """Open a model; return what its first panels show."""
    page = explorer.page
    shown = {"diagram": opened(explorer, urlencode({**link, "plane": "none"}))}
    assert page.locator("header select").input_value() == link["model"]
    assert explorer.traces()
    page.wait_for_selector(f"{ORBIT}[data-drawn]:not(.empty)[aria-busy=false]")
    expect(page.locator("#orbit-title")).to_contain_text("stable")
    expect(page.locator(".smalls .small:visible .dot")).not_to_have_count(0)
    page.get_by_role("button", name="From rest").click()
    shown |= {kind: answered(explorer, kind) for kind in ("orbit", "simulation")}
    expect(page.locator(".verdict")).not_to_be_empty()
    return shown


@pytest.mark.long
@pytest.mark.parametrize("name", [*sf.built_in_models(), *FILES])
def test_what_leaves_the_page_of_any_model_has_its_numbers(pages, name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    explorer, other = pages
    page, own = explorer.page, FILES.get(name)
    link = {"model": f"own {name}", "text": own.read_text()} if own else {"model": name}
    shown = looked_at(explorer, link)
    diagram, *_ = [leave(page, panel, answer) for panel, answer in shown.items()]
    sounds(explorer)
    is_swept(explorer)
    page.get_by_role("button", name="Torus or chaos?").click()
    expect(page.locator(".exponents strong")).not_to_be_empty(timeout=SLOW)
    if len(diagram.model.states) > 1:
        finds_basins(page)
    is_opened_again(explorer, other, shown["diagram"])
    if len(diagram.model.variable_parameters) > 1:
        plane = urlencode({**link, "plane": window_of(diagram)})
        leave(page, "plane", opened(explorer, plane, "plane"))
        regimes = page.get_by_role("button", name="Compute the regimes")
        if diagram.model.forced:
            regimes.click()
            data = page.locator(".regimes")
            expect(data).to_have_attribute("data-cells", re.compile(r"\d"), timeout=SLOW)
        else:
            expect(regimes).to_have_count(0)
    assert page.get_by_role("alert").all_inner_texts() == []


def finds_basins(page):
    """Compute basins until there is a picture, or it is said how far they are."""
    page.get_by_role("button", name="Compute the basins").click()
    page.wait_for_function(
        "() => document.querySelector('.basins-plot').dataset.points"
        " || /starts have settled/.test(document.querySelector('.basins-words').textContent)"
    )
    stop = page.get_by_role("button", name="Stop computing")
    if stop.is_visible():
        stop.evaluate("(button) => button.click()")  # it may be gone by now


def sounds(explorer):
    """Hear a simulation: it is finite and not silent, or a sentence says that it stands still."""
    page, sound = explorer.page, explorer.page.locator(".sound")
    sound.get_by_role("button", name="Listen").click()
    expect(sound.get_by_role("status")).not_to_be_empty()
    if answered(explorer, "sound")["silent"]:
        expect(sound.get_by_role("status")).to_have_text("It stands still.")
        return
    assert 0.1 < page.evaluate(RENDERED)["peak"] <= 1
    sound.get_by_role("button", name="Silence").click()


def is_swept(explorer):
    """Sweep over some values: the copied script gives them."""
    page = explorer.page
    page.get_by_role("button", name="Sweep up and down").click()
    page.wait_for_function(
        """() => {
            const control = document.querySelector(".sweep-control");
            if (control.dataset.state !== "running") return true;
            if (swept.length < 3) return false;
            [...control.querySelectorAll("button")].find(
                (button) => button.textContent === "Stop the sweep").click();
            return true;
        }"""
    )
    places = page.evaluate("swept.slice(0, 3)")
    assert places
    page.get_by_role("button", name="Copy the sweep as Python").click()
    text = read(page).replace("in values.tolist():", "in values.tolist()[:3]:")
    swept = run_python(text)["swept"]
    for place in places:
        assert short([y for x, y in swept[place["run"]] if x == place["x"]]) == place["y"]
    page.get_by_role("button", name="Clear the sweep").click()


def is_opened_again(explorer, other, shown):
    """Open the link and the file of a view on another page: it shows the same."""
    page = explorer.page
    page.get_by_label("Copy the link").click()
    expect(page.get_by_text("Link copied.")).to_be_visible()
    copied = page.evaluate("navigator.clipboard.readText()").split("#")[1]
    page.get_by_role("button", name="Edit the model").click()
    page.get_by_role("button", name="Equations").click()
    expect(page.locator(".equations td")).not_to_have_count(0)
    page.get_by_role("button", name="Text", exact=True).click()
    with page.expect_download() as saving:
        page.get_by_role("button", name="Save", exact=True).click()
    saving.value.save_as("session.toml")
    page.get_by_role("button", name="Close the editor").click()
    same_branches(opened(other, copied), shown)
    other.page.get_by_role("button", name="Edit the model").click()
    other.page.evaluate("answers = {}")
    other.page.get_by_label("File with a model").set_input_files("session.toml")
    # The built-in oscillator is saved as its equations, which are integrated in other steps.
    same_bifurcations(answered(other, "diagram"), shown)
    other.page.get_by_role("button", name="Close the editor").click()


def window_of(diagram):
    """A link's plane around the first special point: one curve, which takes seconds."""
    model, (low, high) = diagram.model, diagram.span
    first = next((p.value for b in diagram.branches for p in b.special), 0.7 * low + 0.3 * high)
    name = next(p.name for p in model.variable_parameters if p.name != diagram.vary)
    width, value = 0.005 * abs(high - low), model.values[name]
    ends = sorted((value, 1.02 * value)) if value else (0.0, 0.01)
    around = max(first - width, min(low, high)), min(first + width, max(low, high))
    return "~".join([diagram.vary, *map(repr, around), name, *map(repr, ends)])


def test_what_is_refused_is_faint_until_it_is_computed_again(explorer):
    explorer.open("model=sliding&p.Nd=0.3")
    explorer.orbit_shown(2)
    curve = explorer.page.locator(f"{DIAGRAM} .plot-canvas")
    expect(curve).to_have_css("opacity", "1")
    explorer.type("Vd", -1)
    expect(curve).to_have_css("opacity", "0.3")
    expect(explorer.page.locator(".specials")).to_have_css("opacity", "0.3")
    expect(explorer.page.locator("#orbit .stage")).to_have_css("opacity", "0.25")
    expect(explorer.page.locator("#orbit-title")).to_contain_text("There is no orbit")
    expect(explorer.page.get_by_role("button", name="From this orbit")).to_be_disabled()
    with explorer.redrawn():
        explorer.type("Vd", 0.7)
    expect(curve).to_have_css("opacity", "1")
    expect(explorer.page.locator("#orbit .stage")).to_have_css("opacity", "1")


@pytest.mark.long
def test_a_model_that_vibrates_by_itself_opens_on_its_cycle(context, tmp_path):
    case = tmp_path / "rayleigh.toml"
    case.write_text(RAYLEIGH)
    with served(case, workers=1) as address:
        explorer = ExplorerPage(context.new_page(), address).open("model=rayleigh")
        title = explorer.page.locator("#orbit-title")
        expect(title).to_contain_text("eps = 0.5: cycle of 6.381\u202fs (0.1567\u202fHz), stable")
        assert explorer.specials()[0] == "HB 0"
        # Cycles of every amplitude at eps = 0 leave the scale to the others.
        assert explorer.ranges()[3] < 2
        explorer.open("model=rayleigh&vary=omega&span=0.2~2")
        expect(title).to_contain_text("ω = 1: cycle of 6.381")
        explorer.page.close()
        assert explorer.faults == []
