"""Loci of orbits that shooting cannot follow: relaxation oscillations, canards."""

import numpy as np
import pytest

import slipfold as sf
from slipfold.branches import Settings
from slipfold.continuation.newton import correct
from slipfold.loci.locus_equations import LocusEquations
from slipfold.loci.start import as_unknown

BY_COLLOCATION = sf.Settings(discretisation="collocation", largest_period=1)


def neuron(eps=0.08, **more):
    """FitzHugh, Biophysical Journal 1 (1961) 445-466, with his a = 0.7 and b = 0.8."""
    return sf.System(
        name="fitzhugh-nagumo",
        parameters={"I": 0.0, "eps": eps},
        states={
            "v": {"rate": "v - v^3/3 - w + I", "start": -1.2},
            "w": {"rate": "eps*(v + 0.7 - 0.8*w)", "start": -0.6},
            **more,
        },
    )


def fold(model, span):
    diagram = sf.response(model, vary="I", span=span, settings=BY_COLLOCATION)
    (point,) = (item.point for item in diagram.special if item.point.type == "LP")
    return point


@pytest.fixture(scope="module")
def folds():
    """The fold of cycles beyond the canards, from soft to hard excitation."""
    point = fold(neuron(), (0.31, 0.34))
    return sf.locus(point, ("I", "eps"), ((0.28, 0.5), (0.02, 0.2)))


def test_the_fold_of_cycles_is_followed_through_all_canards(folds):
    (locus,) = folds.loci
    assert (locus.type, locus.begun.kind, locus.stopped.kind) == ("LP", "window", "window")
    assert sorted(locus.values[[0, -1], 1]) == pytest.approx([0.02, 0.2])
    assert len(locus) < 300
    assert locus.special == ()
    assert folds.checked.disagreeing == ()
    assert np.abs(locus.multipliers - 1).max() < 1e-7


@pytest.mark.parametrize("eps", [0.03, 0.15])
def test_branches_have_their_folds_on_it(folds, eps):
    (locus,) = folds.loci
    index = int(np.abs(locus.values[:, 1] - eps).argmin())
    current, eps = locus.values[index].tolist()
    v = -np.sqrt(1 - 0.8 * eps)  # where cycles are born: the trace of the Jacobian is zero
    hopf = (v + 0.7) / 0.8 - v + v**3 / 3
    point = fold(neuron(eps), (current - 0.01, hopf + 0.002))
    assert point.value == pytest.approx(current, abs=1e-10)


def test_how_the_quotients_matrix_changes_is_what_differences_say():
    """Beside the flow's direction there are more than one, and growth on the way is large.

    It is 2e5, of which differences leave seven digits wherever the cycle begins.
    """
    model = neuron(
        0.15, x={"rate": "-1.3*(x - v*w) + 0.2*v^2", "start": -1.2}, y={"rate": "-0.7*y + x - w"}
    )
    plane = {"I": 0.1, "eps": 0.1}
    orbits, z = as_unknown(fold(model, (0.34, 0.366)), model, plane, Settings())
    curve = LocusEquations(orbits, "LP")
    found = correct(curve, z, np.linalg.svd(curve.linearise(z).jacobian)[2][-1])
    assert found.converged
    linearised = curve.linearise(found.z)
    gradient = linearised.conditions.gradients[-1]
    along_orbits = np.linalg.svd(linearised.jacobian[:-1])[2][-2:]
    exact = along_orbits @ gradient
    step = 1e-4
    ahead, behind = (
        np.array([curve.defect(found.z + s * step * way)[-1] for way in along_orbits])
        for s in (1, -1)
    )
    # The gradient in the plane of these directions as a whole: its components depend on the basis.
    assert np.linalg.norm(exact - (ahead - behind) / (2 * step)) < 1e-5 * np.linalg.norm(exact)
