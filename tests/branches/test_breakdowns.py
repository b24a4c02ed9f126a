"""What happens where the numbers break down: a sentence, and what was found is kept."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import count
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import slipfold as sf
from helpers.long_tests import long_except
from slipfold.bifurcations.branches import ends
from slipfold.bifurcations.branches.switching_boundaries import left_to_change
from slipfold.flow.flow import flow_of
from slipfold.orbits.kinds import orbits_at
from slipfold.orbits.marginal import MarginalShooting
from slipfold.orbits.switched_shooting import SwitchedShooting

BURST = 60
"""Calls that fail in a row: more than a step may be shortened."""

GROWING = sf.System(
    name="growing",
    parameters={"mu": 1.0},
    states={
        "x": {"rate": "mu*x - y - x*(x^2 + y^2) + 0.01*(1 - x)^0.5", "scale": 1.0},
        "y": {"rate": "x + mu*y - y*(x^2 + y^2)", "scale": 1.0},
    },
)
"""Cycles of about the radius sqrt(mu), and a root that ends at x = 1."""


def _breaking(
    monkeypatch: pytest.MonkeyPatch, routine: str, from_call: int, calls: int = BURST
) -> list[int]:
    """Let a routine of linear algebra fail from one of its calls on; return the calls that did."""
    sound: Callable[..., Any] = getattr(np.linalg, routine)
    made, broken = count(), list[int]()

    def breaks(*arguments: Any, **options: Any) -> Any:
        if from_call <= (call := next(made)) < from_call + calls:
            broken.append(call)
            raise np.linalg.LinAlgError("injected")
        return sound(*arguments, **options)

    monkeypatch.setattr(np.linalg, routine, breaks)
    return broken


def _types(diagram: sf.Diagram) -> list[list[tuple[str, float]]]:
    return [
        [(item.type, round(item.value, 7)) for item in branch.special]
        for branch in diagram.branches
    ]


def _force_response() -> sf.Diagram:
    return sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.2), f=12.5)


def _cycles() -> sf.Diagram:
    return sf.response(sf.built_in_models()["stribeck"](), vary="vd", span=(1.6, 0.8))


@cache
def _sound(study: Callable[[], sf.Diagram]) -> list[list[tuple[str, float]]]:
    """What a study finds where nothing breaks down."""
    return _types(study())


def test_cycles_that_run_into_a_singularity_keep_what_was_found() -> None:
    diagram = sf.response(GROWING, vary="mu", span=(-0.5, 2))
    rest, cycle = diagram.branches
    assert [item.type for item in rest.special] == ["HB"]
    assert rest.stopped.kind == "span"
    assert "no value" in cycle.stopped.reason
    assert 0.9 < cycle.stopped.value < 1.1
    assert cycle.orbit(-1).extrema.of("x")[1][0] == pytest.approx(1, abs=1e-3)


def test_a_root_that_turns_negative_ends_the_branch() -> None:
    root = sf.System(
        name="root",
        parameters={"a": 1.0},
        states={"x": {"rate": "a - x^0.5", "start": 1e-3, "scale": 1.0}},
    )
    (branch,) = sf.response(root, vary="a", span=(0, 1)).branches
    assert "no value" in branch.stopped.reason
    assert float(np.ptp(branch.parameter)) > 0.9


# The first of their calls in every run; all are among those that the study makes.
BREAKDOWNS = [
    pytest.param(study, routine, call, marks=[pytest.mark.long] * (call != calls[0]))
    for study, each in (
        (_force_response, {"inv": (3, 50, 90), "eigvals": (3, 30, 50), "svd": (3, 20)}),
        (_force_response, {"eig": (3, 20), "solve": (3, 12)}),
        (_cycles, {"inv": (3, 30, 45), "eig": (3,), "solve": (3, 8)}),
    )
    for routine, calls in each.items()
    for call in calls
]


@pytest.mark.parametrize(("study", "routine", "from_call"), BREAKDOWNS)
def test_a_breakdown_ends_a_branch_with_a_sentence(
    study: Callable[[], sf.Diagram], routine: str, from_call: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    sound = _sound(study)
    broken = _breaking(monkeypatch, routine, from_call)
    try:
        diagram = study()
    except sf.InputError:  # not even the first orbit: a sentence alone
        assert broken
        return
    assert broken
    assert all(branch.stopped.reason for branch in diagram.branches)
    kept = _types(diagram)[0]
    assert kept == sound[0][: len(kept)]


@pytest.mark.parametrize("routine", ["eigvals", "inv"])
def test_a_passing_breakdown_costs_a_step(routine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    sound = _sound(_force_response)
    for from_call in (30, 47, 71):
        with monkeypatch.context() as patch:
            _breaking(patch, routine, from_call, calls=1)
            assert _types(_force_response()) == sound


@pytest.mark.parametrize("routine", long_except(["inv", "eigvals", "svd", "eig"], ("inv", "svd")))
def test_a_breakdown_ends_a_locus_with_a_sentence(
    routine: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    diagram = _force_response()
    broken = _breaking(monkeypatch, routine, 8)
    found = sf.locus(diagram.special[0], ("f", "Nd"), ((12.45, 12.55), (0, 0.1)))
    assert broken
    for locus in found.loci:
        assert locus.stopped.reason
        assert locus.started.reason


def test_a_cycle_that_comes_to_a_singularity_says_so():
    states = {"x": {"rate": "v", "start": 1}, "v": "(1 - x^2)*v - x + 0.05*log(A - x)"}
    model = sf.System(parameters={"A": 3.0}, states=states)
    diagram = sf.response(sf.periodic_orbit(model), "A", (3.0, 1.5))
    (branch,) = diagram.branches
    assert branch.stopped.kind == "failed"
    assert "the orbit reaches states where the equations have no value" in branch.stopped.reason
    assert "duration" not in diagram.summary().splitlines()[0]


def test_a_cycle_that_is_not_known_is_compared_with_none():
    orbits = orbits_at(GROWING.replace(mu=0.3))
    known = orbits.unknown(np.eye(8, 2), orbits.model)
    with pytest.raises(ArithmeticError, match="nearest to nothing"):
        orbits.started_near(known, np.full(len(known), np.nan))


def test_an_equilibrium_that_runs_away_says_so():
    # x = log(q) has no end as q comes to zero.
    states = {"x": {"rate": "q*exp(-x) - 1", "start": 0.1}}
    model = sf.System(name="logarithm", parameters={"q": 1.0}, states=states)
    (branch,) = sf.response(model, vary="q", span=(1, 0)).branches
    assert branch.states[:-1, 0] == pytest.approx(np.log(branch.parameter[:-1]), rel=1e-9)
    assert branch.states[-1, 0] < -20
    assert "the equilibrium runs away to x = -" in branch.stopped.reason


@pytest.mark.parametrize(
    ("largest", "kind"), [(10.0, "failed"), (7e17, "unresolved")], ids=["ordinary", "unobservable"]
)
def test_a_step_that_fails_beside_an_unobservable_multiplier_is_no_failure(
    monkeypatch, largest, kind
):
    # A doubled cycle of a snaking branch, as of the neural mass model of Tsodyks and Markram.
    monkeypatch.setattr(ends, "nears_homoclinic", lambda orbits, points: None)
    monkeypatch.setattr(ends, "_explained", lambda *given: ("failed", "the step fell"))
    monkeypatch.setattr(ends.BranchEndings, "_put_on_edge", lambda self, traced: False)
    last = SimpleNamespace(multipliers=np.array([largest, 1.0, 0.1]), z=np.zeros(1))
    by = SimpleNamespace(smooth=True)
    orbits = SimpleNamespace(kind="cycle", place=lambda z: (0.5,), by=by)
    traced = SimpleNamespace(curve=orbits, points=[last, last])
    end = ends.BranchEndings((0, 1), None).failed(traced, SimpleNamespace(kind="failed"))
    assert end.kind == kind
    assert "the step fell" in end.reason


def test_an_equilibrium_that_runs_away_as_the_parameter_stands_still_is_left():
    # AUTO's demo pp3 without its third species: the branch begins at p = 0, and comes back to it
    # as x grows without bound. Several hundred points were computed, then the step failed.
    system = sf.System(
        parameters={"p": 0.0},
        states={
            "x": {"rate": "x*(1 - x) - 4*x*y", "start": 0.06},
            "y": {"rate": "-0.25*y + 4*x*y - p*(1 - exp(-5*y))", "start": 0.23},
        },
    )
    branch, *_ = sf.response(system, vary="p", span=(0, 2)).branches
    assert branch.stopped.kind == "unresolved"
    assert "the equilibrium runs away to " in branch.stopped.reason
    assert "while p stays at" in branch.stopped.reason
    assert not branch.failed
    assert len(branch) < 100


def test_a_start_where_a_rate_is_infinite_is_left_without_a_warning():
    model = sf.System(name="pole", parameters={"p": 1.0}, states={"x": "p/x - x"})
    (branch,) = sf.response(model, vary="p", span=(1, 2)).branches
    assert branch.states[:, 0] ** 2 == pytest.approx(branch.parameter, rel=1e-12)


@pytest.mark.parametrize("span", [(0.5, 0.6), (3.0, 2.0)])  # segments overflow, or their product
def test_perturbations_that_outgrow_all_numbers_are_named_without_a_warning(span):
    relaxation = {"x": "(y - x^3/3 + x)/1e-3", "y": "-x + F*cos(W*t)"}
    forcing = {"period": "2*pi/W", "amplitude": "F"}
    model = sf.System(parameters={"W": 1.5, "F": 0.5}, states=relaxation, forcing=forcing)
    # Newton's method may diverge before, by the rounding of matrices of 1e300.
    with pytest.raises(sf.InputError, match=r"outgrow all numbers|was found: Newton's method"):
        sf.response(model, "W", span)


def test_multipliers_whose_products_overflow_end_a_branch():
    from slipfold.bifurcations.branches.stops import stop_unresolved

    orbits = SimpleNamespace(place=lambda z: (0.5,), by=SimpleNamespace(growing=True))
    curve = SimpleNamespace(orbits=orbits, place=orbits.place)
    for largest, second, stops in [(1e204, 1, False), (1e149, 1e149, False), (1e151, 1e151, True)]:
        point = SimpleNamespace(multipliers=np.array([largest, second]), z=np.zeros(1))
        traced = SimpleNamespace(curve=curve, points=[point])
        interval = SimpleNamespace(before=point, point=point, traced=traced)
        assert (stop_unresolved(interval).stop is not None) == stops


def test_a_breakdown_at_a_change_of_contacts_leaves_its_distance_unknown(monkeypatch):
    def breaks(*arguments: Any) -> Any:
        raise np.linalg.LinAlgError("injected")

    monkeypatch.setattr(MarginalShooting, "at", breaks)
    orbits = SimpleNamespace(
        by=object.__new__(SwitchedShooting), nodes=lambda z: z, constants=lambda z: None
    )
    last = SimpleNamespace(z=np.zeros(3), curve=SimpleNamespace(orbits=orbits))
    assert left_to_change(last, "LIFT") == np.inf


def test_a_time_that_is_no_number_breaks_down():
    model = sf.built_in_models()["duffing"]()
    flow = flow_of(model)
    with pytest.raises(ArithmeticError, match="finite"):
        flow.trajectory(np.zeros(2), flow.constants_of(model), np.array([0.0, np.nan]))
