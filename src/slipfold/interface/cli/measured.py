"""What ``slipfold measure``, ``fit`` and ``plan`` read and write in their own way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from slipfold.declarations import Option
from slipfold.interface.cli.commands import FILES, Reader, argument, optional
from slipfold.interface.cli.interruption import deferred_interrupts
from slipfold.interface.cli.reading import parse_whole
from slipfold.interface.cli.running import (
    DONE,
    FAILED,
    INTERRUPTED,
    Outputs,
    live_line,
    note,
    reporter,
    say,
)
from slipfold.progress import Progress


def _read_data(texts: Any, values: Any) -> dict[str, Any]:
    from slipfold.parameter_space.measurement import read_measurement

    return {"measurement": read_measurement(texts["data"], values["model"])}


MEASUREMENT = Reader(
    (
        argument(
            "DATA.csv",
            "Measurements with units in the head, e.g. 'Nd [N], max y [mm]'; also 'error of max y "
            "[mm]' and sweep.",
            "data",
        ),
    ),
    _read_data,
)


class MeasurementFile(Outputs):
    """The file of a measurement; standard output if there is none."""

    def status_of(self, compute: Callable[..., Any]) -> int:
        """Measure, write what there is and return the exit status."""
        from slipfold.parameter_space.measurement import csv_of
        from slipfold.writing import write_file

        total = 0
        with live_line() as show, deferred_interrupts() as check:
            report = reporter(show, check)

            def observe(progress: Progress) -> None:
                nonlocal total
                total = progress.total or 0
                report(progress)

            result = compute(on_progress=observe)
            given = compute.keywords if isinstance(compute, partial) else {}
            remarks = [repr(given["model"]), f"swept {given['sweep']} over {given['vary']}"]
            if result.stopped is not None:
                remarks.append(f"stopped early: {result.stopped}")
            text = csv_of(result, remarks)
            if self.csv is None:
                say(text.rstrip())
            else:
                write_file(self.csv, text.encode())
                note(f"wrote {self.csv}")
        if result.stopped is not None:
            note(f"stopped early: {result.stopped}; {len(result)} of {total} measurements are kept")
            return FAILED
        if len(result) < total:
            note(f"interrupted after {len(result)} of {total} measurements, which are kept")
            return INTERRUPTED
        return DONE


MEASUREMENT_FILE = Reader(
    optional(csv=Option("Write the measurements there, else they are printed.", metavar="FILE")),
    lambda texts, _: {"outputs": MeasurementFile(csv=texts["csv"]).checked()},
)


@dataclass(frozen=True)
class PlanFiles(Outputs):
    """The files of a plan of measurements, and how many of its values are chosen."""

    best: int | None = None

    def status_of(self, compute: Callable[..., Any]) -> int:
        """Plan, choose the best values, write the result and return the exit status."""
        with live_line():
            result = compute()
        if self.best is None:
            self.write(result)
            return DONE
        result = result.select(result.best(self.best))
        self.write(result)
        if self.json != "-":
            say(f"best at {result.vary} = {', '.join(f'{value:.6g}' for value in result.values)}")
        return DONE


def _read_plan_files(texts: Any, values: Any) -> dict[str, Any]:
    best = None if texts["best"] is None else parse_whole(texts["best"], "--best")
    return {"outputs": PlanFiles(texts["json"], texts["out"], texts["csv"], best).checked()}


PLAN_FILES = Reader(
    (
        *FILES,
        *optional(
            best=Option("Choose the N most informative values, and plan these alone.", metavar="N")
        ),
    ),
    _read_plan_files,
)
