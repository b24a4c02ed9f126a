"""The locus of period doubling in the report."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import reference
from slipfold.interface.paper.tables import table
from wording import magnitude, milliseconds, task_seconds, verdict

FASTER = {"reliable": 5, "largest": 2.5, "fine": 15}
"""Times as fast a point, by the settings of the peer."""

Records = dict[str, dict[str, Any]]


def a_point(record: dict[str, Any]) -> float:
    """Median time in seconds over the number of points."""
    return float(record["seconds_per_point"]["locus"])


def error_of(record: dict[str, Any]) -> str:
    """Largest error in Nd at the frequencies of the reference."""
    error = reference.locus_error(record["landed"])
    return "a frequency missed" if error is None else magnitude(error)


def rows(loci: Records) -> Iterator[list[str]]:
    """Times, points and errors."""
    ours = loci["slipfold"]
    for name, record in loci.items():
        took = task_seconds(record, "locus")
        yield [
            name.split(", ")[0],
            record["settings"]["name"],
            str(record["points"]["locus"]),
            milliseconds(took),
            milliseconds(a_point(record)),
            f"{a_point(record) / a_point(ours):.2g}",
            f"{took / task_seconds(ours, 'locus'):.2g}",
            error_of(record),
        ]


def described(name: str, f: float, Nd: float) -> str:
    """A point found on the way, and its distance from the reference."""
    text = f"{name} at {f:.7g} Hz, {Nd:.7g} N"
    errors = reference.named_errors(name, f, Nd)
    if errors is None:
        return text
    return f"{text} (errors {magnitude(errors[0])} Hz, {magnitude(errors[1])} N)"


def on_the_way(loci: Records) -> str:
    """What each program reports besides the points themselves."""
    ours = [described(*found) for found in loci["slipfold"].get("named", [])]
    sentences = [f"slipfold reports on the way: {'; '.join(ours) or 'nothing'}."]
    for name, record in loci.items():
        if name != "slipfold":
            found = [kind for kind, _ in record.get("specials", {}).get("locus", [])]
            sentences.append(f"{name}: {', '.join(found) or 'nothing'}.")
    return " ".join(sentences)


def section(loci: Records) -> list[str]:
    """The section of the report."""
    places = ", ".join(f"{f:g}" for f in reference.LOCUS)
    return [
        "## The period-doubling locus",
        "The PD of period 1 in the plane (f, Nd), from 12.5 Hz down to 11.5 and up to 13.5 Hz. "
        "Processor time in ms on one thread, warm; AUTO-07p's by its own clock, which counts the "
        "same. Not in it: the response that gives the PD, and AUTO-07p's run to its eigenfunction. "
        "slipfold's includes the normal form at every point. Ratios are to slipfold's time: above "
        "1, slipfold is faster. "
        f"The error is the largest in Nd, in N, at {places} Hz; AUTO-07p's is that of its mesh, "
        "from a run apart with short steps.",
        table(
            [
                "",
                "settings",
                "points",
                "ms",
                "ms a point",
                "ratio a point",
                "ratio, whole locus",
                "error",
            ],
            list(rows(loci)),
        ),
        "`reliable`: the longest steps with which AUTO-07p loses no frequency it is asked to land "
        "on, whatever its first step. `largest`: the fastest that is right to 2e-8 N. `fine`: mesh "
        "and tolerances for accuracy.",
        on_the_way(loci),
    ]


def aim_rows(loci: Records) -> Iterator[list[str]]:
    """The aim beside what was measured, for each of the peer's settings."""
    ours = a_point(loci["slipfold"])
    for name, record in loci.items():
        if name != "slipfold":
            ratio, faster = a_point(record) / ours, FASTER[record["settings"]["name"]]
            yield [
                f"locus: {faster} times faster a point than {name}",
                f"{ratio:.2g} times",
                verdict(ratio >= faster),
            ]


def brief(loci: Records) -> str:
    """The table for the benchmarks page."""
    shown = [
        [name, f"{row[3]} ms", row[2], f"{row[4]} ms", row[5], f"{row[7]} N"]
        for name, row in zip(loci, rows(loci), strict=True)
    ]
    head = ["PD locus, 11.5 to 13.5 Hz", "time", "points", "a point", "ratio a point"]
    return table([*head, "largest error"], shown)
