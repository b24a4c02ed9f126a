"""What motions come to that are released at phases of their own."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.ensembles import released
from slipfold.long_term.known import Known
from slipfold.long_term.search import ENDED, Searched, search
from slipfold.models.model import Model
from slipfold.progress import Observer


def search_released(
    model: Model,
    starts: Array,
    phases: Array,
    periods: int | None = None,
    observer: Observer | None = None,
    known: tuple[Known, ...] = (),
) -> Searched:
    """Let motions go on from their phases to phase zero, and from there until each is known.

    `known` are the attractors of a search before. Shapes: starts (k, n); phases (k,), from 0 to 1.
    """
    states, stops = released(model, starts, phases)
    if not stops:
        return search(model, states, periods, observer, known=known)
    going = np.setdiff1d(np.arange(len(starts)), [*stops])
    found = search(model, states[going], periods, observer, known=known)
    labels = np.full(len(starts), ENDED)
    labels[going] = found.labels
    ends = Counter(stop.kind for stop in stops.values()) + Counter(found.ends)
    return replace(found, labels=labels, ends=dict(ends))
