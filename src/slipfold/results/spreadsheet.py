"""Results as comma-separated values: points of branches and loci, strobe states of motions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from slipfold.branches.branch import Branch
from slipfold.loci.locus import Locus
from slipfold.results.criticality import criticalities, point_criticality
from slipfold.results.csv_text import complex_parts, csv_text, multiplier_heads, with_unit

if TYPE_CHECKING:
    from slipfold.results.diagram import Diagram
    from slipfold.results.locus_diagram import LocusDiagram
    from slipfold.results.simulation import Simulation

__all__ = ["diagram_csv", "locus_csv", "simulation_csv"]


def diagram_csv(diagram: Diagram) -> str:
    """Return all points and special points of all branches, in the order of the branch."""
    return csv_text(_heads(diagram), (row for item in diagram.branches for row in _rows(item)))


def locus_csv(diagram: LocusDiagram) -> str:
    """Return all points and special points of all loci, in the order of the locus."""
    model = diagram.model
    heads = ["locus", "type", "period", "special", "criticality"]
    heads += [with_unit(model.parameter(name)) for name in diagram.vary]
    heads += [with_unit(item) for item in model.states] + multiplier_heads(model)
    heads += ["coefficient", "coefficients", "residual", "arclength"]
    return csv_text(heads, (row for item in diagram.loci for row in _locus_rows(item)))


def simulation_csv(simulation: Simulation) -> str:
    """Return time and states at phase zero, one line a forcing period."""
    heads = ["time (s)", *(with_unit(item) for item in simulation.model.states)]
    times, states = simulation.time.tolist(), simulation.strobe.tolist()
    return csv_text(heads, ([time, *state] for time, state in zip(times, states, strict=True)))


def _heads(diagram: Diagram) -> list[str]:
    model = diagram.model
    outputs = [with_unit(item) for item in (*model.states, *model.outputs())]
    heads = ["branch", "period", "type", "criticality", with_unit(model.parameter(diagram.vary))]
    heads += [with_unit(item) for item in model.states]
    heads += [f"max {name}" for name in outputs] + [f"min {name}" for name in outputs]
    return [*heads, *multiplier_heads(model), "unstable multipliers", "residual", "arclength"]


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
    return _in_order(keyed)


def _in_order(keyed: list[tuple[float, list[Any]]]) -> list[list[Any]]:
    return [row for _, row in sorted(keyed, key=lambda item: item[0])]


def _row(
    branch: Branch, kind: str, criticality: str, value: float, state: Any, maximum: Any,
    minimum: Any, multipliers: Any, residual: float, arclength: float,
) -> list[Any]:  # fmt: skip
    row = [branch.id, branch.period, kind, criticality, value, *state.tolist()]
    row += [*maximum.tolist(), *minimum.tolist(), *complex_parts(multipliers)]
    return [*row, int((np.abs(multipliers) > 1).sum()), residual, arclength]


def _locus_rows(locus: Locus) -> list[list[Any]]:
    begin = [locus.id, locus.type, locus.period]
    keyed = []
    for i, word in enumerate(criticalities(locus)):
        coefficient, place = float(locus.coefficient[i]), float(locus.arclength[i])
        row = [*begin, "", word or "", *locus.values[i].tolist(), *locus.states[i].tolist()]
        row += [*complex_parts(locus.multipliers[i]), "" if np.isnan(coefficient) else coefficient]
        keyed.append((place, [*row, "", float(locus.residual[i]), place]))
    for point in locus.special:
        named = "; ".join(f"{name} = {value!r}" for name, value in point.coefficients.items())
        word = point_criticality(locus, point) or ""
        row = [*begin, point.type, word, *point.values, *point.state.tolist()]
        row += [*complex_parts(point.multipliers), "", named, point.residual, point.arclength]
        keyed.append((point.arclength, row))
    return _in_order(keyed)
