"""Responses for many cases in one call."""

import numpy as np
import pytest
import xarray

import slipfold as sf
from slipfold.results.responses import INTERRUPTED

MODEL = sf.SlidingOscillator(f=12.5)
SPAN = (0, 0.2)
CASES = {"Vd": [0.5, 0.6, 0.9], "alpha": [1.0, 0.9, 0.8]}


@pytest.fixture(scope="module")
def found():
    return sf.responses(MODEL, "Nd", SPAN, over=CASES)


def special(diagram):
    return [(branch.id, p.type, p.value, p.coefficient) for branch, p in diagram.special]


def test_each_is_what_a_response_alone_gives(found):
    assert len(found) == 3
    for index, diagram in enumerate(found):
        alone = sf.response(MODEL, "Nd", SPAN, **found.case(index))
        assert special(diagram) == special(alone)
        assert diagram.checked.agree
        for branch, expected in zip(diagram.branches, alone.branches, strict=True):
            assert np.array_equal(branch.nodes, expected.nodes)


@pytest.mark.parametrize(
    "over",
    [
        [{"Vd": 0.5, "alpha": 1.0}, {"Vd": 0.6, "alpha": 0.9}, {"alpha": 0.8, "Vd": "900 mm/s"}],
        {"Vd": ("0.5m/s", "60cm/s", 0.9), "alpha": np.array([1.0, 0.9, 0.8])},
        xarray.Dataset({name: ("case", values) for name, values in CASES.items()}),
    ],
)
def test_cases_come_as_columns_or_one_by_one(found, over):
    again = sf.responses(MODEL, "Nd", SPAN, over=over)
    assert list(map(special, again)) == list(map(special, found))


def test_a_case_that_fails_says_why_and_leaves_the_others():
    seen = []
    over = {"Vd": [0.6, -1.0, 0.5]}
    found = sf.responses(MODEL, "Nd", SPAN, over=over, on_progress=seen.append)
    assert [diagram is None for diagram in found] == [False, True, False]
    assert found.failures == {1: "Vd = -1 is outside its bounds; Vd must be >= 0 m/s"}
    assert seen[-1] == sf.Progress("cases", 3, 3, values={"failures": 1, "fraction": 1.0})
    assert [item.done for item in seen] == [1, 2, 3]
    assert {item.case for item in found.special} == {0, 2}
    assert "1 without a diagram: Vd = -1 is outside its bounds" in found.summary()


def test_an_interruption_keeps_what_is_finished():
    def stop(progress):
        if progress.done == 2:
            raise KeyboardInterrupt

    found = sf.responses(MODEL, "Nd", SPAN, over=CASES, on_progress=stop)
    assert [diagram is None for diagram in found] == [False, False, True]
    assert found.interrupted
    assert found.failures == {2: INTERRUPTED}


def test_one_dataset_holds_cases_and_their_special_points(found):
    dataset = found.to_xarray()
    assert dataset.Vd.values.tolist() == CASES["Vd"]
    assert dataset.Vd.attrs["units"] == "m/s"
    assert dataset.branches.values.tolist() == [len(diagram.branches) for diagram in found]
    expected = [(item.case, item.point.type, item.point.value) for item in found.special]
    rows = zip(
        dataset.case_of_special.values.tolist(),
        dataset.special_type.values.tolist(),
        dataset.special_value.values.tolist(),
        strict=True,
    )
    assert list(rows) == expected
    assert dataset.special_uncertainty.values.max() < 1e-9


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"over": {}}, "over holds no cases"),
        ({"over": []}, "over holds no cases"),
        ({"over": {"Vd": []}}, "over holds no cases"),
        ({"over": {"Vd": [0.5], "mu": [0.4, 0.5]}}, "1 of Vd, 2 of mu"),
        ({"over": [{"Vd": 0.5}, {"mu": 0.5}]}, "the same parameters in each case"),
        ({"over": [0.5, 0.6]}, "the same parameters in each case"),
        ({"over": {"Vd": 0.5}}, "not a list of numbers"),
        ({"over": {"Vd": [[0.5]]}}, "is not a number"),
        ({"over": {"Vd": ["0.5 N"]}}, "'N'"),
        ({"over": {"speed": [0.5]}}, "speed"),
        ({"over": {"Nd": [0.5]}}, "Nd is followed"),
        ({"mu": 0.4, "over": {"mu": [0.5]}}, "mu is varied"),
        ({"span": (0.1, 0.1)}, "the span of Nd from 0.1 to 0.1 is empty"),
        ({"span": 0.1}, "not a pair of numbers"),
        ({"settings": 3}, "options of continuation"),
        ({"model": "sliding"}, "is not a model"),
    ],
)
def test_what_is_wrong_in_all_cases_is_refused(changes, words):
    given = {"model": MODEL, "vary": "Nd", "span": SPAN, "over": {"Vd": [0.5]}, **changes}
    with pytest.raises(sf.InputError, match=words):
        sf.responses(**given)


def test_many_cases_go_side_by_side():
    over = {"Vd": np.linspace(0.5, 0.8, 16).tolist()}
    over["Vd"][3] = -1.0
    found = sf.responses(MODEL, "Nd", (0, 0.05), over=over)
    assert found.failures == {3: "Vd = -1 is outside its bounds; Vd must be >= 0 m/s"}
    for index in (0, 15):
        alone = sf.response(MODEL, "Nd", (0, 0.05), **found.case(index))
        diagram = found[index]
        assert diagram.checked.agree
        assert diagram.model == alone.model
        assert [branch.stopped for branch in diagram.branches] == [
            branch.stopped for branch in alone.branches
        ]
        for (branch, point), (other, known) in zip(diagram.special, alone.special, strict=True):
            assert (branch.id, point.type) == (other.id, known.type)
            uncertain = point.uncertainty + known.uncertainty + 2e-12 * 0.05  # located to that
            assert abs(point.value - known.value) <= uncertain
