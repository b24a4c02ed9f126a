"""What was computed again by other means, and whether it agrees: part of every result."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from slipfold.text import OneLine, PrintedTable

ROUNDING = 1e-12
"""Smallest agreement that is reported: the digits below differ from processor to processor."""

LOOSEST = 1e-3
"""Largest difference that an uncertainty may allow: fewer than three digits prove nothing."""

SHOWN = 3
"""Disagreements that the sentence names."""


@dataclass(frozen=True, repr=False)
class Check(OneLine):
    """One part of a result computed again by other means; frozen.

    Parameters
    ----------
    name
        What it is, and where, e.g. ``"PD of branch 1 at Nd = 0.0435789 N"``.
    method
        ``"collocation"``; ``"quadrature"`` where the trajectory alone was compared with its
        equations; ``"other steps"`` where it was integrated again, ``"implicit steps"`` where that
        is the only way; ``"forces"`` where contact forces and events were compared with friction.
    difference
        Largest difference: of states in their scales or as a fraction of the largest of them, of
        durations and multipliers as a share.
        Infinite where it could not be computed again.
    allowed
        What its uncertainty allows, 1e-3 at most.
    what
        What differs: ``"states"``, ``"multipliers"``, or ``"forces"`` of contacts.
    unknown
        Difference of multipliers that cannot be known better, since errors as small as those of
        the states change them as much; 0 where multipliers are compared.
    """

    name: str
    method: str
    difference: float
    allowed: float
    what: str = "states"
    unknown: float = 0.0

    def __post_init__(self) -> None:
        """Allow no difference that leaves hardly a digit."""
        object.__setattr__(self, "allowed", min(self.allowed, LOOSEST))

    @property
    def agrees(self) -> bool:
        """Whether the difference is within its uncertainty."""
        return self.difference <= self.allowed

    def _line(self) -> str:
        verdict = "agrees" if self.agrees else "does not agree"
        return f"{self.name} {verdict}: {self._numbers} by {self.method}"

    def _rows(self) -> PrintedTable:
        rows = [[self.name, self.method, f"{self.difference:.0e}", f"{self.allowed:.0e}"]]
        return PrintedTable(["", "method", "difference", "allowed"], rows, ("", "method"))

    @property
    def _numbers(self) -> str:
        if math.isinf(self.difference):
            return "it cannot be computed again"
        return f"{self.what} differ by {self.difference:.0e}, where {self.allowed:.0e} is allowed,"


@dataclass(frozen=True, repr=False)
class Checked(OneLine):
    """Parts of a result that were computed again by other means; frozen.

    Parameters
    ----------
    checks
        What was checked.
    remark
        What pieces that agree do not prove of the whole trajectory; empty if nothing.
    interrupted
        Whether the computation was interrupted before all was checked.

    Examples
    --------
    >>> import slipfold as sf
    >>> duffing = sf.built_in_models()["duffing"]()
    >>> print(sf.response(duffing, vary="W", span=(0.5, 1.5)).checked)
    checked: 4 of 4 agree to 1e-12
    """

    checks: tuple[Check, ...]
    remark: str = ""
    interrupted: bool = False

    @property
    def count(self) -> int:
        """How many were checked."""
        return len(self.checks)

    @property
    def agreeing(self) -> int:
        """How many of them agree."""
        return sum(check.agrees for check in self.checks)

    @property
    def disagreeing(self) -> tuple[Check, ...]:
        """Those that do not."""
        return tuple(check for check in self.checks if not check.agrees)

    @property
    def agree(self) -> bool:
        """Whether all of them agree."""
        return self.agreeing == self.count

    @property
    def to(self) -> float:
        """Power of ten to which those agree that do; 1e-12 also where they agree to more."""
        largest = max((check.difference for check in self.checks if check.agrees), default=0.0)
        return float(f"1e{math.ceil(math.log10(max(largest, ROUNDING)) - 1e-9)}")

    def __str__(self) -> str:
        """Say it in a sentence."""
        stopped = "; interrupted before the rest" if self.interrupted else ""
        if not self.checks:
            return "checked: nothing, as it was interrupted" if stopped else "checked: nothing"
        result = f"checked: {self.agreeing} of {self.count} agree"
        if self.agreeing:
            result += f" to {self.to:.0e}"
        unknown = [check.unknown for check in self.checks if check.unknown]
        if unknown:
            result += (
                f" (states; multipliers of {len(unknown)} are known to {max(unknown):.0e} only)"
            )
        others = self.disagreeing
        more = f"; {len(others) - SHOWN} more do not agree" if len(others) > SHOWN else ""
        remark = f"; {self.remark}" if self.remark else ""
        named = "".join(f"; {each._line()}" for each in others[:SHOWN])
        return result + named + more + remark + stopped

    def _line(self) -> str:
        return str(self)

    def _rows(self) -> PrintedTable:
        heads = ["", "method", "difference", "allowed", "agrees"]
        rows = [[*check._rows().lines[0], "yes" if check.agrees else "no"] for check in self.checks]
        return PrintedTable(heads, rows, ("", "method", "agrees"))

    def to_json(self) -> dict[str, Any]:
        """Return it as plain data for `json`; a difference that is not finite is None."""
        return {
            "count": self.count,
            "agree": self.agreeing,
            "to": self.to,
            "checks": [
                {
                    **asdict(check),
                    "difference": check.difference if math.isfinite(check.difference) else None,
                    "agrees": check.agrees,
                }
                for check in self.checks
            ],
            **({"remark": self.remark} if self.remark else {}),
            **({"interrupted": True} if self.interrupted else {}),
        }

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> Checked:
        """Make it again from what `to_json` returned."""
        return cls(
            tuple(
                Check(
                    str(item["name"]),
                    str(item["method"]),
                    math.inf if item["difference"] is None else float(item["difference"]),
                    float(item["allowed"]),
                    str(item.get("what", "states")),
                    float(item.get("unknown", 0.0)),
                )
                for item in data["checks"]
            ),
            str(data.get("remark", "")),
            bool(data.get("interrupted", False)),
        )
