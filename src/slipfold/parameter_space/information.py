"""How well planned readings would determine parameters, from derivatives of predictions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.parameter_space.explanation import Prediction, sensitivities
from slipfold.parameter_space.least_squares import covariance_of
from slipfold.parameter_space.measurement import Quantity
from slipfold.parameter_space.stable_orbits import StableOrbit, stable_orbits


@dataclass(frozen=True, eq=False)
class Planned:
    """Predicted readings, and their derivatives with respect to parameters."""

    values: Array  # of the parameter varied, shape (m,)
    read: Array  # shape (m, q); NaN where no response is stable
    slopes: Array  # derivatives of readings, shape (m, q, p); NaN likewise
    sizes: Array  # sizes of the parameters, shape (p,)


def plan(
    model: Model,
    vary: str,
    values: Array,
    quantities: tuple[Quantity, ...],
    names: Sequence[str],
    errors: Array,
) -> Planned:
    """Predict readings at values in their order, with their derivatives.

    Each belongs to the stable response nearest to the one before, in units of `errors`, as in a
    sweep; the first belongs to the one that is followed first from the response of period 1.

    Shapes: values (m,), errors (q,).
    """
    sizes = np.array([abs(model.values[name]) for name in names])
    for name, size in zip(names, sizes, strict=True):
        if size == 0:
            raise InputError(f"{name} = 0 has no size to compare with; give it a value above zero")
    chosen = _as_swept(stable_orbits(model, vary, values, quantities), errors)
    there = [row for row, orbit in enumerate(chosen) if orbit is not None]
    if not there:
        raise InputError(
            f"no response is stable at the {len(values)} values of {vary} planned; plan others"
        )
    orbits = tuple(orbit for orbit in chosen if orbit is not None)
    prediction = Prediction(model, vary, quantities, orbits)
    read = np.full((len(values), len(quantities)), np.nan)
    slopes = np.full((*read.shape, len(names)), np.nan)
    read[there], slopes[there] = prediction.read, sensitivities(prediction, names, sizes)
    return Planned(values, read, slopes, sizes)


def _as_swept(
    candidates: Sequence[Sequence[StableOrbit]], errors: Array
) -> list[StableOrbit | None]:
    """Return the orbit at each value that lies nearest to the one before."""
    found: list[StableOrbit | None] = []
    before: StableOrbit | None = None
    for orbits in candidates:
        if not orbits:
            found.append(None)
            continue
        near = orbits[0]
        if before is not None:
            last = before.read
            near = min(orbits, key=lambda orbit: float(np.abs((orbit.read - last) / errors).max()))
        before = near
        found.append(near)
    return found


def best_rows(planned: Planned, errors: Array, count: int) -> list[int]:
    """Return the rows that tell all parameters best together, `count` of them, in their order.

    One by one that row is taken which makes the determinant of the information matrix largest (a
    D-optimal design), then each is exchanged for a better one while there is one.

    Shapes: errors (q,).
    """
    scaled = planned.slopes / errors[:, None] * planned.sizes
    parts = {
        row: scaled[row].T @ scaled[row]
        for row in range(len(scaled))
        if np.isfinite(scaled[row]).all()
    }
    count = min(count, len(parts))
    # A little information beforehand, so that the first rows can be compared at all.
    prior = 1e-9 * max(np.trace(part) for part in parts.values()) * np.eye(len(planned.sizes))
    chosen: list[int] = []
    for _ in range(count):
        chosen.append(_next(parts, chosen, prior))
    for _ in range(10 * count):
        before = sorted(chosen)
        for place in range(count):
            others = chosen[:place] + chosen[place + 1 :]
            chosen[place] = _next(parts, others, prior)
        if sorted(chosen) == before:
            break
    return sorted(chosen)


def _next(parts: dict[int, Array], chosen: Sequence[int], prior: Array) -> int:
    known = prior + sum((parts[row] for row in chosen), np.zeros_like(prior))
    left = [row for row in parts if row not in chosen]
    return max(left, key=lambda row: float(np.linalg.slogdet(known + parts[row])[1]))


def expected(planned: Planned, errors: Array, rows: Sequence[int] | slice) -> Array:
    """Return the covariance of the parameters that some rows would leave, shape (p, p)."""
    slopes = (planned.slopes / errors[:, None])[rows].reshape(-1, len(planned.sizes))
    return covariance_of(slopes[np.isfinite(slopes).all(axis=1)], planned.sizes)
