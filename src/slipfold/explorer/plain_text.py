"""Formulas of figures as plain text, for a page that sets no mathematics."""

from __future__ import annotations

import re
import unicodedata

SMALL = "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi omicron pi rho"
SMALL += " sigma tau upsilon phi chi psi omega"

LETTERS = {
    **dict(zip(SMALL.split(), "αβγδεζηθικλμνξοπρστυφχψω", strict=True)),
    **dict(zip(SMALL.title().split(), "ΑΒΓΔΕΖΗΘΙΚΛΜΝΞΟΠΡΣΤΥΦΧΨΩ", strict=True)),
    "varepsilon": "ε",
    "varphi": "φ",
    "vartheta": "ϑ",
    "varrho": "ϱ",
    "varpi": "ϖ",
    "varsigma": "ς",
    "varkappa": "ϰ",
    "cdot": "·",
    "times": "×",
    "pm": "±",
    "infty": "∞",
}
"""What commands of formulas stand for."""

FONTS = r"\\(?:math\w+|text\w*|operatorname|left|right|rm|it|bf|sf)\b\s*"
"""Commands that choose a font or the size of brackets, and say nothing."""

BELOW = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")

ABOVE = {"dot": "\u0307", "ddot": "\u0308", "bar": "\u0304", "hat": "\u0302", "tilde": "\u0303"}
"""Combining marks that stand above a letter."""


def plain_text(formula: str) -> str:
    r"""Return mathtext as Unicode.

    >>> plain_text(r"$k_1$"), plain_text(r"$\dot x/L$ (1/s)"), plain_text(r"$\alpha$")
    ('k₁', 'ẋ/L (1/s)', 'α')
    """
    text = re.sub(r"\\[,;:!> ]", " ", re.sub(FONTS, "", formula.replace("$", "")))
    text = re.sub(r"\\([A-Za-z]+)", lambda found: LETTERS.get(found[1], found[0]), text)
    for name, mark in ABOVE.items():
        text = re.sub(rf"\\{name}\s*\{{?(\w)\}}?", rf"\g<1>{mark}", text)
    text = re.sub(r"_\{*(\w+)\}*", lambda found: found[1].translate(BELOW), text)
    text = re.sub(r"[{}\\]", "", text)
    return unicodedata.normalize("NFC", text).strip()
