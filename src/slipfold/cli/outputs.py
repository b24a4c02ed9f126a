"""Results handed over: files checked before computing, written after it."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from slipfold.cli.status import note, say
from slipfold.errors import InputError

__all__ = ["Outputs", "hand_over_json"]


class _Result(Protocol):
    def summary(self) -> str: ...

    def to_json(self) -> dict[str, Any]: ...

    def save(self, path: str | Path) -> None: ...


@dataclass(frozen=True)
class Outputs:
    """Where a result goes.

    Parameters
    ----------
    json
        File for JSON; ``"-"`` is standard output.
    out
        File for netCDF.
    csv
        File for comma-separated values.
    """

    json: str | None = None
    out: str | None = None
    csv: str | None = None

    def check(self) -> None:
        """Make sure before computing that all files can be written.

        Raises
        ------
        InputError
            If one cannot, or two are the same.
        """
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

    def write(self, result: _Result) -> None:
        """Write the files; print the summary, or the JSON if that is asked for.

        Parameters
        ----------
        result
            A diagram or a simulation.

        Raises
        ------
        InputError
            If a file cannot be written; the others are.
        """
        writers: list[tuple[str | None, Callable[[str], None]]] = [
            (self.out, result.save),
            (self.csv, getattr(result, "to_csv", _no_table)),
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
    """Write plain data as JSON.

    Parameters
    ----------
    record
        The data.
    path
        The file; ``"-"`` is standard output.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    from slipfold.results.writing import write_file

    text = json.dumps(record, indent=2, allow_nan=False)
    if path == "-":
        say(text)
    else:
        write_file(path, text.encode() + b"\n")


def _no_table(path: str) -> None:
    raise InputError(f"{path} cannot be written: there is no table of this; use --out FILE.nc")
