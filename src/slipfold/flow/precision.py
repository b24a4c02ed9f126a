"""How closely motions are integrated, and how many at once.

Tests set both from outside, by the environment, to see that no result depends on them.
"""

from __future__ import annotations

import os

__all__ = ["LANES", "TOLERANCE"]

TOLERANCE = float(os.environ.get("SLIPFOLD_TOLERANCE", "1e-13"))
"""Local error a step may make: multipliers are then right to about 1e-13, for a tenth more time
than 1e-12 takes."""

LANES = int(os.environ.get("SLIPFOLD_LANES", "8"))
"""Trajectories integrated together: two registers of AVX2, one of AVX-512."""
