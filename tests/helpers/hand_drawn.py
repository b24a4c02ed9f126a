"""Branches with made-up extrema, for figures and claims: nothing is integrated."""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np

from slipfold import Branch, End, Extrema, SlidingOscillator, SpecialPoint

INSIDE = np.array([0.5 + 0.5j, 0.5 - 0.5j, 0.3, 0.2])
FLIPPED = np.array([-1.5, 0.5, 0.3, 0.2], dtype=complex)
FOLDED = np.array([1.5, 0.5, 0.3, 0.2], dtype=complex)
TWISTED = np.array([0.9 + 0.9j, 0.9 - 0.9j, 0.3, 0.2])

CRITICAL = {
    "PD": np.array([-1, 0.5, 0.3, 0.2], dtype=complex),
    "LP": np.array([1, 0.5, 0.3, 0.2], dtype=complex),
    "NS": np.array([0.6 + 0.8j, 0.6 - 0.8j, 0.3, 0.2]),
}


@dataclass(frozen=True, eq=False)
class DrawnPoint(SpecialPoint):
    """A special point whose extrema are given."""

    reach: dict = field(default_factory=dict)

    @property
    def orbit(self):
        known = extrema_of(self.reach)
        return SimpleNamespace(extrema=known, extrema_of=lambda output: known)


def extrema_of(reach):
    """Extrema from ``{"x": maxima}``; minima are their negatives."""
    high = np.column_stack([np.atleast_1d(np.asarray(values, float)) for values in reach.values()])
    return Extrema(tuple(reach), -high, high)


def drawn_point(
    kind,
    value,
    arclength,
    reach,
    *,
    criticality=None,
    leads_to=None,
    vary="Nd",
    multipliers=None,
):
    model = SlidingOscillator(**{vary: value})
    return DrawnPoint(
        type=kind,
        name=kind,
        model=model,
        vary=vary,
        value=value,
        uncertainty=1e-13,
        period=1,
        nodes=np.zeros((1, 4)),
        multipliers=CRITICAL.get(kind, INSIDE) if multipliers is None else np.array(multipliers),
        multiplier_uncertainty=np.zeros(4),
        residual=0.0,
        arclength=arclength,
        criticality=criticality,
        coefficient=None if criticality is None else 1.0,
        leads_to=leads_to,
        reach=reach,
    )


def drawn_branch(
    parameter,
    reach,
    multipliers,
    special=(),
    *,
    arclength=None,
    period=1,
    started="span",
    stopped="span",
    reason="the end",
    vary="Nd",
):
    parameter = np.asarray(parameter, float)
    count = len(parameter)
    if arclength is None:
        arclength = np.linspace(0.0, 1.0, count)
    branch = Branch(
        id=period,
        kind="periodic",
        period=period,
        parent=None if period == 1 else 1,
        model=SlidingOscillator(),
        vary=vary,
        parameter=parameter,
        nodes=np.zeros((count, 1, 4)),
        multipliers=np.array(multipliers),
        residual=np.zeros(count),
        arclength=np.asarray(arclength, float),
        special=tuple(special),
        stopped=End(stopped, reason, parameter[-1] if count else 0.0),
        started=End(started, "the beginning", parameter[0] if count else 0.0),
    )
    branch.__dict__["extrema"] = extrema_of(reach)
    return branch


def diagram_of(*branches):
    return SimpleNamespace(branches=branches, tori=(), interrupted=False)


def threshold_diagram(doubling, tori=(), *, criticality="supercritical", vary="Nd", slope=1.0):
    """Period 1 with one PD, period 2 from there on with NS; x and y grow with `slope`."""
    grid = np.linspace(0.0, 0.98, 50)
    grid = grid[np.abs(grid - doubling) > 1e-3]
    point = drawn_point(
        "PD", doubling, doubling, _reach(doubling, slope), criticality=criticality, leads_to=2
    )
    multipliers = [INSIDE if value < doubling else FLIPPED for value in grid]
    first = drawn_branch(grid, _reach(grid, slope), multipliers, [point], arclength=grid, vary=vary)
    grid = np.concatenate([[doubling], np.linspace(doubling, 0.98, 60)[1:]])
    unstable = [sum(torus < value for torus in tori) % 2 for value in grid]
    second = drawn_branch(
        grid,
        _reach(grid, slope),
        [TWISTED if flag else INSIDE for flag in unstable],
        [drawn_point("NS", torus, torus, _reach(torus, slope)) for torus in tori],
        arclength=grid,
        period=2,
        started="bifurcation",
        vary=vary,
    )
    return diagram_of(first, second)


def _reach(value, slope):
    return {"x": slope * (0.1 + np.asarray(value)), "y": slope * (0.2 + np.asarray(value))}
