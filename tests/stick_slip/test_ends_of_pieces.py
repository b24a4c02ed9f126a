"""Where a smooth piece of a branch ends: an estimate saves points, and changes no result."""

import math

import numpy as np
import pytest

import slipfold as sf
from slipfold.bifurcations.branches import switching_boundaries
from slipfold.continuation import pieces


def test_end_of_piece_is_estimated(monkeypatch: pytest.MonkeyPatch) -> None:
    """Den Hartog's oscillator ceases to stick at the same place with a third of the points."""
    model = sf.Structure(
        [[1.0]],
        K=[[1.0]],
        names="x",
        contacts=sf.FrictionContact("x", sf.Coulomb(mu_k=0.5), load=1.0, Vd=0.0),
        forcing=sf.HarmonicForce("x", F=1.0),
        f=0.6 / (2 * math.pi),
    )
    counts, ends, computed = [], [], [0]
    correct, locate = pieces.correct, pieces.locate_boundary

    def counted(*args, **options):
        computed[0] += 1
        return correct(*args, **options)

    def both(curve, history, a, b, estimate):
        for given in (None, estimate):
            computed[0] = 0
            boundary = locate(curve, history, a, b, given)
            counts.append(computed[0])
            ends.append(boundary.before.z)
        return boundary

    monkeypatch.setattr(pieces, "correct", counted)
    monkeypatch.setattr(switching_boundaries, "locate_boundary", both)
    sf.response(model, "f", (0.08, 0.12))
    bisected, estimated = counts
    assert 3 * estimated <= bisected
    assert np.linalg.norm(ends[1] - ends[0]) < 4 * pieces.PIECE.close
