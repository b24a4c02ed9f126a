"""What every peer prints: one JSON line on standard output."""

import argparse
import json
import sys
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from typing import Any, NoReturn

MISSING = 2
FAILED = 3


@dataclass(frozen=True)
class Record:
    """One peer's work, measured.

    ``seconds`` is the wall time of each repeat of each task, without ``build_seconds``, what is
    done once (tracing, compiling, loading). ``solver_seconds`` is the peer's own clock, where it
    has one, and ``processor_seconds`` the time of the processor. A locus is its points (f in Hz,
    Nd in N) in order of f; ``landed`` are those of its points on which accuracy is compared,
    ``named`` those found on the way, with their names.
    """

    peer: str
    version: str
    settings: dict[str, Any]
    build_seconds: float
    seconds: dict[str, list[float]]
    solver_seconds: dict[str, list[float]] | None = None
    processor_seconds: dict[str, list[float]] | None = None
    specials: dict[str, list[tuple[str, float]]] = field(default_factory=dict)
    points: dict[str, int] = field(default_factory=dict)
    reached: dict[str, float] = field(default_factory=dict)
    final_state: dict[str, list[float]] = field(default_factory=dict)
    seconds_per_point: dict[str, float] = field(default_factory=dict)
    locus: list[tuple[float, float]] = field(default_factory=list)
    landed: list[tuple[float, float]] = field(default_factory=list)
    named: list[tuple[str, float, float]] = field(default_factory=list)

    def print(self) -> None:
        """Write the record to standard output, fields without content left out."""
        print(
            json.dumps(
                {key: value for key, value in asdict(self).items() if value not in (None, {}, [])}
            )
        )


def arguments(
    description: str, presets: Iterable[str] = (), systems: Iterable[str] = ()
) -> argparse.Namespace:
    """Parse the command line; the first preset is the default, and so is the first system."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument(
        "--repeat", type=int, default=5, help="timed repeats of each task (default 5)"
    )
    names = list(presets)
    if names:
        parser.add_argument("--settings", choices=names, default=names[0])
    kinds = list(systems)
    if kinds:
        parser.add_argument("--system", choices=kinds, default=kinds[0])
    return parser.parse_args()


def leave(status: int, sentence: str) -> NoReturn:
    """Say why in one sentence on standard error, and exit."""
    print(sentence, file=sys.stderr)
    raise SystemExit(status)
