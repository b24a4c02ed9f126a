"""Responses followed together are those that each case has individually."""

import numpy as np
import pytest
from scipy.stats import qmc

import slipfold as sf
from slipfold.bifurcations.branches.batched import follow_batch
from slipfold.bifurcations.branches.response import trace_response
from slipfold.bifurcations.branches.stops import STOP
from slipfold.continuation.locate import ZERO
from slipfold.flow.batches import ROUNDING
from slipfold.orbits.continued import parameter_rounding
from slipfold.orbits.normal_forms.maps import JetMap
from slipfold.orbits.uncertainty import answers_of, multiplier_rounding, recomputed

SPAN = (0.0, 0.98)

COEFFICIENT = 1e-6
"""Jets are integrated to 1e-10, of which coefficients keep seven digits at least."""


def scattered(count, seed):
    """So many oscillators over speed, friction coefficient and direction."""
    places = qmc.LatinHypercube(3, seed=seed).random(count)
    return [
        sf.SlidingOscillator(
            f=12.5, Vd=0.4 + 0.6 * speed, mu=0.3 + 0.4 * mu, alpha=np.radians(20 + 60 * turn)
        )
        for speed, mu, turn in places
    ]


def batched(models, vary="Nd", span=SPAN, settings=None, wanted="special"):
    return follow_batch(models, vary, span, settings or sf.Settings(), wanted=wanted)


def branches_of(models):
    """All branches of each case as data."""
    return [case.assembled("Nd", SPAN[0]) for case in batched(models, wanted="orbits")]


def assert_alike(response, branches, width):
    """Check that both have the same branches and special points, as well as these are known."""
    assert not response.failure
    periods = [item.orbits.period for item in response.branches]
    assert periods == [item.period for item in branches]
    found = zip(response.branches, response.special, branches, strict=True)
    for one, special, other in found:
        assert one.end == other.stopped.kind
        told = [(point.type, point.criticality) for point in special]
        assert told == [(point.type, point.criticality) for point in other.special]
        for point, known in zip(special, other.special, strict=True):
            uncertain = point.uncertainty + known.uncertainty + 2 * ZERO.close * width
            assert abs(point.value - known.value) <= uncertain
            assert point.coefficient == pytest.approx(known.coefficient, rel=COEFFICIENT)


@pytest.mark.parametrize("count", [3, pytest.param(40, marks=pytest.mark.long)])
def test_special_points_are_those_of_each_response_alone(count):
    models = scattered(max(16, count), seed=7)
    found = batched(models)
    assert not any(case.failure for case in found)  # none had to be followed individually
    for model, response in zip(models[:count], found, strict=False):
        assert_alike(response, trace_response(model, "Nd", SPAN), SPAN[1])


def test_whole_branches_are_those_of_each_response_alone():
    models = scattered(16, seed=5)[:4]
    found = branches_of(models)
    for model, branches in zip(models, found, strict=True):
        alone = trace_response(model, "Nd", SPAN)
        for one, other in zip(branches, alone, strict=True):
            assert (one.id, one.period, one.parent) == (other.id, other.period, other.parent)
            told = [(item.type, item.leads_to, item.criticality) for item in one.special]
            assert told == [(item.type, item.leads_to, item.criticality) for item in other.special]
            assert [end.kind for end in one.ends] == [end.kind for end in other.ends]
            assert [end.reason for end in one.ends] == [end.reason for end in other.ends]
            # At a limit each margin may be left with what an arclength so short makes of it.
            assert abs(one.stopped.value - other.stopped.value) <= 4 * STOP.limit_close
            assert one.residual.max() <= sf.Settings().newton.tolerance
            assert one.nodes.shape[1:] == other.nodes.shape[1:]
            some = len(one) // 4  # where multipliers of 1e4 do not magnify errors of the orbit
            orbit = one.orbit(some)
            assert orbit.check().passed
            np.testing.assert_allclose(orbit.multipliers, one.multipliers[some], atol=1e-8)
        assert branches[0].stable.argmin() > 0


def reported(responses):
    return [
        [(p.type, p.value, p.uncertainty, p.coefficient) for p in branch]
        for response in responses
        for branch in response.special
    ]


def test_a_breakdown_in_a_batch_is_of_one_case(monkeypatch):
    models, alone = scattered(3, seed=3), JetMap.powers_of

    def broken(maps, each):
        if len(maps) > 1:
            raise FloatingPointError
        return alone(maps, each)

    known = reported(batched(models, span=(0.0, 0.2)))
    monkeypatch.setattr(JetMap, "powers_of", broken)
    assert reported(batched(models, span=(0.0, 0.2))) == known


def test_points_are_computed_again_together_as_alone():
    cases = batched(scattered(3, seed=7), span=(0.0, 0.2))
    points = [found.point for case in cases for item in case.branches for found in item.found]
    beside = [point.z + 1e-6 * point.tangent for point in points]
    wanted = enumerate(zip(points * 2, [None] * len(points) + beside, strict=True))
    answers = answers_of(dict(wanted))
    for i, (point, there) in enumerate(zip(points, beside, strict=True)):
        alone, _ = recomputed(point.curve, point)
        # Errors of steps, where rounding is a two-thousandth of them.
        part, factor = point.linearization, ROUNDING / np.finfo(float).eps
        moved = parameter_rounding(part.bordered(point.tangent), point.z, ROUNDING)
        spread = factor * multiplier_rounding(point.monodromy, point.multipliers)
        assert abs(answers[i].value - alone.z[-1]) <= moved
        assert (np.abs(answers[i].multipliers - alone.multipliers) <= spread).all()
        known = point.curve.eigenvalues(there, point.curve.linearize(there))
        assert (np.abs(answers[len(points) + i] - known) <= spread).all()


def test_a_result_does_not_depend_on_its_batch():
    models = scattered(7, seed=3)
    together = batched(models, span=(0.0, 0.2))
    assert reported(batched(models[2:3], span=(0.0, 0.2))) == reported(together[2:3])
    assert reported(batched(models[1:6], span=(0.0, 0.2))) == reported(together[1:6])


def test_a_branch_that_is_followed_to_its_loss_of_stability_ends_there():
    models, settings = scattered(8, seed=3), sf.Settings(largest_period=1)
    for case in follow_batch(models, "Nd", SPAN, settings, wanted="loss"):
        (branch,) = case.branches
        assert (case.failure, branch.end) == ("", "loss")
        before, after = (branch.orbits.value(z) for z, _, _ in branch.steps[-2:])
        assert before < branch.orbits.value(branch.loss.point.z) < after


def test_folds_but_none_beyond_a_limit():
    model = sf.SlidingOscillator(f=12.36, mu=0.595, alpha=1.4475, Vd=0.7108)
    (found,) = branches_of([model])
    assert [[item.type for item in branch.special] for branch in found] == [["PD"], ["LP"]]
    assert_alike(batched([model])[0], trace_response(model, "Nd", SPAN), SPAN[1])
    # Shortly beyond the spring's collapse the branch of period 1 would turn.
    assert [branch.stopped.kind for branch in found] == ["limit", "span"]


def test_limits_that_are_some_steps_beyond_the_last_orbit():
    models = [
        sf.SlidingOscillator(f=12.5, Vd=Vd, mu=mu, alpha=alpha)
        for Vd, mu, alpha in ((0.5405, 0.3580, 1.0937), (0.7887, 0.2789, 0.7999))
    ]
    found = branches_of(models)
    for model, branches in zip(models, found, strict=True):
        alone = trace_response(model, "Nd", SPAN)
        assert [branch.stopped.kind for branch in branches] == ["limit", "span"]
        assert branches[0].stopped.reason == alone[0].stopped.reason
        assert abs(branches[0].stopped.value - alone[0].stopped.value) <= 4 * STOP.limit_close


def test_rest_under_a_pulsing_spring_loses_its_stability_where_it_does_alone():
    model = sf.System(
        name="rest",
        parameters={"d": 0.1, "k": 80.0},
        states={"x": "v", "v": "-d*v - (k + 0.3*cos(t))*x - x^3"},
        forcing={"period": "2*pi"},
    )
    span = (0.02, -0.02)
    found = batched([model.replace(k=k) for k in (30.0, 86.0)], "d", span)
    for response, k in zip(found, (30.0, 86.0), strict=True):
        assert_alike(response, trace_response(model.replace(k=k), "d", span), 0.04)
        assert [point.type for point in response.special[0]] == ["NS"]
