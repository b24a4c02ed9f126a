"""Structures of many degrees of freedom with one contact, in the report."""

from __future__ import annotations

from collections.abc import Iterator
from statistics import median
from typing import Any

from slipfold.interface.paper.tables import table
from wording import magnitude, milliseconds, verdict

Records = dict[str, dict[str, Any]]

REFERENCE = "harmonic balance, fine"
"""Its harmonics are three times as many as those of the programs that are compared."""

DRY = "slipfold, dry"
"""What time stepping is compared with: at one frequency its difference falls from 5e-4 with 1000
steps a period to 3e-4 with 4000 and 4e-5 with 16,000."""

SECONDS, POINT, GROWTH, FASTER, FREQUENCIES = 1, 5, 2, 10, 121
"""Aims: of a response in s, a point in ms, its growth with the size, beside harmonic balance, which
takes so many frequencies for the response."""


def used(record: dict[str, Any], size: str) -> float:
    """Processor seconds of a response."""
    return float(median(record["processor_seconds"][size]))


def error(record: dict[str, Any], reference: dict[str, Any], size: str) -> float:
    """Largest relative error of the first harmonic at the tip."""
    pairs = zip(record["final_state"][size], reference["final_state"][size], strict=True)
    return max(abs(one / other - 1) for one, other in pairs)


def rows(records: Records, *, dry: bool = False) -> Iterator[list[str]]:
    """One row a program and size."""
    reference = records.get(DRY if dry else REFERENCE)
    for who, record in records.items():
        for size, points in record["points"].items():
            if who == REFERENCE or ("dry" in who) != dry:
                continue
            once = record["settings"].get(size, {})
            yield [
                size,
                who,
                str(once.get("modes", "")),
                f"{once['built']:.2g}" if once else "",
                str(points),
                f"{used(record, size):.2g}",
                milliseconds(each(record, size)),
                ""
                if who == DRY
                else magnitude(error(record, reference, size))
                if reference and "final_state" in record
                else "?",
            ]


HEADS = ("DOF", "", "modes", "once s", "points", "response s", "a point, ms", "error")


def section(records: Records) -> list[str]:
    """The section of the report."""
    return ["## Structures", *tables(records)]


def tables(records: Records) -> list[str]:
    """Its tables with what they show, for the benchmarks page too."""
    smooth, dry = (
        sorted(rows(records, dry=dry), key=lambda row: int(row[0])) for dry in (False, True)
    )
    return [
        "A clamped strip of plane finite elements with a force and regularized friction at its "
        "tip, within 15 % of its lowest frequency: processor time, one thread. slipfold finds "
        "stability and bifurcations too. The error is that of the tip's first harmonic at three "
        "frequencies, from 75 harmonics with the full matrices. pyHarm has 7 harmonics and another "
        "law, elastic Coulomb friction.",
        table([*HEADS], smooth),
        "With Coulomb's law itself, where the tip sticks and slips: slipfold beside time stepping "
        "to three steady states, without stability. The error is the difference from slipfold's.",
        table([*HEADS], dry),
    ]


def each(record: dict[str, Any], size: str) -> float:
    """Processor seconds of a point."""
    return used(record, size) / float(record["points"][size])


def aim_rows(records: Records) -> Iterator[list[str]]:
    """Every aim beside what was measured."""
    ours, plain = records["slipfold"], records.get("harmonic balance")
    smallest, *_, largest = ours["points"]
    of = f"the response of {largest} degrees of freedom"
    took, point = used(ours, largest), each(ours, largest)
    yield [f"{of} in {SECONDS} s", f"{took:.2g} s", verdict(took < SECONDS)]
    yield [f"{of}, {POINT} ms a point", f"{1e3 * point:.2g} ms", verdict(1e3 * point < POINT)]
    ratio = point / each(ours, smallest)
    yield [f"a point there costs {GROWTH} times one of {smallest} at most", f"{ratio:.2g} times",
           verdict(ratio < GROWTH)]  # fmt: skip
    for size in ours["points"] if plain else ():
        faster = each(plain, size) * FREQUENCIES / used(ours, size)
        yield [f"{FASTER} times faster than harmonic balance, {size} degrees of freedom",
               f"{faster:.2g} times", verdict(faster >= FASTER)]  # fmt: skip
