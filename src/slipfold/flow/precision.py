"""How closely motions are integrated, how many at once, and by how good code.

Tests set all from outside, by the environment, to see that no result depends on them.
"""

from __future__ import annotations

import os

TOLERANCE = float(os.environ.get("SLIPFOLD_TOLERANCE", "1e-13"))
"""Local error a step may make: multipliers are then right to about 1e-13, for a tenth more time
than 1e-12 takes."""

LANES = int(os.environ.get("SLIPFOLD_LANES", "8"))
"""Trajectories integrated together: two registers of AVX2, one of AVX-512."""

OPTIMISATION = int(os.environ.get("SLIPFOLD_OPTIMISATION", "3"))
"""LLVM's level for integrators but that of many motions: at 0 they are compiled in a quarter of the
time and run half as fast, which pays where a model is integrated once, as in most tests."""
