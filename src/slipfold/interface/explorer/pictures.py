"""Pictures that become finer while they are computed: basins and regimes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.bifurcations.loci.region_votes import model_exists
from slipfold.computations.arguments import checked_forced
from slipfold.computations.long_term import basins, regimes
from slipfold.declarations import default_of
from slipfold.errors import InputError
from slipfold.interface.explorer.messages import BasinsRequest, PlaneAxis, RegimesRequest
from slipfold.interface.explorer.plain import Check, Emit, axis_of, now_and_then, number, short
from slipfold.long_term.classification import NOT_DONE, PERIODIC, TrajectoryGrid
from slipfold.models.model import Model
from slipfold.progress import Progress
from slipfold.results.attractors import Basins, in_words, renumbered

BASIN_POINTS = (16, 48, 144)
"""Starts along both states, one number a picture; the last has eight times those before."""


def send_basins(model: Model, request: BasinsRequest, send: Emit, check: Check) -> None:
    """Compute basins, coarse ones first, and send each picture when it is ready."""
    watch = now_and_then(send, check, _far)
    plane = {axis.name: axis.span for axis in (request.x, request.y)}
    for points in BASIN_POINTS:
        result = basins(model, plane, points=points, on_progress=watch)
        send({**_picture(result), "done": points == BASIN_POINTS[-1]})


def _picture(result: Basins) -> dict[str, Any]:
    """Return labels row by row from below, numbered so that finer pictures keep the numbers."""
    # By properties that do not depend on how it was computed
    result = renumbered(
        result, lambda item: (item.kind, item.period or 0, np.round(item.maximum, 6).tolist())
    )
    first, second = result.plane
    return {
        "x": {**axis_of(result.model, first), "values": short(result.first)},
        "y": {**axis_of(result.model, second), "values": short(result.second)},
        "labels": result.labels.tolist(),
        "uncertain": result.uncertain.astype(int).tolist(),
        "attractors": [
            {"name": in_words(item), "fraction": number(result.fraction(item).value)}
            for item in result
        ],
    }


TRANSIENT = default_of(regimes, "transient")

REGIME_CELLS = ((12, 9), (36, 27), (72, 54))
"""Cells along both parameters, one pair a picture."""


def send_regimes(model: Model, request: RegimesRequest, send: Emit, check: Check) -> None:
    """Classify solutions from the starting state, few of them first, and send each picture.

    The first one is sent when periodic solutions are known; others are followed for longer.
    """
    checked_forced(model, "it has no regimes; classify single solutions by their exponents")
    watch = now_and_then(send, check, _far)
    for points in REGIME_CELLS:
        picture = _Picture(model, (request.x, request.y), points)
        work = TrajectoryGrid(
            model, picture.values, 1, np.asarray(model.start, dtype=float), TRANSIENT, watch
        )
        work.from_rest(0)
        if points == REGIME_CELLS[0]:
            send({**picture.of(work), "done": False})
        work.classify_open()
        send({**picture.of(work), "done": points == REGIME_CELLS[-1]})


class _Picture:
    """Cells of a window at which a model exists."""

    def __init__(
        self, model: Model, axes: tuple[PlaneAxis, PlaneAxis], points: tuple[int, int]
    ) -> None:
        self._model, self._names = model, (axes[0].name, axes[1].name)
        self._centers = [
            min(axis.span) + (np.arange(count) + 0.5) * abs(axis.span[1] - axis.span[0]) / count
            for axis, count in zip(axes, points, strict=True)
        ]
        first, second = (grid.ravel() for grid in np.meshgrid(*self._centers))
        self._there = np.array(
            [model_exists(model, self._names, a, b) for a, b in zip(first, second, strict=True)]
        )
        if not self._there.any():
            one, other = self._names
            raise InputError(
                f"the parameters contradict each other wherever {one} and {other} are in these "
                "spans; give others"
            )
        self.values = {
            name: values[self._there]
            for name, values in zip(self._names, (first, second), strict=True)
        }

    def of(self, work: TrajectoryGrid) -> dict[str, Any]:
        """Return labels row by row from below: the number of a name, or 0 where none is known."""
        names = _names(work)
        result = sorted({*names} - {NOT_DONE})
        numbers = {name: index for index, name in enumerate(result, 1)}
        labels = np.zeros(len(self._there), np.int64)
        labels[self._there] = [numbers.get(name, 0) for name in names]
        first, second = self._names
        return {
            "x": {**axis_of(self._model, first), "values": short(self._centers[0])},
            "y": {**axis_of(self._model, second), "values": short(self._centers[1])},
            "labels": labels.reshape(len(self._centers[1]), -1).tolist(),
            "names": result,
        }


def _names(work: TrajectoryGrid) -> list[str]:
    kinds: NDArray[np.str_] = work.reported_kinds[0]
    return [
        f"period {period}" if kind == PERIODIC else str(kind)
        for kind, period in zip(kinds, work.known.periods[0], strict=True)
    ]


def _far(progress: Progress) -> dict[str, Any]:
    return {"far": [progress.done, progress.total]}
