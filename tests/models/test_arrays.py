"""Systems with indexed states and equations: written out they are what one would write by hand."""

import contextlib
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import slipfold as sf
from slipfold import InputError
from slipfold.models.model import evaluation_of

CHAIN = """
name = "chain"
[sizes]
n = 50
[parameters]
k = 1.0
d = { value = 0.02, min = 0 }
F = 0.1
W = { value = 0.5, above = 0 }
[formulas]
"x[0]" = "0"
"x[n+1]" = "0"
[states]
"x[i=1:n]" = { rate = "v[i]", doc = "displacement of mass {i}" }
"v[1]" = "k*(x[0] - 2*x[1] + x[2]) - d*v[1] + F*cos(W*t)"
"v[i=2:n]" = "k*(x[i-1] - 2*x[i] + x[i+1]) - d*v[i]"
[forcing]
period = "2*pi/W"
[outputs]
energy = "sum(i=1:n, v[i]^2)/2 + sum(i=1:n+1, k*(x[i] - x[i-1])^2)/2"
"strain[i=1:n+1]" = "x[i] - x[i-1]"
"""


def text(**changes):
    tables = CHAIN
    for old, new in changes.items():
        tables = tables.replace(old, new)
    return tables


def test_a_chain_of_fifty_has_the_frequencies_of_the_textbook():
    chain = sf.System.from_toml(text())
    assert [state.name for state in chain.states[:51]] == [*(f"x{i}" for i in range(1, 51)), "v1"]
    assert chain.states[11].doc == "displacement of mass 12"
    assert chain.states[11].label == "$x_{12}$"
    jacobian = evaluation_of(chain).jacobian(chain.replace(d=0), np.zeros(100))
    order = np.arange(1, 51)
    exact = 2 * np.sin(order * math.pi / 102)
    found = np.sort(np.linalg.eigvals(jacobian).imag)[50:]
    assert found == pytest.approx(exact, abs=1e-12)
    state = np.concatenate([np.sin(np.pi * order / 51), np.zeros(50)])
    # The energy of the first mode.
    assert chain.evaluate("energy", state) == pytest.approx(exact[0] ** 2 * 51 / 4, rel=1e-12)
    assert chain.evaluate("strain51", state) == pytest.approx(-state[49])


def test_it_responds_as_its_matrices_say():
    chain = sf.System.from_toml(text(**{"n = 50": "n = 6"}))
    orbit = sf.periodic_orbit(chain)
    stiffness = 2 * np.eye(6) - np.eye(6, k=1) - np.eye(6, k=-1)
    force = np.array([0.1, 0, 0, 0, 0, 0])
    exact = np.linalg.solve(stiffness - 0.25 * np.eye(6) + 0.01j * np.eye(6), force).real
    assert orbit.state[:6] == pytest.approx(exact, abs=1e-10)


def test_arrays_are_what_they_are_written_out_by_hand():
    ring = sf.System(
        name="ring",
        sizes={"n": 3},
        parameters={"w[i=1:n]": [1.0, 1.1, 1.2], "K": 0.3},
        formulas={"x[0]": "x[n]", "x[n+1]": "x[1]"},
        states={
            "x[i=1:n]": {"rate": "w[i] + K/n*sum(j=1:n, sin(x[j] - x[i]))", "start": [0, 1, 2]}
        },
        outputs={"u[i=1:2,j=i:2]": "i*x[i] - j*x[j]", "mean[2*1]": "(x[0] + x[n+1])/2"},
        limits={"near[i=1:2]": {"output": "x[i]", "bound": -5, "reason": "mass {i} is at {value}"}},
        events={"far": {"output": "x[n]", "value": 4}},
    )  # fmt: skip
    by_hand = sf.System(
        name="ring",
        parameters={
            "w1": {"value": 1.0, "symbol": "$w_{1}$"},
            "w2": {"value": 1.1, "symbol": "$w_{2}$"},
            "w3": {"value": 1.2, "symbol": "$w_{3}$"},
            "K": 0.3,
        },
        formulas={"x0": "x3", "x4": "x1"},
        states={
            f"x{i}": {
                "rate": f"w{i} + K/3*(sin(x1 - x{i}) + sin(x2 - x{i}) + sin(x3 - x{i}))",
                "start": i - 1,
                "label": f"$x_{{{i}}}$",
            }
            for i in (1, 2, 3)
        },
        outputs={
            "u1_1": {"formula": "1*x1 - 1*x1", "label": "$u_{1,1}$"},
            "u1_2": {"formula": "1*x1 - 2*x2", "label": "$u_{1,2}$"},
            "u2_2": {"formula": "2*x2 - 2*x2", "label": "$u_{2,2}$"},
            "mean2": "(x0 + x4)/2",
        },
        limits={
            f"near{i}": {"output": f"x{i}", "bound": -5, "reason": f"mass {i} is at {{value}}"}
            for i in (1, 2)
        },
        events={"far": {"output": "x3", "value": 4}},
    )
    assert ring.to_toml() == by_hand.to_toml()
    assert ring == by_hand
    assert sf.System.from_toml(ring.to_toml()) == ring


MISTAKES = {
    "beyond the ends": ({'"x[0]" = "0"': ""}, ["there is no name 'x0'", "line 15"]),
    "twice": ({"i=2:n": "i=1:n"}, ["v1 is given twice"]),
    "index is a parameter": ({"v[i=2:n]": "v[k=2:n]"}, ["k is an index here and stands in [param"]),
    "size is a parameter": ({"n = 50": "n = 50\nk = 2"}, ["k is in [sizes] and [parameters]"]),
    "no whole number": ({"n = 50": "n = 5.5"}, ["n is a number", "whole number"]),
    "unknown index": ({"x[i+1])": "x[m+1])"}, ["m is not an index", "known here: n, i", "x[m+1]"]),
    "never closed": ({"x[i+1])": "x[i+1"}, ["this [ is never closed"]),
    "too many": ({"n = 50": "n = 1001"}, ["more than 1000"]),
    "far too many": ({"n = 50": "n = 99999"}, ["more than 1000"]),
    "sum without a range": ({"sum(i=1:n, v[i]^2)": "sum(v[1])"}, ["no function 'sum'", "range"]),
    "sum without a term": ({"sum(i=1:n, v[i]^2)": "sum(i=1:n)"}, ["a range and a term"]),
    "lists of another length": ({'"x[n+1]" = "0"': '"y[i=1:3]" = ["0", "1"]'}, ["2 items for 3"]),
    "half an index": ({"x[i+1])": "x[i/2])"}, ["i/2 is not an index"]),
    "negative index": ({"x[i-1]": "x[i-9]"}, ["the index i-9 is -7; give one from 0"]),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes_are_reported_at_their_place(mistake):
    changes, words = MISTAKES[mistake]
    with pytest.raises(InputError) as caught:
        sf.System.from_toml(text(**changes))
    for word in words:
        assert word in str(caught.value)


@given(st.text("xi[]=:,+-*()1n sum\n", max_size=30), st.text("xi[]=:,+-*()12n^ sum", max_size=30))
@settings(max_examples=100, deadline=None)
def test_nonsense_is_refused_in_a_sentence(key, formula):
    with contextlib.suppress(InputError):
        sf.System(sizes={"n": 3}, states={key: formula, "x[i=1:n]": "x[i]"})
