"""What was computed again by other means, and whether it agrees: part of every result."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, fields
from typing import Annotated, Any

from slipfold.read_only import Documented
from slipfold.text import OneLine, PrintedTable


class CHECKS:
    """What is compared, how closely, and how much work it may take."""

    fraction: float = 0.1  # of the work for a result, which goes into its checks
    shown: int = 3  # disagreements that the sentence names
    rounding: float = 1e-12  # defects and agreements below it differ from processor to processor
    loosest: float = 1e-3  # largest difference that an uncertainty may allow: three digits
    states: float = 1e-8  # difference of states (scaled), durations and multipliers that is allowed
    # Of states that follow others at once, of multipliers on the unit circle, and of those from
    # differences of trajectories, whose step it is as well: the root of the rounding.
    coarse: float = 1e-6
    # Sum of changes on both sides, in scaled states, above which differences are no derivatives:
    # curvature that two steps resolve makes a hundredth of it
    aside: float = 0.01
    loads: int = 64  # phases of a forcing period at one of which a contact is closed, if it ever is
    slopes: float = 1e-10  # defect of the change of a perturbation, which multipliers depend on
    forces: float = 1e-11  # violation of friction: events are met to 1e-14, slow slip ends at 1e-13
    # Fraction of its distance from the unit circle by which a multiplier may be uncertain
    distance: float = 0.01
    secants: int = 10  # steps to where multipliers agree, each of which adds half a digit
    degree: int = 6  # Gauss points a piece: the error falls with the 13th power of its length
    pieces: int = 24  # pieces of a forcing period at least, each compared at 12 points
    max_pieces: int = 2000  # beyond which multipliers are left alone, and a trajectory is not cut
    # Coordinates of all nodes, whose equations are a dense matrix: its singular vectors take 0.5 GB
    max_unknowns: int = 4000
    finest: int = 30_000  # states at all edges of pieces that are halved more than twice
    batch: int = 160  # pieces that are halved at once, the first ones
    # Pieces of several orbits that are compared at once: more save nothing, and an interruption
    # waits for them
    together: int = 500
    condensed: int = 300  # equations of harmonic balance, as many as a point of a stiff branch
    memory: int = 4_000_000  # numbers in the matrices that are stored at a time: 32 MB
    parts: int = 8  # of a stiff orbit, each from a node of its own
    # Exponent by which decays within a part what follows other states at once: 1e-9 of it is left
    follows: float = 20.0
    # Work of checks, in points of a branch of period 1, as measured with 2 to 20 states: an orbit
    # of n states in N pieces takes base + N piece (1 + n / 20). Work is counted, not timed, so that
    # the same is checked on every machine.
    base: float = 0.35
    piece: float = 0.0125
    equilibrium: float = 0.1
    switched: float = 1.0
    beside: float = 1e-6  # arclength from a change of contacts at which rounding meets it no more
    balanced: float = 1.0
    batched: float = 0.25  # work of a point that is followed with those of many other cases
    # The same of a threshold, of one whose whole response was followed, and of a map at least
    threshold: float = 0.1
    followed: float = 6.0
    map: float = 12.0
    restart: float = 0.0137  # fraction of a period at which steps begin again, to fall elsewhere
    # Forcing periods that are integrated again in any case, of brief trajectories, and one in how
    # many of a long one
    again: int = 48
    again_brief: int = 8
    one_in: int = 20
    # Forcing periods below which none is retraced, since one takes the time of thirty; below which
    # only one is, and of what has not settled and is perturbed instead
    brief: int = 400
    short: int = 600
    unsettled: int = 2000
    compared_one_in: int = 200  # periods with stick, of which one is compared with the equations
    calls: tuple[int, ...] = (1, 16, 1024)  # that integrate a period of fast modes, in this order
    long: int = 1000  # forcing periods above which perturbations are followed
    segment: float = 0.006  # length of each perturbed segment, as a fraction of the trajectory
    perturbation: float = 1e-8  # relative to the states
    # Factor, times the length of a segment, by which perturbations grow without sensitivity
    algebraic: float = 2.0
    digits: float = math.log(1e11)  # growth that makes an error of 1e-13 visible


@dataclass(frozen=True, repr=False)
class Check(OneLine, Documented):
    """One part of a result computed again by other means; frozen."""

    name: Annotated[str, 'What it is, and where, e.g. ``"PD of branch 1 at Nd = 0.0435789 N"``.']
    method: Annotated[
        str,
        '``"collocation"``; ``"harmonic balance"`` where modes are too fast for that; '
        '``"quadrature"`` where the trajectory alone was compared with its equations; ``"other '
        'steps"`` where it was integrated again, ``"implicit steps"`` where that is the only '
        'way; ``"forces"`` where contact forces and events were compared with friction.',
    ]
    difference: Annotated[
        float,
        "Largest difference: of states in their scales or as a fraction of the largest of them, "
        "of durations and multipliers as a fraction. Infinite where it could not be computed "
        "again.",
    ]
    allowed: Annotated[float, "What its uncertainty allows, 1e-3 at most."]
    what: Annotated[
        str, 'What differs: ``"states"``, ``"multipliers"``, or ``"forces"`` of contacts.'
    ] = "states"
    unknown: Annotated[
        float,
        "Difference of multipliers that cannot be known better, since errors as small as those "
        "of the states change them as much; 0 where multipliers are compared.",
    ] = 0.0

    def __post_init__(self) -> None:
        """Allow no difference that leaves hardly a digit."""
        object.__setattr__(self, "allowed", min(self.allowed, CHECKS.loosest))

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
class Checked(OneLine, Documented):
    """Parts of a result that were computed again by other means; frozen.

    Examples
    --------
    >>> import slipfold as sf
    >>> duffing = sf.built_in_models()["duffing"]()
    >>> print(sf.response(duffing, vary="W", span=(0.5, 1.5)).checked)
    checked: 4 of 4 agree to 1e-12
    """

    checks: Annotated[tuple[Check, ...], "What was checked."]
    remark: Annotated[
        str, "What pieces that agree do not prove of the whole trajectory; empty if nothing."
    ] = ""
    interrupted: Annotated[
        bool, "Whether the computation was interrupted before all was checked."
    ] = False

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
        return float(f"1e{math.ceil(math.log10(max(largest, CHECKS.rounding)) - 1e-9)}")

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
        more = (
            f"; {len(others) - CHECKS.shown} more do not agree"
            if len(others) > CHECKS.shown
            else ""
        )
        remark = f"; {self.remark}" if self.remark else ""
        named = "".join(f"; {each._line()}" for each in others[: CHECKS.shown])
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
        own, known = {item.name for item in fields(Check)}, {"difference": math.inf}
        checks = (
            Check(**known | {key: each[key] for key in own & each.keys() if each[key] is not None})
            for each in data["checks"]
        )
        remark, stopped = str(data.get("remark", "")), bool(data.get("interrupted", False))
        return cls(tuple(checks), remark, stopped)
