"""Cases found by random search that earlier versions got wrong."""

import pytest

import slipfold as sf
from helpers.reference import specials
from slipfold import Settings, SlidingOscillator, Steps
from slipfold.bifurcations.branches.response import trace_response


def run(values, vary, span, largest=0.5):
    settings = Settings(steps=Steps(largest=largest), largest_period=2)
    return trace_response(SlidingOscillator(**values), vary, span, settings=settings)


def shape(branches):
    return sorted((branch.period, branch.stopped.kind) for branch in branches)


def test_a_branch_closes_on_the_doubling_that_it_meets():
    values = {
        "Nd": 0.13582191791130904,
        "mu": 0.7760594566996424,
        "alpha": 2.9686422324921784,
        "Vd": 1.113525109376334,
        "zeta1": 0.01752185528791904,
        "zeta2": 0.00521833865906688,
    }
    forward, backward = (run(values, "f", span) for span in ((8.0, 15.0), (15.0, 8.0)))
    assert shape(forward) == shape(backward)
    assert [item[0] for item in specials(forward)] == [item[0] for item in specials(backward)]


@pytest.mark.parametrize("scale", [1.0, 4.0])
def test_a_fold_right_beside_the_doubling_is_found(scale):
    # In the middle of Mathieu's tongue the cubic coefficient nearly vanishes: the doubled branch
    # leaves towards smaller h and folds within 1e-8 of it, nearer than a first step in any scale.
    rate = "-0.02*v - (1 + h*cos(2*t))*q + q^3"
    model = sf.System(
        name="middle",
        parameters={"h": 0.0},
        states={"q": {"rate": "v", "scale": scale}, "v": {"rate": rate, "scale": scale}},
        forcing={"period": "pi", "amplitude": "h"},
    )
    main, child = sf.response(model, vary="h", span=(0, 0.06)).branches
    assert main.special[0].criticality == "subcritical"
    (fold,) = child.special
    assert fold.type == "LP"
    assert 0 < main.special[0].value - fold.value < 2e-8
