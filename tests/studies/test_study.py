"""Studies from beginning to end, in one process."""

import pickle

import numpy as np
import pytest

import slipfold as sf
from helpers.studies import CHEAP, content
from slipfold import InputError
from slipfold.parameter_space.sampling import drawn
from slipfold.studies import plan
from slipfold.studies.plan import read_plan
from slipfold.studies.run import StudyTask, compute, versions

LISTED = {
    "model": "sliding",
    "parameters": {"f": 12.5},
    "compute": {"what": "threshold", "vary": "Nd", "span": [0, 0.9]},
    "cases": {"list": [{"Vd": 0.6}, {"Vd": -1}, {"Vd": 0.5}, {"Vd": 0.55}]},
}


@pytest.fixture(scope="module")
def cheap():
    return sf.study(CHEAP)


def test_the_response_with_its_special_points():
    compute = {"what": "response", "vary": "Nd", "span": [0, 0.1], "largest_period": 2}
    cases = {"grid": {"Vd": [0.5, 0.6]}}
    found = sf.study(
        {"model": "sliding", "parameters": {"f": 12.5}, "compute": compute, "cases": cases}
    )
    settings = sf.Settings(largest_period=2)
    places = []
    for number, speed in enumerate((0.5, 0.6)):
        diagram = sf.response(
            sf.SlidingOscillator(f=12.5, Vd=speed), "Nd", (0, 0.1), settings=settings
        )
        places += [(number, point.type, point.value) for _, point in diagram.special]
        assert found.values["threshold"][number] == diagram.branches[0].special[0].value
        assert found.values["branches"][number] == len(diagram.branches)
    special = found.listed
    assert places == list(zip(special["case"], special["type"], special["value"], strict=True))
    assert found.to_xarray().special_value.attrs["units"] == "N"


def test_a_failed_case_says_why_and_stops_no_others(tmp_path):
    store = tmp_path / "listed.study"
    found = sf.study(LISTED, store)
    assert list(found.failures) == [1]
    assert "Vd = -1 is outside its bounds" in found.failures[1]
    assert "3 PD" in found.summary()
    assert "\nreason" not in found.summary()  # a row without anything to say
    assert "1 failed: Vd = -1 is outside" in found.summary()
    assert found.case(1) == {"Vd": -1}
    assert found.values["outcome"][[0, 2]].tolist() == ["PD", "PD"]
    assert np.isnan(found.values["threshold"][1])
    again = sf.study(LISTED, store, retry_failed=True)
    assert content(again, tmp_path) == content(found, tmp_path)


def test_only_failed_cases_are_tried_again(tmp_path, monkeypatch):
    store = tmp_path / "listed.study"
    with monkeypatch.context() as patched:
        patched.setattr("slipfold.parameter_space.loss.trace_response", _broken)
        patched.setattr("slipfold.studies.works.follow_batch", _broken_together)
        found = sf.study(LISTED, store)
        assert "the computation broke down (it is broken)" in found.failures[0]
        assert "slipfold failed (KeyError" in found.failures[2]
    lines = (store / "cases.jsonl").read_text().count("\n")
    found = sf.study(LISTED, store, retry_failed=True)
    assert list(found.failures) == [1]
    assert (store / "cases.jsonl").read_text().count("\n") == lines + 4


def _broken_together(models, *arguments, **options):
    raise KeyError("defect")


def _broken(model, *arguments, **options):
    raise ZeroDivisionError("it is broken") if model.Vd == 0.6 else KeyError("defect")


def test_interrupted_and_resumed_it_is_the_same_to_the_byte(cheap, tmp_path):
    store = tmp_path / "cheap.study"

    def stop(progress):
        if progress.done:
            raise KeyboardInterrupt

    rounds = 0
    found = sf.study(CHEAP, store, on_progress=stop)
    while found.interrupted and rounds < 3:
        assert 0 < found.done < len(found)
        found = sf.study(CHEAP, store, resume=True, on_progress=stop)
        rounds += 1
    found = sf.study(CHEAP, store, resume=True)
    assert content(found, tmp_path) == content(cheap, tmp_path)


def test_interrupted_while_failed_cases_are_tried_again_it_says_so(tmp_path):
    store = tmp_path / "listed.study"

    def stop(progress):
        raise KeyboardInterrupt

    assert not sf.study(LISTED, store).interrupted
    found = sf.study(LISTED, store, retry_failed=True, on_progress=stop)
    assert (found.interrupted, found.done) == (True, 4)
    content(found, tmp_path)
    assert sf.load(tmp_path / "result.nc").interrupted

    def stop_at_the_end(progress):
        if progress.values.get("rate"):
            raise KeyboardInterrupt

    assert not sf.study(LISTED, store, retry_failed=True, on_progress=stop_at_the_end).interrupted


@pytest.mark.parametrize("method", ["sobol", "latin hypercube", "random"])
def test_a_store_with_other_draws_of_the_same_seed_is_not_gone_on_with(
    method, tmp_path, monkeypatch
):
    cases = {"sample": method, "count": 4, "seed": 3, "distributions": {"mu": "uniform 0.4:0.6"}}
    given, store = {**CHEAP, "cases": cases}, tmp_path / "drawn.study"
    known = sf.study(given, store)
    again = sf.study(given, store, resume=True)
    assert content(again, tmp_path) == content(known, tmp_path)

    # What another processor rounds otherwise is the same, what is drawn otherwise is not.
    with monkeypatch.context() as patched:
        patched.setattr(plan, "drawn", lambda *given: drawn(*given) * (1 + 1e-15))
        sf.study(given, store, resume=True)
    monkeypatch.setattr(plan, "drawn", lambda *given: drawn(*given)[::-1])
    with pytest.raises(InputError, match=r"drawn\.study was started when the same seed drew other"):
        sf.study(given, store, resume=True)


def test_models_from_files_go_to_other_processes(tmp_path):
    """What a worker gets holds the whole model: it has no files of its own."""
    (tmp_path / "spring.toml").write_text(
        'name = "spring"\n[states]\nq = "v"\nv = "-k*q - 0.1*v + cos(W*t)"\n'
        '[parameters]\nk = 1.0\nW = 0.7\n[forcing]\nperiod = "2*pi/W"\n'
    )
    (tmp_path / "case.toml").write_text(
        'model = "spring.toml"\ncompute = {what = "simulation", periods = 2}\n'
        "[cases.grid]\nk = [1.0, 2.0]\n"
    )
    plan = pickle.loads(pickle.dumps(read_plan(tmp_path / "case.toml")))
    (tmp_path / "spring.toml").unlink()
    values = plan.cases.values(np.array([1]))
    task = StudyTask(plan.model, plan.work, ("k",), (1,), values, versions())
    (record,) = compute(pickle.loads(pickle.dumps(task))).records
    alone = sf.simulate(plan.model, 2, k=2.0)
    assert record["found"]["last_q"] == alone.states[-1][0]


def test_what_is_no_executor_is_refused():
    with pytest.raises(InputError, match=r"executor = 0 is not a valid executor"):
        sf.study(CHEAP, executor=0)
