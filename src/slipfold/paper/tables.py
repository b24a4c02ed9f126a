"""Small tables in Markdown."""

from __future__ import annotations

from collections.abc import Sequence


def number(value: float | None, missing: str = "none") -> str:
    """Return a number with six digits, or what stands for none.

    >>> number(0.043578911491), number(None)
    ('0.0435789', 'none')
    """
    return missing if value is None else f"{value:.6g}"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table.

    >>> print(table(["f (Hz)", "PD"], [["12.5", "0.0436"]]))
    | f (Hz) | PD |
    |---|---|
    | 12.5 | 0.0436 |
    """
    lines = [head, ["---"] * len(head), *rows]
    joined = ["| " + " | ".join(line) + " |" for line in lines]
    joined[1] = "|" + "---|" * len(head)
    return "\n".join(joined)
