"""Requests: what is not named and bounded is refused, with a sentence."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from helpers.explorer_server import diagram
from slipfold.interface.explorer.messages import parse_request, refusal_of

SIMULATION = {"kind": "simulation", "id": 1, "model": "sliding"}
ORBIT = {**diagram(), "kind": "orbit"}
del ORBIT["show"]
PLANE = {
    "kind": "plane",
    "id": 1,
    "model": "sliding",
    "x": {"name": "f", "span": [12, 13]},
    "y": {"name": "Nd", "span": [0, 0.5]},
}

BAD = {
    "no kind": {"id": 1},
    "unknown kind": {"kind": "shell", "id": 1},
    "another field": diagram(path="/etc/passwd"),
    "a parameter that is text": diagram(parameters={"f": "__import__('os')"}),
    "a parameter that is true": diagram(parameters={"f": True}),
    "a name that is no name": diagram(parameters={"f; drop": 1.0}),
    "too many parameters": diagram(parameters={f"p{i}": 1.0 for i in range(1001)}),
    "a huge value": diagram(parameters={"f": 1e101}),
    "a model that is a path": diagram(model="../../etc/passwd"),
    "a text without end": diagram(text="#" * (64 * 1024 + 1)),
    "a span of three": diagram(span=[0, 1, 2]),
    "an unknown statistic": diagram(statistic="mean"),
    "an output that is a formula": diagram(show="x+y"),
    "a slot that is none": diagram(slot="pin:1234"),
    "an id that is text": diagram(number="1"),
    "an orbit without a place": ORBIT,
    "an orbit of period 0": {**ORBIT, "at": {"value": 0.1, "state": {}, "period": 0}},
    "an orbit on branch 0": {**ORBIT, "at": {"branch": 0, "arclength": 0.1}},
    "a motion that never ends": {**SIMULATION, "periods": 10**6},
    "a motion from nowhere": {**SIMULATION, "start": "file:///state"},
    "a plane with one parameter": {**PLANE, "y": PLANE["x"]},
    "a cancel of nothing": {"kind": "cancel", "id": 1, "of": "server"},
}


@pytest.mark.parametrize("request_", BAD.values(), ids=BAD.keys())
def test_bad_requests_are_refused_in_a_sentence_that_repeats_nothing(request_):
    text = json.dumps(request_)
    with pytest.raises(ValidationError) as raised:
        parse_request(text)
    answer = refusal_of(text, raised.value)
    assert answer["error"].startswith("the request cannot be used: ")
    assert "\n" not in answer["error"]
    assert "passwd" not in answer["error"]


@pytest.mark.parametrize("value", ["NaN", "Infinity", "-Infinity", "1e999"])
def test_numbers_are_finite(value):
    with pytest.raises(ValidationError):
        parse_request(json.dumps(diagram()).replace("12.5", value))


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3)
    ),
    max_leaves=8,
)


@given(JSON | st.text(max_size=40) | st.binary(max_size=40))
def test_junk_is_refused_and_the_refusal_is_json(junk):
    text = junk if isinstance(junk, (str, bytes)) else json.dumps(junk)
    with pytest.raises(ValidationError) as raised:
        parse_request(text)
    json.dumps(refusal_of(text, raised.value), allow_nan=False)
