"""The reference values handed over with the design, and the runs that are compared with them."""

import json
import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from slipfold import Newton, Settings, SlidingOscillator, Steps
from slipfold.bifurcations.branches.response import trace_response

FILE = Path(__file__).parents[1] / "reference" / "sliding.json"
DATA = json.loads(FILE.read_text())


class Digits(float):
    """A number that knows the unit of its last printed digit."""

    def __new__(cls, text):
        number = super().__new__(cls, text)
        number.unit = 10.0 ** -len(text.partition(".")[2])
        return number


PRINTED = json.loads(FILE.read_text(), parse_float=Digits)
"""The same data; the numbers with their digits."""


@dataclass(frozen=True)
class Case:
    """One curve: what is varied over which span with which parameters, and what is expected."""

    vary: str
    span: tuple[float, float]
    values: tuple[tuple[str, float], ...]
    period1: tuple
    period2: tuple

    def __str__(self):
        """Identify the test."""
        return f"{self.vary}," + ",".join(f"{name}={value:.4g}" for name, value in self.values)

    @property
    def model(self):
        return SlidingOscillator(**dict(self.values))

    @property
    def reverse(self):
        return self.span[::-1]


def model_values(given):
    values = {name: float(value) for name, value in given.items() if name != "alpha_deg"}
    if "alpha_deg" in given:
        values["alpha"] = math.radians(given["alpha_deg"])
    return values


def _cases():
    for kind, vary in (("force_response", "Nd"), ("frequency_response", "f")):
        for item in PRINTED[kind]:
            values = model_values(item["set"])
            span = (0.0, 0.98 * values.get("Ns", 1.0)) if vary == "Nd" else (11.0, 14.0)
            yield Case(
                vary,
                span,
                tuple(values.items()),
                tuple(tuple(entry) for entry in item["period1"]),
                tuple(tuple(entry) for entry in item["period2"]),
            )


CASES = tuple(_cases())


@lru_cache(maxsize=128)
def traced(case, span=None, largest=0.5, tolerance=1e-10):
    """Run one reference case; the branches are immutable, so that tests share them."""
    settings = Settings(newton=Newton(tolerance=tolerance), steps=Steps(largest=largest))
    return trace_response(case.model, case.vary, span or case.span, settings=settings)


def specials(branches, period=None):
    """Type, value and criticality of the special points in the order of their values."""
    return sorted(
        ((item.type, item.value, item.criticality) for branch in branches
         if period in (None, branch.period) for item in branch.special),
        key=lambda item: item[1],
    )  # fmt: skip
