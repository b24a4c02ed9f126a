"""A map of thresholds put together by hand."""

import numpy as np

from slipfold import SlidingOscillator, ThresholdMap
from slipfold.results.records import Provenance

MODEL = SlidingOscillator(f=12.4)
KINDS = [["", "no PD in the span"], ["", "limit: lost contact"], ["limit: lost contact", ""]]
REASON = "the normal force fell; keep Nd < Ns"


def made_map(**changes):
    """A map of three speeds (not in order) and two directions."""
    kinds = np.array(KINDS)
    gaps = np.where(kinds == "", 0.0, np.nan)
    states = np.arange(24.0).reshape(3, 2, 4) / 7 + gaps[..., None]
    values = {
        "model": MODEL,
        "threshold": "Nd",
        "type": "PD",
        "over": {"Vd": np.array([0.6, 0.4, 1.0]), "alpha": np.array([0.1, np.pi / 3])},
        "span": (0.0, 0.9),
        "values": np.array([[0.1, 0.2], [0.3, 0.4], [0.5, 0.1 / 3]]) + gaps,
        "states": states,
        "multipliers": np.where(np.isnan(states), complex(np.nan, np.nan), states - 1j / 3),
        "residuals": np.full((3, 2), 1e-13) + gaps,
        "kinds": kinds,
        "reasons": np.where(kinds == "", "", REASON).astype(object),
        "followed": np.array([[True, False], [True, True], [False, False]]),
        "provenance": Provenance("1", "2", "3", "4", "2026-01-01T00:00:00+00:00", 0.1),
    }
    return ThresholdMap(**(values | changes))
