"""Tables of the documentation stay on the page, however narrow it is."""

import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
HEADS = ["quantity", "number", "another number", "difference", "source"] * 3


def tables(monkeypatch):
    from slipfold.text import PrintedTable

    monkeypatch.syspath_prepend(str(DOCS / "gallery"))
    monkeypatch.delitem(sys.modules, "comparison", raising=False)
    from comparison import Comparison

    rows = Comparison()
    rows.add("thequantityofinterest", 1.23456789012, "1.2345678901", "10.1016/j.nonlin.2026.01")
    cells = ["0.123456789012"] * len(HEADS)
    printed = PrintedTable(HEADS, [cells])
    text = "\n".join(printed.text())
    return {
        "comparison": rows._repr_html_(),
        "notebook": f"<div class='output_html'>{printed.html('a caption')}</div>",
        "printed": f"<div class='sphx-glr-script-out'><pre>{text}</pre></div>",
    }


@pytest.mark.parametrize("width", [320, 736])
def test_wide_tables_scroll_in_their_own_box(browser, width, monkeypatch):
    style = (DOCS / "static" / "gallery.css").read_text()
    page = browser.new_page(viewport={"width": width, "height": 600})
    for name, html in tables(monkeypatch).items():
        page.set_content(f"<style>{style}</style><article>{html}</article>")
        beyond = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
        assert page.evaluate(beyond) == 0, name
    page.close()
