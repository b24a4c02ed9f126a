"""Every built-in model, and models of a user's kind, go through every panel and every way out."""

import re
from pathlib import Path
from urllib.parse import urlencode

import pytest
from playwright.sync_api import expect

import slipfold as sf
from helpers.explorer_models import RAYLEIGH
from helpers.explorer_page import DIAGRAM, ORBIT, PLANE, ExplorerPage, served
from helpers.long_tests import long_except

UNDER_WAY = "([selector, first]) => document.querySelector(selector).textContent !== first"
"""Whether the server has taken the request for the plane: it tells of progress, or is done."""


FILES = {item.stem: item for item in sorted(Path(__file__).parents[1].glob("models/*.toml"))}
"""Two that nothing forces, ten masses, friction with memory, a stiff one."""

OFTEN = ("stuart-landau",)
"""A cycle, beside the forced oscillators and the equilibrium that other tests show."""


@pytest.mark.parametrize("name", long_except((*sf.built_in_models(), *FILES), OFTEN))
def test_every_model_goes_through_every_panel(explorer, name):
    page = explorer.page
    own = FILES.get(name)
    explorer.open(
        urlencode({"model": f"own {name}", "text": own.read_text()} if own else {"model": name})
    )
    assert page.locator("header select").input_value() == (f"own {name}" if own else name)
    alert = page.get_by_role("alert")
    expect(alert).to_have_count(0)
    assert explorer.traces()
    page.wait_for_selector(f"{ORBIT}[data-drawn]:not(.empty)")
    expect(page.locator("#orbit-title")).to_contain_text("stable")
    expect(page.locator(".smalls .small:visible .dot")).not_to_have_count(0)
    page.get_by_role("button", name="From rest").click()
    page.wait_for_selector("#plot-settling .dot", state="attached")
    expect(page.locator(".verdict")).not_to_be_empty()
    plane = page.get_by_role("button", name="Plane", exact=True)
    if explorer.page.locator(".parameters .parameter").count() > 1:
        plane.click()
        expect(page.locator(f"{PLANE} .xtitle")).to_be_visible()
        page.wait_for_function(UNDER_WAY, arg=[".progress span", "Computing the bifurcation set…"])
        assert alert.all_inner_texts() == []
        leave(page, "plane", ["Picture, SVG"])
        plane.click()
    expect(page.locator(PLANE)).to_be_hidden()
    assert alert.all_inner_texts() == []
    if own:
        page.get_by_role("button", name="Torus or chaos?").click()
        expect(page.locator(".exponents strong")).not_to_be_empty()
        page.get_by_role("button", name="Compute the basins").click()
        expect(page.locator(".basins-plot")).to_have_attribute("data-points", re.compile(r"\d"))
        page.get_by_role("button", name="Edit the model").click()
        page.get_by_role("button", name="Equations").click()
        expect(page.locator(".equations td")).not_to_have_count(0)
        page.get_by_role("button", name="Text", exact=True).click()
        page.get_by_role("button", name="Close the editor").click()
    ways_out = [] if name in OFTEN else ["diagram", "orbit", "simulation"]
    for panel in ways_out:
        leave(page, panel)
    assert alert.all_inner_texts() == []


FILES_OF = ("Picture, PNG", "Picture, SVG", "CSV", "netCDF")


def leave(page, panel, files=FILES_OF):
    """Take every way out of a panel, with some of its files."""
    menu = page.locator(f"#{panel} .menu")

    def choose(item):
        page.get_by_label(f"Export the {panel}").first.click()
        menu.get_by_text(item, exact=True).click()

    for item in files:
        with page.expect_download() as waiting:
            choose(item)
        assert waiting.value.path().stat().st_size > 100
    for item in ("Copy as Python", *(["Copy as TOML"] if panel != "orbit" else [])):
        choose(item)
        copied(page, item)


def copied(page, item):
    """Read what was copied, and close its dialog."""
    dialog = page.locator(".text-dialog")
    expect(dialog).to_be_visible()
    text = dialog.locator("pre").inner_text()
    if item == "Copy as Python":
        compile(text, "copied.py", "exec")
    dialog.get_by_role("button", name="Close").click()


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
