"""Why a curve begins or ends where it does."""

from __future__ import annotations

from dataclasses import dataclass
from textwrap import shorten

from slipfold.text import number_text

SHOWN = 95
"""Characters of a line that shows an end; its reason is a sentence of any length."""


@dataclass(frozen=True, init=False, repr=False)
class End:
    """Why a branch or a locus begins or ends where it does.

    Parameters
    ----------
    kind
        One word for programs: ``"span"``, ``"window"``, ``"limit"``, ``"closed"``, ``"event"``,
        ``"failed"``, ``"unresolved"``, ``"points"``, ``"interrupted"``, ``"codimension-2"``,
        ``"homoclinic"``, ``"heteroclinic"``, ``"duration"``, ``"family"``; ``"bifurcation"`` where
        it emanates from another; ``"contradiction"`` where it turns, or the stability changes, at
        no located point; of tori also ``"settled"``, ``"resonance"``, ``"broken"``, ``"contacts"``.
    reason
        A sentence that says what happened and what can be done.
    values
        Value of the parameter there, or of both along a locus; a single number is taken as well.
    """

    kind: str
    reason: str
    values: tuple[float, ...]

    def __init__(self, kind: str, reason: str, values: float | tuple[float, ...]) -> None:
        for name, value in (("kind", kind), ("reason", reason)):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "values", values if isinstance(values, tuple) else (values,))

    def __repr__(self) -> str:
        """One line: the kind, the place and as much of the reason as there is room for."""
        line = f"{self.kind} at {', '.join(map(number_text, self.values))}: {self.reason}"
        return f"<End: {shorten(line, SHOWN - 7, placeholder=' ...')}>"

    def __str__(self) -> str:
        """Return the sentence."""
        return self.reason

    @property
    def value(self) -> float:
        """Value of the parameter, the first of two."""
        return self.values[0]

    @property
    def early(self) -> bool:
        """Whether the curve was given up or contradicts what was found on it."""
        return self.kind in ("failed", "points", "contradiction")
