"""Tables as text for terminals and as HTML for notebooks."""

from __future__ import annotations

import html
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class PrintedTable:
    """Cells of text under heads."""

    heads: Sequence[str]  # heads of the columns
    lines: Sequence[Sequence[str]]  # the lines, as many cells each as there are heads
    # Heads of the columns that hold words, which stand to the left; numbers stand to the right
    words: Collection[str] = ()

    def text(self) -> list[str]:
        """Return it as lines of text, the heads first."""
        columns = zip(self.heads, *self.lines, strict=True)
        widths = [max(len(cell) for cell in column) for column in columns]
        return [
            "  ".join(
                cell.ljust(width) if head in self.words else cell.rjust(width)
                for head, cell, width in zip(self.heads, line, widths, strict=True)
            ).rstrip()
            for line in [self.heads, *self.lines]
        ]

    def html(self, caption: str) -> str:
        """Return it as an HTML table."""
        body = "".join(_html_line(line, "td") for line in self.lines)
        return (
            f"<table><caption>{html.escape(caption)}</caption>"
            f"<thead>{_html_line(self.heads, 'th')}</thead><tbody>{body}</tbody></table>"
        )


def _html_line(cells: Sequence[str], tag: str) -> str:
    inside = "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells)
    return f"<tr>{inside}</tr>"


def html_list(sentences: Iterable[str]) -> str:
    """Return sentences as an HTML list."""
    return f"<ul>{''.join(f'<li>{html.escape(text)}</li>' for text in sentences)}</ul>"


def with_unit(text: str, unit: str) -> str:
    """Return text with a unit behind it, if there is one."""
    return f"{text} {unit}".rstrip()
