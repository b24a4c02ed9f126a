"""Whether the points of a long motion follow from its start, or from the last digits of it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.flow import flow_of
from slipfold.flow.precision import LANES
from slipfold.flow.sizes.own_sizes import own_sizes
from slipfold.flow.trajectory import Trajectory
from slipfold.models.turns import without_turns

LONG = 1000
"""Forcing periods below which there is no time to look."""

SHARE = 0.006
"""Length of each of the stretches that are disturbed, as a share of the motion; all of them go
abreast, at the cost of one or two."""

LONGEST = 200
"""Length of a stretch at most, in forcing periods."""

DISTURBANCE = 1e-8
"""Relative to the states."""

LARGE = 1e-3
"""Disturbance that does not grow any more as a small one does."""

ALGEBRAIC = 2.0
"""Factor, times the length of a stretch, by which what is not sensitive may grow along it."""

DIGITS = math.log(1e11)
"""Growth that makes of an error of 1e-13 what is seen."""


def sensitivity(motion: Trajectory) -> str:
    """Return a sentence if disturbances grow so much that points are not to be relied on.

    It is empty where they do not, where the motion has settled and where it is short.
    """
    if motion.periods < LONG or motion.settlement.settled:
        return ""
    length = min(LONGEST, math.ceil(SHARE * motion.periods))
    places = np.linspace(0, motion.periods - length, LANES).astype(int)
    rates = _growth(motion, places, length)
    # By its error, so that a burst that one of the stretches meets is no growth that lasts.
    rate = float(rates.mean() - rates.std() / math.sqrt(LANES))
    if not rate * motion.periods > DIGITS:
        return ""
    known = round(DIGITS / float(rates.mean()))
    time = f"{known} periods" if motion.model.forced else f"{known * motion.forcing_period:.2g} s"
    return f"the motion is sensitive: its single points are known for about {time} only"


def _growth(motion: Trajectory, places: NDArray[np.intp], length: int) -> Array:
    """Return the exponents, per period, with which disturbances grow along stretches."""
    flow = flow_of(motion.model)
    along = motion.strobe[places[:, None] + np.arange(length + 1)]
    sizes = own_sizes(motion.model, along)
    signs = np.resize([1.0, -1.0, 1.0], along.shape[2])
    phases = np.tile(np.arange(length + 1.0), (len(places), 1))
    disturbed = along[:, 0] + DISTURBANCE * signs * sizes[:, 0]
    states = flow.along(disturbed, phases, flow.constants_of(motion.model))
    apart = np.abs(without_turns(states - along, motion.model.whole_turns))
    apart = (apart / sizes).max(axis=2)
    large = apart > LARGE
    count = np.where(large.any(axis=1), large.argmax(axis=1), length)
    factors = apart[np.arange(len(places)), count] / (DISTURBANCE * ALGEBRAIC * count)
    return np.asarray(np.log(factors) / count)
