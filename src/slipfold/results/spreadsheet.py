"""Results as comma-separated values: points of branches, stroboscopic states of motions."""

from __future__ import annotations

import csv
import io
from typing import TYPE_CHECKING, Any

import numpy as np

from slipfold.branches.branch import Branch

if TYPE_CHECKING:
    from slipfold.results.diagram import Diagram
    from slipfold.results.simulation import Simulation

__all__ = ["diagram_csv", "simulation_csv"]


def diagram_csv(diagram: Diagram) -> str:
    """Return all points and special points of all branches, in the order of the branch.

    Parameters
    ----------
    diagram
        The diagram.

    Returns
    -------
    str
        A line of column names with units, then one line a point. Numbers are exact: read back,
        they are the same. ``type`` is empty but for special points.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(_heads(diagram))
    for branch in diagram.branches:
        writer.writerows(_rows(branch))
    return text.getvalue()


def simulation_csv(simulation: Simulation) -> str:
    """Return time and states at phase zero, one line a forcing period.

    Parameters
    ----------
    simulation
        The motion.

    Returns
    -------
    str
        A line of column names with units, then the lines. Numbers are exact.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time (s)", *(_named(item) for item in simulation.model.states)])
    for time, state in zip(simulation.time, simulation.strobe, strict=True):
        writer.writerow([repr(float(time)), *(repr(float(value)) for value in state)])
    return text.getvalue()


def _named(item: Any) -> str:
    return f"{item.name} ({item.unit})" if item.unit else str(item.name)


def _heads(diagram: Diagram) -> list[str]:
    model = diagram.model
    outputs = [_named(item) for item in (*model.states, *model.outputs())]
    heads = ["branch", "period", "type", "criticality", _named(model.parameter(diagram.vary))]
    heads += [_named(item) for item in model.states]
    heads += [f"max {name}" for name in outputs] + [f"min {name}" for name in outputs]
    for index in range(1, len(model.states) + 1):
        heads += [f"multiplier {index} real", f"multiplier {index} imaginary"]
    return [*heads, "unstable multipliers", "residual", "arclength"]


def _rows(branch: Branch) -> list[list[Any]]:
    extrema = branch.extrema
    keyed = [
        (
            float(branch.arclength[i]),
            _row(
                branch, "", "", float(branch.parameter[i]), branch.states[i], extrema.maximum[i],
                extrema.minimum[i], branch.multipliers[i], float(branch.residual[i]),
                float(branch.arclength[i]),
            ),
        )
        for i in range(len(branch))
    ]  # fmt: skip
    for point in branch.special:
        reached = point.orbit.extrema
        row = _row(
            branch, point.type, point.criticality or "", point.value, point.state,
            reached.maximum[0], reached.minimum[0], point.multipliers, point.residual,
            point.arclength,
        )  # fmt: skip
        keyed.append((point.arclength, row))
    return [row for _, row in sorted(keyed, key=lambda item: item[0])]


def _row(
    branch: Branch, kind: str, criticality: str, value: float, state: Any, maximum: Any,
    minimum: Any, multipliers: Any, residual: float, arclength: float,
) -> list[Any]:  # fmt: skip
    parts = np.column_stack([multipliers.real, multipliers.imag]).ravel()
    row = [branch.id, branch.period, kind, criticality, value, *state.tolist()]
    row += [*maximum.tolist(), *minimum.tolist(), *parts.tolist()]
    return [*row, int((np.abs(multipliers) > 1).sum()), residual, arclength]
