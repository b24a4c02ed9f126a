"""Systems of equations are models like any other, and say what is wrong with their text."""

import copy
import inspect
import pickle
import re
import tomllib

import heyoka as hy
import numpy as np
import pytest

import slipfold as sf
import slipfold.branches.event
from helpers.textbook_models import Duffing
from slipfold.errors import InputError
from slipfold.flow import flow_of
from slipfold.models.definitions.names import _TAKEN
from slipfold.models.definitions.reader import MEASURES
from slipfold.models.evaluation import evaluation_of
from slipfold.models.formulas.tree import format_tree

TEXT = """\
name = "Duffing"
title = "a cubic spring"
[parameters]
W = { value = 0.9, unit = "rad/s", above = 0, doc = "forcing frequency" }
F = 0.18
g = { value = 0.1, max = 10 }
[formulas]
cubic = "g*q^3"
force = "F*cos(W*t)"
stiff = "1 + 0*g"
[states]                      # name = its rate
q = { rate = "v", doc = "displacement", start = 0.5 }
v = "force - 0.05*v - stiff*q - cubic"
[forcing]
period = "2*pi/W"
quiet = "F"
[outputs]
energy = "v^2/2 + q^2/2 + g/4*q^4"
force = { formula = "force", unit = "N", doc = "force", label = "$F$" }
[limits]
"too far" = { output = "energy", bound = -1.0, reason = "energy fell to {value:.3g}" }
[events]
large = { output = "q", value = 2, measure = "max", stop = true }
"""


@pytest.fixture(scope="module")
def model():
    return sf.System.from_toml(TEXT)


# -- a model like any other --------------------------------------------------------------------


def test_it_is_what_the_text_says(model):
    assert (model.name, model.title, model.quiet) == ("Duffing", "a cubic spring", "F")
    assert [state.name for state in model.states] == ["q", "v"]
    assert model.parameter("W").bounds == "> 0 rad/s"
    assert model.parameter("g").bounds == "<= 10"
    assert [item.name for item in model.outputs()] == ["energy", "force"]
    assert (model.outputs()[1].unit, model.outputs()[1].label) == ("N", "$F$")
    assert model.limits == (sf.Limit("too far", "energy", -1.0, "energy fell to {value:.3g}"),)
    assert model.start.tolist() == [0.5, 0.0]
    assert model.forced
    (event,) = model.events
    assert (event.name, event.output, event.value, event.measure, event.stop) == (
        "large", "q", 2.0, "max", True,
    )  # fmt: skip


def test_rates_jacobian_and_period_are_those_written_by_hand(model):
    mine, other = model.replace(W=1.3, F=0.4, g=0.2), Duffing(w=1.3, a=0.4, g=0.2)
    state = np.array([0.7, -0.4])
    for phase in (0.0, 0.3, 2.8):
        for name in ("rates", "jacobian"):
            found, expected = (
                getattr(evaluation_of(item), name)(item, state, phase) for item in (mine, other)
            )
            assert found == pytest.approx(expected, abs=1e-14)
    assert evaluation_of(mine).period(mine) == pytest.approx(2 * np.pi / 1.3, rel=1e-15)
    time = 1.7
    assert mine.evaluate("force", state, time) == pytest.approx(0.4 * np.cos(1.3 * time))
    assert mine.evaluate("energy", state) == pytest.approx(0.08 + 0.245 + 0.05 * 0.7**4)


def test_copies_pickles_and_replacements(model):
    for other in (pickle.loads(pickle.dumps(model)), copy.deepcopy(model), model.replace()):
        assert other == model
        assert hash(other) == hash(model)
    changed = model.replace(W="1.2 rad/s")
    assert changed != model
    assert changed.W == 1.2
    assert changed.replace(W=0.9) == model
    assert repr(changed) == "System('Duffing', W=1.2)"
    with pytest.raises(AttributeError, match=r"model.replace\(W=...\)"):
        model.W = 1.0


def test_one_compiled_flow_serves_all_parameters(model):
    again = sf.System(tomllib.loads(TEXT))
    assert again == model
    assert flow_of(model.replace(W=1.1)) is flow_of(again)


def test_equal_definitions_are_equal_however_they_are_written(model):
    assert sf.System.from_toml(model.to_toml()) == model
    assert sf.System(model.to_toml()).to_toml() == model.to_toml()
    assert sf.System(**tomllib.loads(TEXT)) == model
    other = TEXT.replace("# name = its rate", "").replace("F = 0.18", "F = {value = 18e-2}")
    assert sf.System.from_toml(other) == model
    assert sf.System.from_toml(TEXT.replace("0.05", "0.06")) != model


def test_values_may_be_given_at_once(model):
    assert sf.System(TEXT, W=1.2, F="0.3") == model.replace(W=1.2, F=0.3)
    with pytest.raises(InputError, match=r"no parameter 'w'; did you mean W\?"):
        sf.System(TEXT, w=1.2)
    with pytest.raises(InputError, match="both a definition and states are given"):
        sf.System(TEXT, states={"q": "1"})
    with pytest.raises(InputError, match="the definition is a int"):
        sf.System(3)


def test_a_file_names_itself(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('[states]\r\nq = "-q"\r\n')
    assert sf.System.from_toml(path).name == "mine"
    assert sf.System.from_toml(str(path)).name == "mine"
    path.write_text('[states]\r\nq = "-q +"\r\n')
    with pytest.raises(InputError, match=r"mine.toml, line 2, column 10: the formula ends"):
        sf.System.from_toml(path)
    with pytest.raises(InputError, match=r"no.toml cannot be read \(no such file"):
        sf.System.from_toml("no.toml")
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="cannot be read"):
        sf.System.from_toml(path)


def test_coefficients_are_the_largest_parts_without_states(model):
    equations = model._built.equations
    terms = {key: format_tree(tree) for key, tree in equations.terms.items()}
    assert terms == {"k1": "stiff", "k2": "g", "k3": "W*(2*pi/W)", "k4": "F", "k5": "g/4"}
    assert format_tree(equations.named["force"]) == "@k4*cos(@k3*@phase)"
    system = sf.System(
        parameters={"m": 2.0, "k": 3.0, "c": 0.1},
        states={"x": "v", "v": "-(2*c*v/m + k*x/m) + (k/m + 1)*2*x^2*3*(2*x*m)^2 + sqrt(k/m)*1"},
    )
    terms = {key: format_tree(tree) for key, tree in system._built.equations.terms.items()}
    assert sorted(terms.values()) == [
        "(k/m + 1)*2*3*(2*m)^2",
        "2*c/m",
        "k/m",
        "sqrt(k/m)*1",
    ]
    p = {name: hy.expression(name) for name in system.values}
    assert all(isinstance(value, hy.expression) for value in system.coefficients(p).values())
    assert system.coefficients(system.values)["k2"] == 1.5


def test_orbits_of_several_periods_keep_the_time_running():
    # Subharmonic of order 1/2 of a linear oscillator: q = cos(W t/2) exactly.
    system = sf.System(
        parameters={"W": 2.0},
        states={"q": "v", "v": "-q + 0.1*(cos(W*t) - (2*q^2 - 1))"},
        forcing={"period": "2*pi/W"},
    )
    orbit = sf.periodic_orbit(system, period=2, state=[1.0, 0.0])
    assert orbit.state == pytest.approx([1.0, 0.0], abs=1e-9)
    _, values = orbit.output("q", 64)
    assert values == pytest.approx(np.cos(2 * np.pi * np.arange(64) / 64), abs=1e-9)


def test_an_autonomous_system_is_simulated_in_seconds():
    decay = sf.System(parameters={"k": 0.5}, states={"q": "-k*q", "s": "1"})
    assert not decay.forced
    motion = sf.simulate(decay, 4, {"q": 1.0})
    assert motion.strobe[:, 0] == pytest.approx(np.exp(-0.5 * np.arange(5)), abs=1e-13)
    assert motion.strobe[:, 1] == pytest.approx(np.arange(5))
    assert decay.duration == 1
    longer = sf.simulate(decay, 4, {"q": 1.0}, duration=2.5)
    assert longer.strobe[:, 0] == pytest.approx(np.exp(-1.25 * np.arange(5)), abs=1e-13)
    assert "duration" not in decay.to_toml()
    assert pickle.loads(pickle.dumps(decay.replace(duration=3))).duration == 3


def test_a_limit_ends_a_motion():
    falling = sf.System(
        parameters={"g": 9.81},
        states={"h": {"rate": "v", "start": 10}, "v": "-g"},
        limits={"ground": {"output": "h", "bound": 0}},
    )
    motion = sf.simulate(falling, 10, falling.start)
    assert motion.stopped.kind == "ground"
    assert motion.stopped.time == pytest.approx(np.sqrt(20 / 9.81), rel=1e-9)
    assert motion.stopped.reason.startswith("ground: h fell to")


def test_no_parameter_hides_an_attribute_or_argument():
    names = {name for name in dir(sf.System) if not name.startswith("_")}
    for function in (sf.response, sf.simulate, sf.bifurcation_set, sf.System.__init__):
        arguments = inspect.signature(function).parameters.values()
        names |= {item.name for item in arguments if item.kind is not item.VAR_KEYWORD}
    assert names <= _TAKEN


# -- what is wrong with a text -----------------------------------------------------------------

OF_TEXT = {
    "unknown name": ("force - ", "farce - ", "farce - 0.05", ["'farce'", "did you mean force?"]),
    "known names": (
        "- cubic", "- x", 'x"',
        ["known are the states q, v, the parameters W, F, g, the formulas cubic, force, stiff"],
    ),
    "unknown function": ("cos(", "coss(", 'coss(W*t)"', ["no function 'coss'; did you mean cos?"]),
    "corner": ("0.05*v", "abs(v)", "abs(v) - sti", ["abs is not smooth"]),
    "grammar": ("0.05*v", "0.05 v", "v - stiff*q", ["for a product write 0.05*v"]),
    "Euler": ("0.05*v", "e*v", "e*v - stiff*", ["write exp(1) for Euler's number"]),
    "circle of one": ('"g*q^3"', '"cubic*q"', 'cubic = "cub', ["the formula cubic uses itself"]),
    "time in the period": ('"2*pi/W"', '"2*pi/t"', 't"', ["cannot depend on the time t"]),
    "period of a state": ('"2*pi/W"', '"2*pi/v"', 'v"', ["depends on the state v"]),
    "period of a formula": ('"2*pi/W"', '"cubic"', 'cubic"', ["depends on the formula cubic"]),
    "wrong period": (
        '"2*pi/W"', '"pi/W"', '"force - 0.0',
        ["rate of v does not repeat", "pi/W, 3.49"],
    ),
    "no period": ('period = "2*pi/W"', "", "[forcing]", ["[forcing] has no period", "autonomous"]),
    "period no text": ('"2*pi/W"', "[1]", "[1]", ["the period is an array"]),
    "quiet nothing": ('"F"', '"f"', '"f"', ["no parameter 'f'", "did you mean F?"]),
    "state and parameter": (
        "F = 0.18", "q = 0.18", "q = { rate =",
        ["q is a parameter and a state"],
    ),
    "formula and state": ("stiff =", "v =", 'v = "force -', ["v is a formula and a state"]),
    "output and state": ("energy =", "q =", 'q = "v^2/2 +', ["q is a state and an output"]),
    "key given twice": ("F = 0.18", "W = 1", "", ["not TOML", "overwrite"]),
    "no rate": ('{ rate = "v",', "{ ", '{  doc = "di', ["q has no rate; give e.g. rate ="]),
    "rate a list": (
        '{ rate = "v", doc = "displacement", start = 0.5 }', "[1]", "[1]",
        ["q is an array; give its rate as a text"],
    ),
    "rate true": (
        'rate = "v"', "rate = true", "true, doc =",
        ["rate is true or false; give a text"],
    ),
    "scale zero": ("start = 0.5", "scale = 0", "0 }", ["scale 0 of q is not positive"]),
    "start text": ("start = 0.5", 'start = "x"', '"x" }', ["start = 'x' is not a number"]),
    "no value": ("{ value = 0.1,", "{", "{ max = 10 }", ["the parameter g has no value"]),
    "value true": ("F = 0.18", "F = true", "true", ["value is true or false; give a number"]),
    "value infinite": ("F = 0.18", "F = inf", "inf", ["value = inf is not a finite number"]),
    "value of another unit": ("F = 0.18", 'F = "3mm"', '"3mm"', ["has the unit 'mm'"]),
    "value outside": ("max = 10", "max = 0", "{ value = 0.", ["g = 0.1 is outside its bounds"]),
    "bounds exchanged": (
        "max = 10", "max = 0, min = 1", "{ value = 0.",
        ["from 1 to 0; exchange the bounds"],
    ),
    "bound twice": ("above = 0", "above = 0, min = 1", "0, min = 1,", ["both min and above"]),
    "bound text": ("above = 0", 'above = "low"', '"low", doc =', ["above = 'low' is not a number"]),
    "unit number": (
        'unit = "rad/s"', "unit = 3", "3, above = 0",
        ["unit is a number; give a text"],
    ),
    "doc of lines": (
        '"forcing frequency"', "\"a\\nb\"", "\"a\\nb\" }",
        ["doc = ", "more than one line"],
    ),
    "unknown entry": (
        "above = 0", "lower = 0", "lower = 0, d",
        ["no entry 'lower'", "min, max, above"],
    ),
    "unknown table": ("[outputs]", "[output]", "[output]", ["no entry 'output'", "outputs?"]),
    "table a number": ("[formulas]", "[other]", "[other]", ["no entry 'other'"]),
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
    "limit without bound": ("bound = -1.0,", "", '{ output = "', ["'too far' has no bound"]),
    "limit a number": (
        '"too far" = {', '"too far" = 3 #', "3 # output =",
        ["is a number, not a table"],
    ),
    "braces": ("{value:.3g}", "{value.__class__}", '"energy fell', ["only braces in a reason are"]),
    "event of nothing": (
        'output = "q", value', 'output = "z", value', '"z", value =',
        ["no output 'z'"],
    ),
    "event of unknown measure": ('"max"', '"mean"', '"mean", stop', ["measure 'mean' is unknown"]),
    "event without value": ("value = 2,", "", '{ output = "', ["the event 'large' has no value"]),
    "stop a number": ("stop = true", "stop = 1", "1 }", ["stop is a number; give true or"]),
    "no number": ("0.05*v", "v/0", "/0 - stiff*q", ["is not a finite number"]),
    "not TOML": ("F = 0.18", "F = ", "", ["this is not TOML (Invalid value)", "F = 0.18"]),
}  # fmt: skip


@pytest.mark.parametrize("name", OF_TEXT)
def test_errors_point_at_the_place(name):
    old, new, place, words = OF_TEXT[name]
    assert old in TEXT
    text = TEXT.replace(old, new, 1)
    with pytest.raises(InputError) as error:
        sf.System.from_toml(text)
    sentence, excerpt, carets = str(error.value).split("\n")
    for word in words:
        assert word in sentence
    assert excerpt[carets.index("^") :].startswith(place)
    line, column = map(int, re.match(r"line (\d+), column (\d+): ", sentence).groups())
    assert text.splitlines()[line - 1][column - 1 :].startswith(place)
    assert excerpt.startswith(f"{line:>4} | ")


OF_TABLES = {
    "nothing": ({}, "there is no table [states]"),
    "no states": ({"states": {}}, "the table [states] is empty"),
    "states a list": ({"states": [1]}, "states is an array, not a table; write [states]"),
    "states a number": ({"states": 3}, "states is a number, not a table"),
    "parameters a text": (
        {"states": {"q": "1"}, "parameters": "F"}, "parameters is a text, not a table",
    ),
    "forcing a text": ({"states": {"q": "1"}, "forcing": "F"}, "forcing is a text, not a table"),
    "name a number": ({"states": {"q": "1"}, "name": 3}, "name is a number; give a text"),
    "key no text": ({"states": {3: "1"}}, "the key 3 of states is no text"),
    "circle": (
        {"states": {"q": "a"}, "formulas": {"a": "b + 1", "b": "2*c", "c": "a"}},
        "the formulas a -> b -> c -> a use each other in a circle",
    ),
    "formula a number": ({"states": {"q": "1"}, "formulas": {"a": 3}}, "a is a number; give the"),
    "time without forcing": (
        {"states": {"q": "cos(t)"}},
        "t, the time, occurs in a system without forcing; add the table [forcing]",
    ),
    "state called phase": ({"states": {"phase": "1"}}, "a state cannot be called phase"),
    "state like a coefficient": ({"states": {"c_1": "1"}}, "a state cannot be called c_1"),
    "long name": ({"states": {"q" * 61: "1"}}, "cannot be a name in formulas; give at most 60"),
    "negative period": (
        {"states": {"q": "1"}, "forcing": {"period": -1}}, "forcing period -1.0 is -1 s; it must",
    ),
    "infinite period": (
        {"states": {"q": "1"}, "parameters": {"W": 0}, "forcing": {"period": "1/W"}},
        "the forcing period 1/W is nan s at W = 0; it must be positive",
    ),
    "no number at the defaults": (
        {"states": {"q": "sqrt(a)*q"}, "parameters": {"a": -1}},
        "sqrt(a) is not a finite number at a = -1; change the parameters in it",
    ),
    "array in a value": (
        {"states": {"q": "1"}, "parameters": {"a": [1]}}, "value is an array; give a number",
    ),
    "parameter none": (
        {"states": {"q": "1"}, "parameters": {"a": None}}, "value is empty; give a number",
    ),
    "huge number": (
        {"states": {"q": "1"}, "parameters": {"a": 10**400}}, "value = inf is not a finite number",
    ),
    "unrepeated output": (
        {"states": {"q": "1"}, "forcing": {"period": "1"}, "outputs": {"y": "sin(6*t)"}},
        "the output y does not repeat after the forcing period 1, 1 s",
    ),
    "time grows": (
        {"states": {"q": "-q + 1e-3*t"}, "forcing": {"period": "1"}}, "does not repeat",
    ),
    "limit with braces in its name": (
        {"states": {"q": "1"}, "limits": {"{0}": {"output": "q", "bound": 0}}},
        "'{0}' is no name for one of the limits; give a few words",
    ),
    "event of no parameter": (
        {"states": {"q": "1"}, "events": {"a": {"value": 1, "measure": "parameter"}}},
        "there is no parameter 'a'; there are none",
    ),
    "too many": ({"states": {f"q{i}": "1" for i in range(1001)}}, "has 1001 entries, more than"),
}  # fmt: skip


@pytest.mark.parametrize("name", OF_TABLES)
def test_tables_made_in_python_are_refused_as_well(name):
    tables, words = OF_TABLES[name]
    with pytest.raises(InputError) as error:
        sf.System(tables)
    sentence = str(error.value).split("\n")[0]
    assert words in sentence


def test_a_formula_made_in_python_is_shown():
    with pytest.raises(InputError) as error:
        sf.System(states={"q": "1 +\n  sqrt(x)"})
    assert str(error.value) == (
        "states.q, column 8: there is no name 'x'; known are the states q, and pi\n"
        "     |   sqrt(x)\n"
        "              ^"
    )


def test_the_excerpt_of_a_long_line_is_the_part_around_the_place():
    with pytest.raises(InputError) as error:
        sf.System(states={"q": "q + " * 300 + "x" + " + q" * 300})
    _, excerpt, carets = str(error.value).split("\n")
    assert len(excerpt) <= 100
    assert excerpt[carets.index("^")] == "x"


def test_escapes_in_a_formula_move_the_place_to_its_beginning():
    with pytest.raises(InputError, match="line 2, column 5: there is no name 'x'"):
        sf.System.from_toml('[states]\nq = "\\u0071 + x"')


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


def test_events_have_the_measures_of_branches():
    assert MEASURES == slipfold.branches.event.MEASURES


def test_a_byte_order_mark_is_no_trouble(model):
    assert sf.System.from_toml("\ufeff" + TEXT) == model


def test_too_long_a_text():
    with pytest.raises(InputError, match="more than 300000; a system of equations is shorter"):
        sf.System.from_toml("#" * 300_001 + "\n")


@pytest.mark.parametrize("text", ["a = " + "[" * 5000, "a=" + "9" * 5000, "a = 99:99\n", "\x00=1"])
def test_what_tomllib_stumbles_over_is_refused(text):
    with pytest.raises(InputError, match=r"not TOML|nested too deeply"):
        sf.System.from_toml(text)


def test_large_systems_load_in_no_time():
    count = 200
    states = {f"q{i}": f"q{(i + 1) % count} - 2*k*q{i} + F*cos(W*t)" for i in range(count)}
    formulas = {f"f{i}": f"f{i + 1}*f{i + 1}" for i in range(40)} | {"f40": "q0"}
    system = sf.System(
        parameters={"k": 1.0, "F": 1.0, "W": 1.0},
        formulas=formulas,
        states={**states, "q0": "-f0"},
        forcing={"period": "2*pi/W"},
    )
    assert len(system.states) == count
