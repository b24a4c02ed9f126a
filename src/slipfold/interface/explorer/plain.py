"""What goes to the page as plain data: labels, short numbers, notes of progress."""

from __future__ import annotations

import math
import re
import sys
import unicodedata
from collections.abc import Callable, Sequence
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from slipfold.errors import unknown
from slipfold.interface.explorer.settings import PAGE
from slipfold.models.model import Model
from slipfold.progress import Observer, Progress

Emit = Callable[[dict[str, Any]], None]
"""Takes a view, or a part of it, as plain data."""

Check = Callable[[], None]
"""Raises if what is computed is no longer needed."""

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
"""Commands that choose a font or the size of brackets, which are dropped."""

BELOW = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")

ABOVE = {"dot": "\u0307", "ddot": "\u0308", "bar": "\u0304", "hat": "\u0302", "tilde": "\u0303"}
"""Combining marks that stand above a letter."""


def plain_text(formula: str) -> str:
    r"""Return mathtext as Unicode.

    >>> plain_text(r"$k_1$"), plain_text(r"$\dot x/L$ (1/s)"), plain_text(r"$\alpha$")
    ('k₁', 'ẋ/L (1/s)', 'α')
    """
    text = re.sub(r"\\[,;:!> ]", " ", re.sub(FONTS, "", formula.replace("$", "")))
    text = re.sub(r"\\([A-Za-z]+)", lambda result: LETTERS.get(result[1], result[0]), text)
    for name, mark in ABOVE.items():
        text = re.sub(rf"\\{name}\s*\{{?(\w)\}}?", rf"\g<1>{mark}", text)
    text = re.sub(r"_\{*(\w+)\}*", lambda result: result[1].translate(BELOW), text)
    text = re.sub(r"[{}\\]", "", text)
    return unicodedata.normalize("NFC", text).strip()


SYMBOL = re.compile(r"\$([^_$]+)(?:_\{*(\\?\w+)\}*)?\$(?: (\w+))?")
"""A symbol in mathtext, its subscript, and the part of a structure that it belongs to."""

NUMBERED = re.compile(rf"(v(?=\w+[0-9]))?([A-Za-z]|{SMALL.replace(' ', '|')})([0-9]*)")
"""A name that reads as a symbol: one letter, and perhaps a number; or v and the state it is of."""


def axis_of(model: Model, name: str) -> dict[str, Any]:
    """Describe a parameter, state or output for an axis.

    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
    >>> axis_of(SlidingOscillator(), "alpha")["label"]
    'α'
    """
    quantities: list[Any] = [*model.states, *model.outputs()]
    kinds: list[tuple[Sequence[Any], str]] = [(model.parameters, "symbol"), (quantities, "label")]
    for items, key in kinds:
        labels = [getattr(item, key) for item in items]
        for item, label in zip(items, labels, strict=True):
            if item.name == name:
                alone = label if labels.count(label) == 1 else ""
                return _axis(name, alone, item.unit, item.doc)
    raise unknown(f"{model.name} has no output", name, [item.name for item in quantities])


def formula_of(name: str) -> str:
    r"""Return a name as mathtext where it reads as a symbol.

    >>> formula_of("tau1"), formula_of("w"), formula_of("vx2"), formula_of("speed")
    ('$\\tau_1$', '$w$', '$v_{x2}$', 'speed')
    """
    found = NUMBERED.fullmatch(name)
    if found is None:
        return name
    letter = found[2] if len(found[2]) == 1 else rf"\{found[2]}"
    if found[1]:
        return f"$v_{{{letter}{found[3]}}}$"
    return f"${letter}_{found[3]}$" if found[3] else f"${letter}$"


def _axis(name: str, label: str, unit: str, doc: str) -> dict[str, Any]:
    """Describe a quantity by its label, or by its name where it has none of its own."""
    formula = label.removesuffix(f" ({unit})") or formula_of(name)
    parts = SYMBOL.fullmatch(formula)
    below = [plain_text(part) for part in parts.groups()[1:] if part] if parts else []
    return {
        "name": name,
        "label": plain_text(formula) if label or parts else name,
        "symbol": [plain_text(parts[1]), " ".join(below)] if parts else None,
        "unit": unit,
        "doc": doc,
    }


OPTION = re.compile(r"\(--\w|allow a larger duration")
"""What names an option of the command line or of Python, which a page does not have."""


def without_options(sentence: str) -> str:
    """Return a sentence without the clauses that name options of the command line.

    >>> without_options("touches Vrel = 0; no orbit was found beyond; start there (--start)")
    'touches Vrel = 0; no orbit was found beyond'
    >>> without_options("the duration grew; allow a larger duration to continue")
    'the duration grew'
    """
    parts = sentence.split("; ")
    return "; ".join(part for part in parts if not OPTION.search(part)) or sentence


def short(values: ArrayLike) -> list[float]:
    """Round an array for drawing, relative to its largest value.

    Shapes: values (n,).

    >>> short([1 / 3, 1e-9])
    [0.3333333, 0.0]
    """
    array = np.asarray(values, dtype=float)
    largest = float(np.abs(array).max(initial=0.0))
    if largest == 0.0:
        return [0.0] * len(array)
    decimals = PAGE.digits - 1 - math.floor(math.log10(largest))
    decimals = min(decimals, sys.float_info.max_10_exp)  # of more, rounding would overflow
    rounded: list[float] = (np.round(array, decimals) + 0.0).tolist()
    return rounded


def number(value: float | None) -> float | None:
    """Return a number in full, or None where it is not finite.

    >>> number(float("nan")) is None
    True
    """
    return float(value) if value is not None and math.isfinite(value) else None


def now_and_then(send: Emit, check: Check, note: Callable[[Progress], dict[str, Any]]) -> Observer:
    """Return an observer that sends notes of the progress to the page at intervals."""
    sent = perf_counter()

    def watch(progress: Progress) -> None:
        nonlocal sent
        check()
        if perf_counter() - sent >= PAGE.interval:
            sent = perf_counter()
            send({**note(progress), "done": False})

    return watch
