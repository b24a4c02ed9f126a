"""Extrema of outputs over the continuous orbit, not over mesh points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.flow import Flow, flow_of
from slipfold.flow.flow import Constants
from slipfold.models.model import Model

__all__ = ["Extrema", "find_extrema", "refine_minimum"]

Array = NDArray[np.float64]

SAMPLES = 64
"""Samples a forcing period that find the right hump; Newton's method finds its top."""

ZOOM = 16
"""Samples of each closer look."""

ZOOMS = 3
"""Closer looks: the last resolves 1e-4 of a forcing period, a parabola then 1e-12 in value."""


@dataclass(frozen=True)
class Extrema:
    """Minimum and maximum of every output, for one orbit or many.

    Parameters
    ----------
    names
        The outputs; states come first.
    minimum, maximum
        Shape (n_orbits, n_outputs), in the units of the outputs.
    """

    names: tuple[str, ...]
    minimum: Array
    maximum: Array

    def of(self, name: str) -> tuple[Array, Array]:
        """Return minimum and maximum of one output, each of shape (n_orbits,).

        Parameters
        ----------
        name
            A state or output of the model.
        """
        if name not in self.names:
            raise InputError(f"no output {name!r}; there are {', '.join(self.names)}")
        index = self.names.index(name)
        return self.minimum[:, index], self.maximum[:, index]

    def peak_to_peak(self, name: str) -> Array:
        """Return maximum less minimum of one output, shape (n_orbits,).

        Parameters
        ----------
        name
            A state or output of the model.
        """
        low, high = self.of(name)
        return high - low

    def modulus(self, name: str) -> Array:
        """Return the largest absolute value of one output, shape (n_orbits,).

        Parameters
        ----------
        name
            A state or output of the model.
        """
        low, high = self.of(name)
        return np.maximum(np.abs(low), np.abs(high))


def find_extrema(model: Model, parameters: Array, nodes: Array, period: int) -> Extrema:
    """Find the extrema of all outputs over orbits of one period.

    Parameters
    ----------
    model
        The model; its parameter values play no part.
    parameters
        Parameter vectors, shape (n_orbits, n_parameters).
    nodes
        Orbits, shape (n_orbits, m, n_states).
    period
        Period in forcing periods.

    Returns
    -------
    Extrema
        Of the continuous orbits.
    """
    flow = flow_of(model)
    low = np.empty((len(nodes), len(flow.output_names)))
    high = np.empty_like(low)
    for i, (vector, orbit) in enumerate(zip(parameters, nodes, strict=True)):
        low[i], high[i] = _extrema_of_orbit(flow, flow.constants(vector), orbit, period)
    return Extrema(flow.output_names, low, high)


def _extrema_of_orbit(
    flow: Flow, constants: Constants, nodes: Array, period: int
) -> tuple[Array, Array]:
    segments = len(nodes)
    edges = np.linspace(0, period, segments + 1)
    each = -(-SAMPLES * period // segments)
    samples = flow.sample(nodes, edges[:-1], edges[1:], each, constants)
    samples = samples.reshape(segments * each, -1)
    spacing = period / len(samples)
    phases: Array = np.arange(len(samples), dtype=float) * spacing
    values = flow.outputs(samples, phases, constants)
    columns = np.arange(values.shape[1])
    low = refine_minimum(flow, constants, samples, phases, spacing, columns, values.argmin(axis=0))
    high = -refine_minimum(
        flow, constants, samples, phases, spacing, columns, values.argmax(axis=0), sign=-1.0
    )
    return low, high


def refine_minimum(
    flow: Flow,
    constants: Constants,
    samples: Array,
    phases: Array,
    spacing: float,
    columns: NDArray[np.int64],
    index: NDArray[np.int64],
    sign: float = 1.0,
) -> Array:
    """Find minima of outputs over the continuous orbit, each near the lowest of its samples.

    The neighbourhood of each is sampled ever more finely, which finds a minimum as sharp as that
    of the spring's length near collapse; a parabola through the last three samples gives the rest.

    Parameters
    ----------
    flow
        The flow.
    constants
        Coefficients.
    samples
        States at equidistant phases of one closed orbit, shape (m, n_states).
    phases
        Their phases, shape (m,).
    spacing
        Distance of the phases.
    columns
        Which outputs, shape (k,).
    index
        The sample nearest each minimum, shape (k,).
    sign
        -1 finds maxima, returned as minima of the negative.

    Returns
    -------
    ndarray, shape (k,)
        The minima, in the units of the outputs.
    """
    rows = np.arange(len(columns))
    before = (index - 1) % len(samples)
    states, start = samples[before], phases[before]
    width = 2 * spacing
    for _ in range(ZOOMS):
        fine = flow.sample(states, start, start + width, ZOOM, constants)
        at = start[:, None] + np.arange(ZOOM) * (width / ZOOM)
        flat = flow.outputs(fine.reshape(-1, fine.shape[2]), at.ravel(), constants)
        values = sign * flat.reshape(len(columns), ZOOM, -1)[rows, :, columns]
        best = np.clip(values.argmin(axis=1), 1, ZOOM - 2)
        states, start = fine[rows, best - 1], at[rows, best - 1]
        width = 2 * width / ZOOM
    left, middle, right = (values[rows, best + side] for side in (-1, 0, 1))
    bend = left - 2 * middle + right
    with np.errstate(divide="ignore", invalid="ignore"):
        gain = np.where(bend > 0, (right - left) ** 2 / (8 * bend), 0.0)
    return np.minimum(np.minimum(left, right), middle - np.minimum(gain, np.abs(bend)))
