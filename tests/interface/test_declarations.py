"""A parameter means the same in Python and on the command line, and has the same default."""

import inspect
import re

import pytest
from typer.main import get_command

import slipfold
from slipfold.declarations import declared, resolved
from slipfold.interface.cli.app import COMMANDS, app
from slipfold.studies.works import AttractorsWork, LyapunovWork, SimulationWork

FUNCTIONS = {
    name: getattr(slipfold, command.home.split(":")[1])
    for name, command in COMMANDS.items()
    if command.home.startswith("slipfold.computations.")
}

ARGUMENTS = ("model", "measurement", "point", "vary", "span", "values")
"""Parameters that are arguments of a command, or parts of ``--vary``."""


def options_of(name):
    """Return the options of a command by the flags that they have."""
    program = get_command(app).resolve_command(None, [name])[1]
    return {flag: item for item in program.params for flag in item.opts}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_parameter_of_a_function_is_an_option_of_its_command(name):
    options, command = options_of(name), COMMANDS[name]
    for item in resolved(FUNCTIONS[name]).parameters.values():
        declaration = declared(item.annotation)
        if declaration is None or item.name in ARGUMENTS:
            continue
        flag = (declaration.flags or (f"--{item.name.replace('_', '-')}",))[0]
        assert flag in options, item.name
        default = options[flag].default
        expected = command.defaults.get(item.name, item.default)
        if isinstance(expected, int | float) and default is not None:
            assert float(default) == expected


@pytest.mark.parametrize(
    ("work", "name"),
    [(SimulationWork, "simulate"), (LyapunovWork, "lyapunov"), (AttractorsWork, "attractors")],
)
def test_options_of_a_study_are_those_of_the_function(work, name):
    parameters = resolved(getattr(slipfold, name)).parameters
    for option, field in work.model_fields.items():
        if option not in ("what", "start"):
            assert field.default == parameters[option].default
            (known,) = field.metadata
            assert known.help == declared(parameters[option].annotation).help


def test_a_value_that_is_not_given_is_the_default_of_the_function():
    program = COMMANDS["sweep"].program()
    texts = {
        item.name: None if item.default is inspect.Parameter.empty else item.default
        for item in inspect.signature(program).parameters.values()
    }
    assert (texts["runs"], texts["points"], texts["box"]) == ("both", "200", None)


@pytest.mark.parametrize("name", ["simulate", "basins", "response", "uncertainty"])
def test_the_declaration_is_in_the_docstring(name):
    function = getattr(slipfold, name)
    text = " ".join(inspect.getdoc(function).split())
    for item in resolved(function).parameters.values():
        option = declared(item.annotation)
        if option is not None:
            assert " ".join(option.help.split()) in text


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"settled": "no"}, "settled = 'no' is not True or False; give one of them"),
        ({"setled": True}, "response takes no setled; did you mean settled?"),
        ({"evnets": []}, "response takes no evnets; did you mean events?"),
        ({"events": "x=1"}, "'x=1' is not an event"),
    ],
)
def test_arguments_of_python_are_checked_by_their_declarations(arguments, sentence):
    with pytest.raises(slipfold.InputError, match=re.escape(sentence)):
        slipfold.response(slipfold.SlidingOscillator(), "Nd", (0, 0.1), **arguments)


def test_a_number_given_as_text_is_refused():
    model = slipfold.SlidingOscillator()
    with pytest.raises(slipfold.InputError, match="points = '20' is not a whole number of at l"):
        slipfold.sweep(model, "Nd", (0, 0.1), points="20")
    with pytest.raises(slipfold.InputError, match="tolerance = 0 is not a positive number"):
        slipfold.simulate(model, tolerance=0)


@pytest.mark.parametrize(
    ("name", "arguments", "sentence"),
    [
        ("response", {"start": [0, 0]}, "start = [0, 0] is not by name"),
        ("response", {"on_progress": 3}, "on_progress = 3 is not a function"),
        ("responses", {"over": None}, "over does not give the same parameters"),
        (
            "design",
            {"choose": ["Vd"], "load": 0.02, "above": 0.05},
            "choose = ['Vd'] is not by na",
        ),
        ("design", {"choose": {}, "load": 0.02, "outside": 0.05}, "outside = 0.05 are not two val"),
        (
            "measure",
            {"values": [0.01], "quantities": "max y", "errors": "1mm"},
            "do not fit the quantities",
        ),
        ("study", {"given": 3}, "3 is not a study"),
    ],
)
def test_wrong_shapes_are_refused_in_a_sentence(name, arguments, sentence):
    function = getattr(slipfold, name)
    usual = {"model": slipfold.SlidingOscillator(), "vary": "Nd", "span": (0, 0.1), "point": None}
    needed = {key: usual[key] for key in usual if key in inspect.signature(function).parameters}
    with pytest.raises(slipfold.InputError, match=re.escape(sentence)):
        function(**needed, **arguments)
