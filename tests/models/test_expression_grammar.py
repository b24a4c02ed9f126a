"""Formulas: values as in Python's own arithmetic, trees that fit their texts, clear messages."""

import builtins
import math
import subprocess

import heyoka as hy
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slipfold.models.formulas.functions import FUNCTIONS
from slipfold.models.formulas.grammar import (
    Binary,
    Call,
    FormulaError,
    Name,
    Negative,
    Number,
    fold,
    format_tree,
    names_in,
    parse_formula,
)
from slipfold.models.formulas.values import value_of

VALUES = {"a": 1.7, "b": 0.6, "q_1": -2.3}

NUMBERS = st.one_of(
    st.sampled_from(["2", "3.", ".5", "0.25", "1e-3", "2E+1", "1.5e2"]),
    st.floats(0, 1e3).map(repr),
)
OPERANDS = st.one_of(st.sampled_from(sorted(VALUES)), NUMBERS)


def chains(inner):
    """Operands, signed or in parentheses, with operators and spaces between."""
    signed = st.tuples(st.sampled_from(["", "", "-", "+", "--"]), inner).map("".join)
    item = st.one_of(signed, inner.map("({})".format))
    sign = st.sampled_from(["+", "-", "*", "/", "^", " + ", " - ", " * "])
    more = st.lists(st.tuples(sign, item).map("".join), max_size=4).map("".join)
    return st.tuples(item, more).map("".join)


TEXTS = st.recursive(OPERANDS, chains, max_leaves=12)


def nodes(inner):
    calls = [
        st.tuples(*[inner] * function.count).map(lambda args, name=name: Call(name, args))
        for name, function in FUNCTIONS.items()
    ]
    return st.one_of(
        st.builds(Negative, inner),
        st.builds(Binary, st.sampled_from("+-*/^"), inner, inner),
        st.builds(Binary, st.just("^"), inner, st.integers(0, 9).map(float).map(Number)),
        *calls,
    )


TREES = st.recursive(
    st.one_of(
        st.builds(Number, st.floats(0, 100)),
        st.builds(Number, st.sampled_from([5e-324, 1e-310, 1e15, 1e16, 1.7976931348623157e308])),
        st.builds(Name, st.sampled_from([*VALUES, "_", "sin", "E1"])),
    ),
    nodes,
    max_leaves=20,
)


def by_python(text):
    """The value by Python's own arithmetic; NaN where it has none in real numbers."""
    try:
        value = eval(text.replace("^", "**"), {"__builtins__": {}}, dict(VALUES))
    except (ZeroDivisionError, OverflowError):
        return math.nan
    return math.nan if isinstance(value, complex) else float(value)


@settings(max_examples=100)
@given(TEXTS)
def test_values_are_those_of_pythons_arithmetic(text):
    expected = by_python(text)
    found = float(value_of(parse_formula(text), VALUES))
    if math.isfinite(expected):
        assert found == pytest.approx(expected, rel=1e-14)
    else:
        assert not math.isfinite(found)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("-2^2", -4),
        ("2^3^2", 512),
        ("2^-1", 0.5),
        ("-2^-2", -0.25),
        ("2*-3", -6),
        ("8/4/2", 1),
        ("8/4*2", 4),
        ("2 - 3 - 4", -5),
        ("2 - -3", 5),
        ("--2", 2),
        ("+2", 2),
        ("-(1 + 2)^2*2", -18),
        ("2\n +\t3", 5),
        ("cos(pi) + atan2(1, -1)/pi", -0.25),
        ("exp(1)", math.e),
        ("1e3 + 1.e-1 + .5E0", 1000.6),
    ],
)
def test_precedence(text, value):
    assert value_of(parse_formula(text), {"pi": math.pi}) == pytest.approx(value, rel=1e-15)


@settings(max_examples=100)
@given(TREES)
def test_a_tree_written_and_read_is_the_same_tree(tree):
    text = format_tree(tree)
    assert parse_formula(text) == tree
    assert format_tree(parse_formula(text)) == text


@settings(max_examples=40)
@given(TREES)
def test_symbols_and_floats_agree(tree):
    symbols = {name: hy.expression(name) for name in names_in(tree)}
    values = {name: VALUES.get(name, 0.3) for name in symbols}
    in_floats = value_of(tree, values)
    if not math.isfinite(in_floats):
        return
    in_symbols = value_of(tree, symbols)
    if not isinstance(in_symbols, hy.expression):
        assert in_symbols == in_floats
        return
    function = hy.cfunc([in_symbols], vars=list(symbols.values()), compact_mode=True)
    found = function(np.array(list(values.values())))[0]
    # What floats raise as an error is NaN or infinite in symbols; large results lose digits.
    if math.isfinite(found) and abs(in_floats) < 1e8:
        assert found == pytest.approx(in_floats, rel=1e-8, abs=1e-12)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_have_series_and_derivatives(name):
    position = 1.3 if name == "acosh" else 0.4
    x = hy.expression("x")
    arguments = (x, hy.expression(0.8)) if FUNCTIONS[name].count == 2 else (x,)
    function = FUNCTIONS[name].symbolic(*arguments)
    numeric = [position, 0.8][: len(arguments)]
    slope = hy.cfunc([function, hy.diff(function, x)], vars=[x])(np.array([position]))
    step = 1e-6
    ahead, behind = (FUNCTIONS[name].numeric(position + s, *numeric[1:]) for s in (step, -step))
    assert slope[0] == pytest.approx(FUNCTIONS[name].numeric(*numeric), rel=1e-14)
    assert slope[1] == pytest.approx((ahead - behind) / (2 * step), rel=1e-8)
    flow = hy.taylor_adaptive([(x, function)], state=[position])
    flow.propagate_until(0.05)
    assert np.isfinite(flow.state).all()


@pytest.mark.parametrize("exponent", [2, 3, 5, 8])
def test_whole_powers_have_a_series_at_zero(exponent):
    x, y = hy.make_vars("x", "y")
    power = value_of(parse_formula(f"x^{exponent}"), {"x": x})
    flow = hy.taylor_adaptive([(x, hy.expression(1.0)), (y, power)], state=[-1.0, 0.0])
    flow.propagate_until(2.0)
    assert flow.state[1] == pytest.approx((1 - (-1) ** (exponent + 1)) / (exponent + 1), abs=1e-13)


@pytest.mark.parametrize(
    ("text", "position", "words"),
    [
        ("", 0, "the formula is empty"),
        ("   ", 0, "the formula is empty"),
        ("q +", 3, "the formula ends where a number, a name or a parenthesis should"),
        ("* q", 0, "'*' stands where a number"),
        ("q + )", 4, "')' stands where a number"),
        ("(q + 1", 0, "this parenthesis is never closed"),
        ("sin(q", 3, "this parenthesis is never closed"),
        ("q + 1)", 5, "this parenthesis was never opened"),
        ("2 q", 2, "there is no operator between 2 and q; for a product write 2*q"),
        ("2q", 1, "for a product write 2*q"),
        ("(a)(b)", 3, "there is no operator between ) and ("),
        ("1.2.3", 3, "there is no operator between 1.2 and .3"),
        ("a.b", 1, "names have no points"),
        ("1,5", 1, "numbers have a point, e.g. 0.5"),
        ("q**3", 1, "powers are written with ^, not with **"),
        ("q = 3", 2, "a formula gives a value and sets none"),
        ("q'", 1, "for the derivative of a state write the name of its rate"),
        ("q > 0", 2, "rates must be smooth"),
        ("q[0]", 1, "write parentheses"),
        ("2·q", 1, "write * for a product"),
        ("2 − q", 2, "write - for minus"),
        ("μ*q", 0, "the character 'μ' has no meaning"),
        ("1e999", 0, "the number 1e999 is larger than the largest"),
        ("sinus(q)", 0, "there is no function 'sinus'; did you mean sin?"),
        ("1 + wave(q)", 4, "there is no function 'wave'; the functions are sin, cos"),
        ("ln(q)", 0, "there is no function 'ln'; write log(x)"),
        ("arctan(q)", 0, "write atan(x)"),
        ("pow(q, 2)", 0, "write x^y"),
        ("abs(q)", 0, "abs is not smooth, and flows and their derivatives need smooth rates"),
        ("sign(q)", 0, "write tanh(x/e) for a sign"),
        ("sign(q)", 0, "FrictionContact with an exact law such as Coulomb"),
        ("max(q, 0)", 0, "max is not smooth"),
        ("sin()", 0, "sin takes 1 argument, not 0; write sin(x)"),
        ("sin(q, 2)", 0, "sin takes 1 argument, not 2"),
        ("atan2(q)", 0, "atan2 takes 2 arguments, not 1; write atan2(y, x)"),
        ("sin(q,)", 6, "')' stands where a number"),
        ("(" * 100 + "q" + ")" * 100, 60, "nested more than 60 deep"),
        ("-" * 100 + "q", 60, "nested more than 60 deep"),
        ("2^" * 100 + "q", 120, "nested more than 60 deep"),
        ("q" + "+q" * 9000, 0, "has 18001 characters, more than 10000"),
    ],
)
def test_messages_say_what_is_wrong_where_and_what_to_do(text, position, words):
    with pytest.raises(FormulaError) as error:
        parse_formula(text)
    assert words in error.value.message
    assert error.value.position == position
    assert "\n" not in error.value.message


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os')",
        '__import__("os").system("touch /tmp/h")',
        "().__class__.__bases__[0]",
        "lambda: 0",
        "[q for q in (1, 2)]",
        "q if q else 1",
        "exec(q)",
        "eval(q)",
        "open(q)",
        "print(q)",
        "f'{q}'",
        "q; import os",
        "import os",
        "q.__class__",
        "{q}",
        "q := 1",
        "1_000",
        "0x10",
        "1j",
        "True and q",
        "@q",
        "q!",
        "\\u0071",
        "q\x00",
    ],
)
def test_nothing_but_formulas_is_understood(text, monkeypatch):
    def refuse(*_):
        raise AssertionError("something was run")

    with monkeypatch.context() as patch:
        patch.setattr(subprocess, "Popen", refuse)
        for name in ("eval", "exec", "compile", "open", "__import__"):
            patch.setattr(builtins, name, refuse)
        try:
            found = parse_formula(text)
        except FormulaError as error:
            found = error
    assert isinstance(found, FormulaError)


def test_long_sums_need_no_deep_stack():
    text = "+".join(["q"] * 4000)
    tree = parse_formula(text)
    assert value_of(tree, {"q": 0.5}) == 2000
    assert format_tree(tree).count("+") == 3999
    assert fold(tree, lambda node, values: 1 + sum(values)) == 7999
