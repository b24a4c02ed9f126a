"""A study's map leads to the diagrams of its cases."""

import csv

import pytest
from playwright.sync_api import expect

import slipfold as sf
from helpers.explorer_page import ExplorerPage, served, violations

STUDY = {
    "model": "sliding",
    "parameters": {"f": 12.5},
    "compute": {"what": "threshold", "vary": "Nd", "span": [0, 0.06]},
    "cases": {"grid": {"Vd": [0.5, 0.6, 0.7], "mu": [0.4, 0.5]}},
}


@pytest.fixture(scope="module")
def study():
    return sf.study(STUDY)


@pytest.fixture(scope="module")
def opened(context, study, tmp_path_factory):
    study.save(file := tmp_path_factory.mktemp("study") / "case.nc")
    with served(file, workers=1) as address:
        explorer = ExplorerPage(context.new_page(), address)
        explorer.open("model=sliding&p.mu=0.3&show=y&vary=f&span=12.4~12.41&p.f=12.4&p.Nd=0.01")
        yield explorer
        explorer.page.close()


@pytest.fixture
def explorer(opened):
    yield opened
    assert opened.faults == []


def cell(explorer, column, row):
    """Where the middle of a cell of the map is, from the lower left."""
    box = explorer.page.locator(".study-plot .nsewdrag").bounding_box()
    # Values lie at equal distances, and so do cells.
    return box["x"] + box["width"] * (column + 0.5) / 3, box["y"] + box["height"] * (1.5 - row) / 2


def test_a_click_opens_the_diagram_of_a_case_with_the_threshold_that_was_found(explorer, study):
    page = explorer.page
    expect(page.locator("#study")).to_contain_text("threshold over Vd, mu, 6 cases")
    expect(page.locator(".study-plot")).to_have_attribute("data-cases", "6")
    expect(page.locator(".cell.chosen")).to_be_hidden()
    with explorer.redrawn():
        page.mouse.click(*cell(explorer, 2, 0))
    number = next(i for i in range(6) if study.case(i) == {"Vd": 0.7, "mu": 0.4})
    threshold = study.values["threshold"][number]
    assert explorer.specials()[0] == f"PD {threshold:.4g}\u202fN supercritical"
    assert (explorer.parameter("Vd"), explorer.parameter("mu")) == (0.7, 0.4)
    assert explorer.parameter("f") == 12.5
    assert explorer.parameter("Nd") == pytest.approx(threshold, rel=1e-6)
    expect(page.locator(".study-plot .tip")).to_contain_text(f"threshold: {threshold:.4g}")
    expect(page.locator(".cell.chosen")).to_be_visible()
    # What leaves the cases leaves the map without a mark, and can be undone.
    explorer.type("mu", 0.45)
    expect(page.locator(".cell.chosen")).to_be_hidden()
    page.get_by_label("Undo (Ctrl+Z)").click()
    expect(page.locator(".cell.chosen")).to_be_visible()
    assert violations(page, "#study") == []  # last, since it skips what follows


@pytest.mark.long
def test_the_map_and_its_table_are_saved(explorer, study, tmp_path):
    page = explorer.page

    def saved(item):
        page.get_by_label("Export the study").first.click()
        with page.expect_download() as waiting:
            page.locator("#study .menu").get_by_text(item, exact=True).click()
        return waiting.value.path().read_bytes()

    study.to_csv(tmp_path / "study.csv")
    ours, theirs = (
        list(csv.reader(text.splitlines()))
        for text in (saved("CSV").decode(), (tmp_path / "study.csv").read_text())
    )
    assert ours[0] == theirs[0]
    for one, other in zip(ours[1:], theirs[1:], strict=True):
        assert [float(cell) for cell in one[:4]] == [float(cell) for cell in other[:4]]
        assert one[4:] == other[4:]
    assert saved("Picture, PNG").startswith(b"\x89PNG")
    picture = saved("Picture, SVG").decode()
    assert "threshold (N)" in picture
    assert "threshold over Vd, mu, 6 cases" in picture
    items = page.locator("#study .menu [role=menuitem]")
    assert items.all_text_contents() == ["Picture, PNG", "Picture, SVG", "CSV"]
