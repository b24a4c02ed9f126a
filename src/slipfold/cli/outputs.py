"""Results handed over: files checked before computing, written after it."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

from slipfold.cli.status import DONE, FAILED, INTERRUPTED, note, say
from slipfold.errors import InputError

if TYPE_CHECKING:
    from slipfold.results.result import Result


@dataclass(frozen=True)
class Outputs:
    """Where a result goes."""

    json: str | None = None  # file for JSON; ``"-"`` is standard output
    out: str | None = None  # file for netCDF
    csv: str | None = None  # file for comma-separated values

    @property
    def kept(self) -> str:
        """Where to find what an interrupted computation had finished."""
        files = [path for path in (self.out, self.csv, self.json) if path not in (None, "-")]
        if not files:
            return "what was finished is printed; --out FILE.nc would keep it"
        return f"what was finished is in {' and '.join(map(str, files))}"

    def status(self, interrupted: bool, failed: bool = False) -> int:
        """Return the exit status; say so if it is Ctrl-C that ended the computation."""
        if interrupted:
            note(f"interrupted; {self.kept}")
            return INTERRUPTED
        return FAILED if failed else DONE

    def checked(self) -> Self:
        """Return them, made sure before computing that all files can be written."""
        from slipfold.results.writing import check_writable

        paths = [path for path in (self.out, self.csv) if path is not None]
        if self.json not in (None, "-"):
            paths.append(str(self.json))
        seen: set[str] = set()
        for path in paths:
            check_writable(path)
            real = os.path.realpath(path)
            if real in seen and os.path.isfile(real) | (not os.path.exists(real)):
                raise InputError(f"{path} is given for two outputs; give each a file of its own")
            seen.add(real)
        return self

    def write(self, result: Result) -> None:
        """Write the files; print the summary, or the JSON if that is asked for."""
        writers: list[tuple[str | None, Callable[[str], None]]] = [
            (self.out, result.save),
            (self.csv, result.to_csv),
            (self.json, lambda path: hand_over_json(result.to_json(), path)),
        ]
        failures = []
        for path, write in writers:
            if path is not None:
                try:
                    write(path)
                except InputError as error:
                    failures.append(error)
        if self.json != "-":
            say(result.summary())
        for failure in failures[1:]:
            note(str(failure))
        if failures:
            raise failures[0]


def hand_over_json(record: dict[str, Any], path: str) -> None:
    """Write plain data as JSON."""
    from slipfold.results.writing import write_file

    text = json.dumps(record, indent=2, allow_nan=False)
    if path == "-":
        say(text)
    else:
        write_file(path, text.encode() + b"\n")
