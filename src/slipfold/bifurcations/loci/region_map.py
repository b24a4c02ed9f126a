"""Regions of a plane between loci, as data: which stable responses exist in each."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from slipfold.arrays import Array, Indices
from slipfold.read_only import Documented, ReadOnly
from slipfold.text import OneLine, PrintedTable, listed, number_text


@dataclass(frozen=True, repr=False)
class RegionCheck(OneLine, Documented):
    """A simulation at one place of a region, compared with its label."""

    values: Annotated[tuple[float, float], "Values of the two parameters."]
    start: Annotated[
        str,
        '``"rest"``, or the stable orbit whose neighborhood it started in, e.g. ``"period 1"``, '
        'or ``"elsewhere"``: motions from states far off are listed if they find what the label '
        "lacks.",
    ]
    settled: Annotated[
        int,
        "Period in forcing periods of what the motion settled to; 0 if it did not become "
        "periodic, or left the model's limits.",
    ]
    agrees: Annotated[bool, "Whether that fits the label."]
    note: Annotated[str, "A sentence that says what happened."]

    def _line(self) -> str:
        verdict = "agrees" if self.agrees else "disagrees"
        return f"RegionCheck at {_place(self.values)} {self.begins}: {verdict}, {self.note}"

    def _rows(self) -> PrintedTable:
        return PrintedTable(["at", "start", "note"], [_check_row(self)], ("at", "start", "note"))

    @property
    def begins(self) -> str:
        """Where the motion starts, in words."""
        period = self.start.removeprefix("period ")
        far = self.start in ("rest", "elsewhere")
        return f"from {self.start}" if far else f"near the orbit of period {period}"


@dataclass(frozen=True, repr=False)
class RegionMotion(OneLine, Documented):
    """What the motion from the model's start does at one place of a region."""

    values: Annotated[tuple[float, float], "Values of the two parameters."]
    kind: Annotated[
        str,
        '``"periodic"``, ``"torus"``, ``"chaos"``, ``"sticks"``, ``"stopped"`` at a limit of '
        'the model, or ``"undecided"``, as in `slipfold.RegimeMap`.',
    ]
    period: Annotated[int, "Period in forcing periods; 0 of what does not repeat."] = 0
    exponent: Annotated[
        float | None, "Largest Lyapunov exponent, a forcing period, where it was needed; else None."
    ] = None

    def _line(self) -> str:
        return f"RegionMotion at {_place(self.values)}: {self.name}"

    @property
    def name(self) -> str:
        """What it does in words, such as ``"period 4"``."""
        return f"period {self.period}" if self.kind == "periodic" else self.kind


@dataclass(frozen=True, repr=False)
class Region(OneLine, Documented):
    """A connected part of the plane in which the same stable responses exist."""

    id: Annotated[int, "Number within the map, from 1."]
    stable: Annotated[
        tuple[int, ...],
        "Periods of the stable responses, e.g. ``(1, 2)``, or ``(1, 1)`` for two of period 1; "
        "empty if there are none of period 1 or 2. Not to be relied on where the region is not "
        "`known`.",
    ]
    fraction: Annotated[float, "Its fraction of the window's area."]
    place: Annotated[tuple[float, float], "Values of the two parameters well inside it."]
    consistent: Annotated[
        bool,
        "Whether all responses computed across the region agree on its label, and none of them "
        "has a pitchfork inside it.",
    ] = True
    checks: Annotated[
        tuple[RegionCheck, ...],
        "Simulations; one of its `motions` is among them where these contradict its label.",
    ] = ()
    motions: Annotated[
        tuple[RegionMotion, ...],
        "Regimes of simulations in the region, where no response of period 1 or 2 is known to "
        "be stable and regimes were requested.",
    ] = ()
    sticking: Annotated[
        tuple[int, ...],
        "Periods of its stable responses in which contacts stop, as simulations show; empty if "
        "there are none.",
    ] = ()
    stuck: Annotated[
        tuple[float, float],
        "Smallest and largest fraction of the time in which contacts of these responses stick, "
        "over the simulations; zero where they reverse without sticking.",
    ] = (0.0, 0.0)

    def _line(self) -> str:
        agreeing = sum(check.agrees for check in self.checks)
        checked = f", {agreeing} of {len(self.checks)} checks agree" if self.checks else ""
        notes = "" if self.consistent else ", its responses disagree"
        notes += f", {self.regimes_text}" if self.motions else ""
        return (
            f"Region {self.id}: {self.name}, {self.fraction:.1%} of the window, about "
            f"{_place(self.place)}{checked}{notes}"
        )

    def _rows(self) -> PrintedTable:
        heads = ["at", "start", "note"]
        return PrintedTable(heads, [_check_row(check) for check in self.checks], heads)

    @property
    def known(self) -> bool:
        """Whether all responses across it agree on its label, and so does every simulation."""
        return self.consistent and all(check.agrees for check in self.checks)

    @property
    def slipping(self) -> tuple[int, ...]:
        """Periods of those of its stable responses that always slip."""
        left = Counter(self.stable) - Counter(self.sticking)
        return tuple(sorted(left.elements()))

    @property
    def regimes(self) -> dict[str, float]:
        """Fraction of the simulations in each regime, by its name, the most frequent first."""
        counts = Counter(motion.name for motion in self.motions)
        return {name: count / len(self.motions) for name, count in counts.most_common()}

    @property
    def regimes_text(self) -> str:
        """The regimes in words."""
        return ", ".join(
            f"{name} {fraction:.0%}" if fraction >= 0.01 else f"{name} < 1%"
            for name, fraction in self.regimes.items()
        )

    @property
    def name(self) -> str:
        """Which stable responses exist, in words; ``"unknown"`` where that is contradicted.

        That all of them stop may be known where their periods are not.
        """
        if self.known:
            return self.claim
        return f"unknown, {self._stops}" if self.stable and not self.slipping else "unknown"

    @property
    def claim(self) -> str:
        """Which stable responses those that cross it found, in words, right or not."""
        if not self.stable:
            return "none"
        if not self.sticking:
            return self._periods
        which = "" if not self.slipping else " and ".join(map(str, self.sticking)) + " "
        return f"{self._periods}, {which}{self._stops}"

    @property
    def _stops(self) -> str:
        """What stopping contacts do: stick, or reverse where static friction cannot hold them."""
        least, most = self.stuck
        return "sticks" if least > 0 else "reverses or sticks" if most > 0 else "reverses"

    @property
    def _periods(self) -> str:
        if len(set(self.stable)) == len(self.stable):
            periods = " and ".join(str(period) for period in self.stable)
            return f"period {periods}" if len(self.stable) == 1 else f"periods {periods}"
        counts = [(self.stable.count(period), period) for period in sorted(set(self.stable))]
        return ", ".join(f"{count} of period {period}" for count, period in counts)


@dataclass(frozen=True, eq=False, repr=False)
class RegionMap(OneLine, ReadOnly):
    """The regions of a window; frozen."""

    first: Annotated[
        Array,
        "Values of the two parameters at the centers of the cells, shape (n1,) and (n2,).",
    ]
    second: Annotated[Array, ""]
    labels: Annotated[
        Indices,
        "Number of the region each cell belongs to, shape (n2, n1); 0 where the parameters "
        "contradict each other, or no label is known. Strips narrower than a few cells have the "
        "label of what lies beside them.",
    ]
    regions: Annotated[tuple[Region, ...], "The regions, in the order of their numbers."]

    def _line(self) -> str:
        size = f"{len(self.first)} x {len(self.second)} cells"
        names = listed(region.name for region in self.regions)
        return f"RegionMap of {size}, {len(self.regions)} regions: {names}"

    def _rows(self) -> PrintedTable:
        return PrintedTable(
            ["region", "stable", "fraction", "about"],
            [[str(r.id), r.name, f"{r.fraction:.1%}", _place(r.place)] for r in self.regions],
            ("stable",),
        )

    def at(self, first: float, second: float) -> Region | None:
        """Return the region that a place lies in, None where it is not known.

        Parameters
        ----------
        first, second
            Values of the two parameters.
        """
        column = int(np.abs(self.first - first).argmin())
        row = int(np.abs(self.second - second).argmin())
        number = int(self.labels[row, column])
        region = self.regions[number - 1] if number else None
        return region if region is not None and region.known else None


def _place(values: tuple[float, float]) -> str:
    return f"({', '.join(map(number_text, values))})"


def _check_row(check: RegionCheck) -> list[str]:
    return [_place(check.values), check.begins, check.note]
