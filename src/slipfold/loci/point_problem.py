"""Which equations the locus of a special point meets: those of orbits, cycles or equilibria."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.special_point import SpecialPoint
from slipfold.errors import InputError
from slipfold.loci.cycle_locus import CycleLocus
from slipfold.loci.equilibrium_locus import EquilibriumLocus
from slipfold.loci.locus_problem import LocusProblem
from slipfold.models.model import Model

__all__ = ["locus_class", "locus_unknown"]

Array = NDArray[np.float64]

RESTING = 1e-7
"""An orbit whose nodes differ by less than this, in scaled states, is an equilibrium."""


def locus_class(point: SpecialPoint) -> type[LocusProblem]:
    """Return the class of the equations of a point's locus."""
    if point.model.forced:
        return LocusProblem
    moved = np.ptp(point.nodes, axis=0) / point.model.state_scales()
    return CycleLocus if moved.max() > RESTING else EquilibriumLocus


def locus_unknown(problem: LocusProblem, point: SpecialPoint) -> Array:
    """Return the unknown of a special point."""
    values: Model = point.model
    nodes = point.nodes[: problem.segments] if problem.orbits == "equilibrium" else point.nodes
    if len(nodes) != problem.segments:
        raise InputError(
            f"the special point is given at {len(nodes)} phases, not {problem.segments}; "
            "compute it anew"
        )
    return problem.join(nodes, [values.values[name] for name in problem.free])
