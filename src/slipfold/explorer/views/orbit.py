"""One periodic orbit: in time, as spectrum, with its multipliers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.explorer.views.numbers import number, short
from slipfold.flow import flow_of
from slipfold.long_term.spectrum import find_spectrum
from slipfold.models.evaluation import evaluation_of
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.models.turns import TURN
from slipfold.orbits.eigenvalues import eigenvalues_of
from slipfold.orbits.periodic_orbit import PeriodicOrbit

SAMPLES = 256
"""Samples a forcing period: enough for smooth curves on a large screen."""

MOST_SAMPLES = 4096
"""Most samples of one orbit."""

PER_PERIOD = 64
"""Samples a forcing period that the spectrum is taken from."""

ORDERS = 8
"""Highest frequency shown, in forcing frequencies."""


def orbit_view(orbit: PeriodicOrbit, vary: str) -> dict[str, Any]:
    """Return an orbit as plain data."""
    model = orbit.model
    flow = flow_of(model)
    time, states = orbit.sample(min(SAMPLES * orbit.period, MOST_SAMPLES))
    time = np.append(time, orbit.duration)
    turned = [TURN * orbit.turns.get(state.name, 0) for state in model.states]
    states = np.concatenate([states, states[:1] + turned])
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
        "multipliers": _pairs(orbit.multipliers),
        "eigenvalues": _pairs(_eigenvalues(orbit)) if _rests(orbit) else None,
        "stable": orbit.stable,
        "period": orbit.period,
        "value": number(model.values[vary]),
        "duration": number(orbit.duration),
        "mechanism": {"kind": "sliding"} if isinstance(model, SlidingOscillator) else None,
    }


def _rests(orbit: PeriodicOrbit) -> bool:
    """Whether it is an equilibrium, which has no period: multipliers over one say nothing."""
    return not orbit.model.forced and bool((orbit.nodes == orbit.state).all())


def _eigenvalues(orbit: PeriodicOrbit) -> NDArray[np.complex128]:
    return eigenvalues_of(evaluation_of(orbit.model).jacobian(orbit.model, orbit.state))


def _pairs(values: NDArray[np.complex128]) -> list[list[float]]:
    return [[float(item.real), float(item.imag)] for item in values]


def _spectrum(orbit: PeriodicOrbit) -> dict[str, Any]:
    spectrum = find_spectrum(orbit, per_period=PER_PERIOD)
    shown = spectrum.order <= ORDERS
    return {
        "frequency": short(spectrum.frequency[shown]),
        "amplitude": {name: short(spectrum.of(name)[shown]) for name in spectrum.names},
    }
