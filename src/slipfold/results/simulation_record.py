"""The outcome of a simulation in text, and as plain data for JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from slipfold.results.checked_parts import checked_lines, checked_record
from slipfold.results.record import number, numbers, record_head
from slipfold.results.simulation_table import SCHEMA

if TYPE_CHECKING:
    from slipfold.attractors.spectrum import Spectrum
    from slipfold.results.simulation import Simulation

__all__ = ["simulation_record", "simulation_summary"]

HIGHEST = 3
"""Multiples of the forcing frequency shown."""


def simulation_record(motion: Simulation) -> dict[str, Any]:
    """Return last state, settlement and, if it settled, amplitudes of the states."""
    settlement, stopped = motion.settlement, motion.stopped
    spectrum = _response_spectrum(motion)
    return {
        **record_head(SCHEMA, motion.model),
        "periods": motion.periods,
        "initial_state": numbers(motion.strobe[0]),
        "state": numbers(motion.strobe[-1]),
        "settled": settlement.settled,
        "kind": settlement.kind,
        "period": settlement.period,
        "duration": None if settlement.duration is None else number(settlement.duration),
        "drift": number(settlement.drift),
        "message": settlement.message,
        "spectrum": None if spectrum is None else _spectrum_record(motion, spectrum),
        "stopped": None
        if stopped is None
        else {"kind": stopped.kind, "reason": stopped.reason, "time": number(stopped.time)},
        **checked_record(motion.checked),
    }


def _response_spectrum(motion: Simulation) -> Spectrum | None:
    """Return the spectrum over one response period; None if there is none, or nothing moves."""
    period = motion.settlement.period
    still = motion.settlement.kind == "equilibrium"
    return None if period is None or still else motion.spectrum(period)


def _lines(spectrum: Spectrum) -> int:
    return HIGHEST * spectrum.periods + 1


def _spectrum_record(motion: Simulation, spectrum: Spectrum) -> dict[str, Any]:
    count = _lines(spectrum)
    return {
        "frequency": numbers(spectrum.frequency[:count]),
        "amplitude": {
            state.name: numbers(spectrum.of(state.name)[:count]) for state in motion.model.states
        },
    }


def simulation_summary(motion: Simulation) -> str:
    """Return the outcome as lines of text."""
    names = [state.name for state in motion.model.states]
    state = ", ".join(
        f"{name} = {value:.12g}" for name, value in zip(names, motion.strobe[-1], strict=True)
    )
    message = motion.settlement.message
    forced = motion.model.forced
    length = f"{motion.duration:.6g} s"
    lines = [
        f"{motion.model!r} over "
        + (f"{motion.periods} forcing periods ({length})" if forced else length),
        message[:1].upper() + message[1:],
        f"Last state{' at phase zero' if forced else ''}: {state}",
    ]
    spectrum = _response_spectrum(motion)
    if spectrum is not None:
        lines += ["", f"{'Hz':>12}" + "".join(f"{name:>14}" for name in names)]
        for index in range(_lines(spectrum)):
            values = [spectrum.of(name)[index] for name in names]
            # Lines of rounding errors are no lines.
            cells = "".join(f"{value if abs(value) > 1e-12 else 0:14.8g}" for value in values)
            lines.append(f"{np.round(spectrum.frequency[index], 9):12.8g}" + cells)
    return "\n".join([*lines, *checked_lines(motion.checked)])
