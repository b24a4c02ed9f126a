"""A branch that was followed beside those of other cases: what is known of it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.abreast.limits import AtLimit
from slipfold.branches.abreast.located import Approached
from slipfold.models.model import Model
from slipfold.orbits.orbit_batch import Settled


@dataclass(eq=False)
class OwnBranch:
    """A branch of a case."""

    period: int
    stable: bool  # whether its first orbit is; of one that leaves another that is not known
    fate: str  # how it ends: ``"span"`` or ``"limit"``
    special: list[Approached]  # the bifurcations on it, in order
    parent: tuple[int, int] | None  # place of its parent, and of its birth among what is on that
    placed: list[Settled] = field(default_factory=list)  # the orbits there, by the flow itself
    orbits: Settled | None = None  # if asked for: all orbits but those where it is born or ends
    arclengths: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))  # of these
    limit: AtLimit | None = None  # if asked for: its last orbit, if it ends at a limit


@dataclass(eq=False)
class Case:
    """What is known of a case so far."""

    model: Model
    branches: list[OwnBranch] = field(default_factory=list)
    lost: str = ""  # why it has to be followed by itself
