"""One periodic orbit: in time, as spectrum, with its multipliers."""

from __future__ import annotations

from typing import Any

import numpy as np

from slipfold.attractors.spectrum import find_spectrum
from slipfold.explorer.views.numbers import number, short
from slipfold.flow import flow_of
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.orbits.periodic_orbit import PeriodicOrbit

__all__ = ["orbit_view"]

SAMPLES = 256
"""Samples a forcing period: enough for smooth curves on a large screen."""

LONGEST = 4096
"""Most samples of one orbit."""

PER_PERIOD = 64
"""Samples a forcing period that the spectrum is taken from."""

ORDERS = 8
"""Highest frequency shown, in forcing frequencies."""


def orbit_view(orbit: PeriodicOrbit, vary: str) -> dict[str, Any]:
    """Return an orbit as plain data.

    Parameters
    ----------
    orbit
        The orbit.
    vary
        Parameter of which the value is told.

    Returns
    -------
    dict
        ``t`` in s and ``phase`` in forcing periods, both ends included, ``states`` and ``outputs``
        by name, ``spectrum``, ``multipliers`` as pairs, ``stable``, ``period``, ``value``,
        ``duration`` and ``mechanism``: what to animate, or None.
    """
    model = orbit.model
    flow = flow_of(model)
    time, states = orbit.sample(min(SAMPLES * orbit.period, LONGEST))
    time = np.append(time, orbit.duration)
    states = np.concatenate([states, states[:1]])
    constants = flow.constants_of(model)
    phases = time / constants.period
    values = flow.outputs(states, phases, constants)
    columns = {name: short(values[:, i]) for i, name in enumerate(flow.output_names)}
    names = [state.name for state in model.states]
    return {
        "t": short(time),
        "phase": short(phases),
        "states": {name: columns[name] for name in names},
        "outputs": {name: column for name, column in columns.items() if name not in names},
        "spectrum": _spectrum(orbit),
        "multipliers": [[float(item.real), float(item.imag)] for item in orbit.multipliers],
        "stable": orbit.stable,
        "period": orbit.period,
        "value": number(model.values[vary]),
        "duration": number(orbit.duration),
        "mechanism": {"kind": "sliding"} if isinstance(model, SlidingOscillator) else None,
    }


def _spectrum(orbit: PeriodicOrbit) -> dict[str, Any]:
    spectrum = find_spectrum(orbit, per_period=PER_PERIOD)
    shown = spectrum.order <= ORDERS
    return {
        "frequency": short(spectrum.frequency[shown]),
        "amplitude": {name: short(spectrum.of(name)[shown]) for name in spectrum.names},
    }
