"""Loci of orbits that shooting cannot follow: relaxation oscillations, canards."""

import numpy as np
import pytest

import slipfold as sf
from helpers.foreign_systems import fitzhugh_nagumo

BY_COLLOCATION = sf.Settings(discretization="collocation", largest_period=1)


def fold(model, span):
    diagram = sf.response(model, vary="I", span=span, settings=BY_COLLOCATION)
    (point,) = (item.point for item in diagram.special if item.point.type == "LP")
    return point


@pytest.fixture(scope="module")
def folds():
    """The fold of cycles beyond the canards, from soft to hard excitation."""
    point = fold(fitzhugh_nagumo(), (0.31, 0.34))
    return sf.locus(point, ("I", "eps"), ((0.28, 0.5), (0.02, 0.2)))


def test_the_fold_of_cycles_is_followed_through_all_canards(folds):
    (locus,) = folds.loci
    assert (locus.type, locus.started.kind, locus.stopped.kind) == ("LP", "window", "window")
    assert sorted(locus.values[[0, -1], 1]) == pytest.approx([0.02, 0.2])
    assert len(locus) < 300
    assert locus.special == ()
    assert folds.checked.disagreeing == ()
    assert np.abs(locus.multipliers - 1).max() < 1e-7


@pytest.mark.parametrize("eps", [pytest.param(0.03, marks=pytest.mark.long), 0.15])
def test_branches_have_their_folds_on_it(folds, eps):
    (locus,) = folds.loci
    index = int(np.abs(locus.values[:, 1] - eps).argmin())
    current, eps = locus.values[index].tolist()
    v = -np.sqrt(1 - 0.8 * eps)  # where cycles emanate: the trace of the Jacobian is zero
    hopf = (v + 0.7) / 0.8 - v + v**3 / 3
    point = fold(fitzhugh_nagumo(eps), (current - 0.01, hopf + 0.002))
    assert point.value == pytest.approx(current, abs=1e-10)
