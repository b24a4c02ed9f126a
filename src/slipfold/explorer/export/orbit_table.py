"""One orbit as a spreadsheet and as labelled arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.flow import flow_of
from slipfold.models.model import Model
from slipfold.models.output import Output
from slipfold.models.parameter import State
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.results.csv_text import csv_text, with_unit
from slipfold.results.labelled_table import LabelledTable, Variable

__all__ = ["orbit_csv", "orbit_table"]

SAMPLES = 256
"""Samples a forcing period."""


def orbit_csv(orbit: PeriodicOrbit) -> str:
    """Return time, states and outputs over one period, one row an instant.

    Parameters
    ----------
    orbit
        The orbit.
    """
    time, values = _sampled(orbit)
    heads = ["time (s)", *(with_unit(item) for item in _quantities(orbit.model))]
    return csv_text(heads, np.column_stack([time, values]).tolist())


def orbit_table(orbit: PeriodicOrbit) -> LabelledTable:
    """Return time, states and outputs over one period, and the multipliers.

    Parameters
    ----------
    orbit
        The orbit.
    """
    time, values = _sampled(orbit)
    variables = {"time": Variable(("time",), time, {"long_name": "time", "units": "s"})}
    for item, column in zip(_quantities(orbit.model), values.T, strict=True):
        attributes = {"long_name": item.doc or item.name, "units": item.unit or "1"}
        variables[item.name] = Variable(("time",), np.ascontiguousarray(column), attributes)
    for part, numbers in (("real", orbit.multipliers.real), ("imag", orbit.multipliers.imag)):
        attributes = {"long_name": f"Floquet multipliers, {part} part", "units": "1"}
        variables[f"multipliers_{part}"] = Variable(
            ("multiplier",), np.ascontiguousarray(numbers), attributes
        )
    return LabelledTable(variables, ("time",), _attributes(orbit.model, orbit))


def _quantities(model: Model) -> list[State | Output]:
    return [*model.states, *model.outputs()]


def _sampled(orbit: PeriodicOrbit) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    flow = flow_of(orbit.model)
    constants = flow.constants_of(orbit.model)
    time, states = orbit.sample(SAMPLES * orbit.period)
    return time, flow.outputs(states, time / constants.period, constants)


def _attributes(model: Model, orbit: PeriodicOrbit) -> dict[str, float | int | str]:
    values = {f"parameter_{name}": value for name, value in model.values.items()}
    return {"title": f"periodic orbit of {model.name}", "period": orbit.period, **values}
