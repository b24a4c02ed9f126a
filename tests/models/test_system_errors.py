"""Systems of equations say what is wrong with their text, and where."""

import re

import pytest

import slipfold as sf
import slipfold.bifurcations.branches.settings
from helpers.duffing_text import TEXT
from slipfold import InputError
from slipfold.errors import refusal

OF_TEXT = {
    "unknown name": ("force - ", "farce - ", "farce - 0.05", ["'farce'", "did you mean force?"]),
    "known names": (
        "- cubic", "- x", 'x"',
        ["known are the states q, v, the parameters W, F, g, the formulas cubic, force, stiff"],
    ),
    "unknown function": ("cos(", "coss(", 'coss(W*t)"', ["no function 'coss'; did you mean cos?"]),
    "corner": ("0.05*v", "abs(v)", "abs(v) - sti", ["abs is not smooth"]),
    "grammar": ("0.05*v", "0.05 v", "v - stiff*q", ["for a product write 0.05*v"]),
    "degrees": (
        '}\n[formulas]\ncubic = "g*', ', unit = "deg" }\n[formulas]\ncubic = "sin(2*g + g/3)*',
        "g + g/3)*q",
        ["sin takes radians, but g is in deg"],
    ),
    "Euler": ("0.05*v", "e*v", "e*v - stiff*", ["write exp(1) for Euler's number"]),
    "circle of one": ('"g*q^3"', '"cubic*q"', 'cubic = "cub', ["the formula cubic uses itself"]),
    "time in the period": ('"2*pi/W"', '"2*pi/t"', 't"', ["cannot depend on the time t"]),
    "period of a state": ('"2*pi/W"', '"2*pi/v"', 'v"', ["depends on the state v"]),
    "period of a formula": ('"2*pi/W"', '"cubic"', 'cubic"', ["depends on the formula cubic"]),
    "wrong period": (
        '"2*pi/W"', '"pi/W"', '"force - 0.0',
        ["rate of v does not repeat", "pi/W, 3.49"],
    ),
    "no period": ('period = "2*pi/W"', "", "[forcing]", ["forcing has no period", "autonomous"]),
    "quiet nothing": ('"F"', '"f"', '"f"', ["no parameter 'f'", "did you mean F?"]),
    "formula and state": ("stiff =", "v =", 'v = "force -', ["v is a formula and a state"]),
    "output and state": ("energy =", "q =", 'q = "v^2/2 +', ["q is a state and an output"]),
    "key given twice": ("F = 0.18", "W = 1", "", ["not TOML", "overwrite"]),
    "no rate": ('{ rate = "v",', "{ ", '{  doc = "di', ["q has no rate; give e.g. rate ="]),
    "rate true": (
        'rate = "v"', "rate = true", "true, doc =",
        ["rate is true or false; give a text"],
    ),
    "scale zero": ("start = 0.5", "scale = 0", "0 }", ["states.q.scale = 0 is not > 0"]),
    "start text": ("start = 0.5", 'start = "x"', '"x" }', ["start = 'x' is not a number"]),
    "no value": ("{ value = 0.1,", "{", "{ max = 10 }", ["parameters.g has no value"]),
    "value true": ("F = 0.18", "F = true", "true", ["value is true or false; give a number"]),
    "value of no unit": ("F = 0.18", 'F = "1 N"', '"1 N"', ["or declare a unit as in { value ="]),
    "value infinite": ("F = 0.18", "F = inf", "inf", ["value = inf is not a finite number"]),
    "value outside": ("max = 10", "max = 0", "{ value = 0.", ["g = 0.1 is outside its bounds"]),
    "bounds exchanged": (
        "max = 10", "max = 0, min = 1", "{ value = 0.",
        ["from 1 to 0; exchange the bounds"],
    ),
    "bound twice": ("above = 0", "above = 0, min = 1", "0, min = 1,", ["both min and above"]),
    "doc of lines": (
        '"forcing frequency"', "\"a\\nb\"", "\"a\\nb\" }",
        ["doc = ", "more than one line"],
    ),
    "unknown entry": (
        "above = 0", "lower = 0", "lower = 0, d",
        ["no entry 'lower'", "min, above, max"],
    ),
    "unknown table": ("[outputs]", "[output]", "[output]", ["no entry 'output'", "outputs?"]),
    "name of a function": (
        "F = 0.18", "sin = 0.18", "sin = 0.18",
        ["sin is a function in formulas"],
    ),
    "name of the time": ("F = 0.18", "t = 0.18", "t = 0.18", ["t is the time in formulas"]),
    "name of a constant": ("F = 0.18", "pi = 0.18", "pi = 0.18", ["pi is a constant in formulas"]),
    "name with a hyphen": ("F = 0.18", "F-0 = 0.18", "F-0 = 0.18", ["'F-0' cannot be a name"]),
    "name taken": ("F = 0.18", "states = 1", "states = 1", ["cannot be called states"]),
    "state taken": (
        'v = "force', 'phase = "force', 'phase = "for',
        ["state cannot be called phase"],
    ),
    "limit of nothing": (
        'output = "energy"', 'output = "enrgy"', '"enrgy", bou',
        ["no output 'enrgy'", "energy?"],
    ),
    "limit a number": (
        '"too far" = {', '"too far" = 3 #', "3 # output =",
        ["is a number, not a table"],
    ),
    "braces": ("{value:.3g}", "{value.__class__}", '"energy fell', ["but no other braces"]),
    "event of nothing": ('output = "q", value', 'output = "z", value', '"z"', ["no output 'z'"]),
    "event of unknown measure": (
        '"max"', '"mean"', '"mean", stop',
        ["measure = 'mean' is unknown"],
    ),
    "event without value": ("value = 2,", "", '{ output = "', ["events.large has no value"]),
    "stop a number": ("stop = true", "stop = 1", "1 }", ["stop is a number; give true or"]),
    "no number": ("0.05*v", "v/0", "/0 - stiff*q", ["is not a finite number"]),
    "not TOML": ("F = 0.18", "F = ", "", ["this is not TOML (Invalid value)", "F = 0.18"]),
}  # fmt: skip


@pytest.mark.parametrize("name", OF_TEXT)
def test_errors_point_at_the_place(name):
    old, new, position, words = OF_TEXT[name]
    assert old in TEXT
    text = TEXT.replace(old, new, 1)
    with pytest.raises(InputError) as error:
        sf.System.from_toml(text)
    sentence, excerpt, carets = str(error.value).split("\n")
    for word in words:
        assert word in sentence
    assert excerpt[carets.index("^") :].startswith(position)
    line, column = map(int, re.match(r"line (\d+), column (\d+): ", sentence).groups())
    assert text.splitlines()[line - 1][column - 1 :].startswith(position)
    assert excerpt.startswith(f"{line:>4} | ")


@pytest.mark.parametrize(
    ("arguments", "taken"),
    [
        (("a", "10*a", "a/10", "0.05*a", "2*((a))", "a + b", "W*t + a", "twice", "twice/3"), False),
        (("a*pi/180", "b + a/9/6.3662", "2*a*0.01745 - W*t", "twice*pi/180", "k*a", "b"), True),
        (("1.5*a", "a*pi", "a*pi/2", "a*pi/7"), False),
        (("12*a*pi/180", "a*pi/72", "a*pi/200", "a*pi/180/12"), True),
    ],
)
def test_angles_in_degrees_need_a_factor(arguments, taken):
    given = {"a": {"value": 30, "unit": "deg"}, "b": {"value": 0.3, "unit": "rad"}, "k": 1, "W": 1}
    rest = {"formulas": {"twice": "2*a"}, "forcing": {"period": "2*pi/W"}}
    for argument in arguments:
        why = refusal(sf.System, parameters=given, states={"q": f"cos({argument})"}, **rest)
        assert not why if taken else "cos takes radians, but a is in deg" in why, argument


def test_a_formula_made_in_python_is_shown():
    with pytest.raises(InputError) as error:
        sf.System(states={"q": "1 +\n  sqrt(x)"})
    assert str(error.value) == (
        "states.q, column 8: there is no name 'x'; known are the states q, and pi\n"
        "     |   sqrt(x)\n"
        "              ^"
    )


def test_lines_of_a_formula_are_counted():
    with pytest.raises(InputError, match="line 4, column 4: there is no name 'x'"):
        sf.System.from_toml('[states]\nq = """\nq\n + x\n"""')


def test_periods_that_hold_for_some_values_only():
    tables = {
        "parameters": {"W": 1.0, "n": 3.0},
        "states": {"q": "-q + cos(W*t) + cos(n*W*t)"},
        "forcing": {"period": "2*pi/W"},
    }
    system = sf.System(tables)
    assert system.replace(W=1.3, n=4).n == 4
    with pytest.raises(InputError, match=r"rate of q does not repeat .* at W = 1, n = 3.5"):
        system.replace(n=3.5)
    with pytest.raises(InputError, match="does not repeat"):
        sf.System({**tables, "forcing": {"period": "2*pi"}}).replace(W=1.1)


def test_no_text_too_long_a_text_and_an_empty_table():
    with pytest.raises(InputError, match=r"None is no path of a file; .* such as 'model.toml'"):
        sf.System.from_toml(None)
    with pytest.raises(InputError, match="more than 300000; a system of equations is shorter"):
        sf.System.from_toml("#" * 300_001 + "\n")
    with pytest.raises(InputError, match="states is empty; give at least 1"):
        sf.System(states={})


@pytest.mark.parametrize("text", ["a = " + "[" * 5000, "a=" + "9" * 5000, "a = 99:99\n", "\x00=1"])
def test_what_tomllib_stumbles_over_is_refused(text):
    with pytest.raises(InputError, match=r"not TOML|nested too deeply"):
        sf.System.from_toml(text)
