"""Formulas of figures as plain text, for a page that sets no mathematics."""

from __future__ import annotations

import re
import unicodedata

__all__ = ["plain_text"]

LETTERS = {
    "alpha": "α",
    "beta": "β",
    "gamma": "γ",
    "delta": "δ",
    "epsilon": "ε",
    "zeta": "ζ",
    "eta": "η",
    "theta": "θ",
    "kappa": "κ",
    "lambda": "λ",
    "mu": "μ",
    "nu": "ν",
    "xi": "ξ",
    "rho": "ρ",
    "sigma": "σ",
    "tau": "τ",
    "phi": "φ",
    "varphi": "φ",
    "chi": "χ",
    "psi": "ψ",
    "omega": "ω",
    "Omega": "Ω",
    "Gamma": "Γ",
    "Delta": "Δ",
    "Lambda": "Λ",
    "cdot": "·",
}

BELOW = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")

ABOVE = {"dot": "\u0307", "ddot": "\u0308", "bar": "\u0304", "hat": "\u0302", "tilde": "\u0303"}
"""Combining marks that stand above a letter."""


def plain_text(formula: str) -> str:
    r"""Return mathtext as Unicode.

    Parameters
    ----------
    formula
        Text with formulas between dollars.

    Examples
    --------
    >>> plain_text(r"$k_1$"), plain_text(r"$\dot x/L$ (1/s)"), plain_text(r"$\alpha$")
    ('k₁', 'ẋ/L (1/s)', 'α')
    """
    text = formula.replace("$", "")
    for name, mark in ABOVE.items():
        text = re.sub(rf"\\{name}\s*\{{?(\w)\}}?", rf"\g<1>{mark}", text)
    text = re.sub(r"\\([A-Za-z]+)", lambda found: LETTERS.get(found[1], found[1]), text)
    text = re.sub(r"_\{?(\w+)\}?", lambda found: found[1].translate(BELOW), text)
    text = re.sub(r"[{}\\]", "", text)
    return unicodedata.normalize("NFC", text).strip()
