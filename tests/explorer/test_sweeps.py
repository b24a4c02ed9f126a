"""A motion is followed up and down the span of a diagram."""

import pytest

import slipfold as sf
from helpers.dry_friction import belt
from slipfold.interface.explorer.messages import SweepRequest
from slipfold.interface.explorer.sweeps import send_sweep
from slipfold.models.registry import model_named


def swept(model, vary, span, **options):
    request = SweepRequest(
        kind="sweep", id=1, model=model.name, vary=vary, span=span, show=model.states[0].name,
        **options,
    )  # fmt: skip
    pieces = []
    send_sweep(model, request, pieces.append, lambda: None)
    assert [piece["done"] for piece in pieces] == [False] * (len(pieces) - 1) + [True]
    runs = {run: {} for run in request.runs}
    for piece in pieces[:-1]:
        runs[piece["run"]][piece["x"]] = piece["y"]
    return runs, pieces[-1]["ends"]


def test_its_runs_are_those_of_sweep():
    model = sf.SlidingOscillator(f=12.2)
    runs, ends = swept(model, "Nd", (0.15, 0.05), points=5)
    assert ends == {}
    result = sf.sweep(model, "Nd", (0.05, 0.15), points=5, starts=0)
    assert list(runs["up"]) == result.values.tolist()
    assert list(runs["down"]) == result.values[::-1].tolist()
    for run in ("up", "down"):
        assert [len(runs[run][value]) for value in result.values] == result.repeats(run).tolist()
    state = dict(zip(["x", "y", "vx", "vy"], result.states[0, 0, -1], strict=True))
    extrema = sf.periodic_orbit(model.replace(Nd=0.05), 1, state).extrema
    assert runs["up"][0.05] == pytest.approx([extrema.maximum[0][0]], rel=1e-5)


def test_a_belt_that_is_made_faster_ends_its_stick_and_slip_later_than_it_begins():
    model = belt(sf.Stribeck(mu_s=0.6, mu_k=0.3, vs=0.4), damping=0.05)
    runs, ends = swept(model, "Vd", (0.2, 3.0), points=8)
    assert ends == {}
    apart = [v for v in runs["up"] if max(runs["up"][v]) > 1.2 * max(runs["down"][v])]
    assert apart == [1.4]  # at 1.0 what leaves the equilibrium of 1.4 grows to stick and slip


def test_both_runs_begin_from_a_motion_that_is_shown():
    # At W = 1.2 Duffing's oscillator has two stable responses; this is on the large one.
    model = sf.built_in_models()["duffing"]()
    large = sf.simulate(model, 200, {"q": 2.0, "v": 0.0}, W=1.2).states[-1]
    start = dict(zip(("q", "v"), large.tolist(), strict=True))
    runs, ends = swept(model, "W", (1.1, 1.3), points=10, begin=1.2, start=start)
    assert ends == {}
    assert {run: [*values][:: len(values) - 1] for run, values in runs.items()} == {
        "up": [1.2, 1.3],
        "down": [1.2, 1.1],
    }
    extrema = sf.periodic_orbit(model.replace(W=1.2), 1, start).extrema
    assert runs["up"][1.2] == runs["down"][1.2]
    assert runs["up"][1.2] == pytest.approx([extrema.maximum[0][0]], rel=1e-5)
    from_rest = swept(model, "W", (1.2, 1.3), points=2)[0]
    assert from_rest["up"][1.2][0] < 0.5 * runs["up"][1.2][0]


def test_a_run_ends_where_the_model_does():
    runs, ends = swept(sf.SlidingOscillator(f=12.5), "Nd", (0.9, 1.4), points=6)
    assert set(ends) == {"up", "down"}
    assert len(runs["up"]) < 6


def test_a_motion_that_rests_is_one_point():
    model = model_named("stribeck")
    first = model.variable_parameters[0]
    value = model.values[first.name]
    runs, _ = swept(model, first.name, (value, 1.1 * value), points=2, statistic="max_and_min")
    assert {len(each) for run in runs.values() for each in run.values()} == {1}
