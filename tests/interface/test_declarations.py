"""A parameter means the same in Python and on the command line, and has the same default."""

import inspect

import pytest

import slipfold
from slipfold.cli.app import COMMANDS
from slipfold.options import Option, declared

EMPTY = inspect.Parameter.empty

OTHERWISE = {
    ("locus", "regions"),  # those of a saved response have none
    ("measure", "error"),
    ("sweep", "runs"),  # one word for both
    ("measure", "seed"),  # another noise than that of a first try in Python
}
"""Defaults that differ on purpose."""


def commands():
    """Yield the commands of which the package has a function of the same name."""
    for command in COMMANDS:
        name = {"plan": "plan_measurement"}.get(command.__name__, command.__name__)
        if inspect.isfunction(getattr(slipfold, name, None)):
            yield pytest.param(command.__wrapped__, getattr(slipfold, name), id=command.__name__)


@pytest.mark.parametrize(("command", "function"), [*commands()])
def test_shared_parameters_have_one_declaration_and_one_default(command, function):
    known = inspect.signature(function).parameters
    shared = [item for item in inspect.signature(command).parameters.values() if item.name in known]
    for item in shared:
        own = declared(item.annotation, command.__globals__)
        if not isinstance(own, Option) or own.kind == "spans":
            continue
        if (command.__name__, item.name) in OTHERWISE:
            continue
        there = known[item.name]
        assert own is declared(there.annotation, function.__globals__), item.name
        assert item.default == there.default or EMPTY in (item.default, there.default), item.name


@pytest.mark.parametrize("name", ["simulate", "basins", "response", "uncertainty"])
def test_the_declaration_is_in_the_docstring(name):
    function = getattr(slipfold, name)
    text = " ".join(inspect.getdoc(function).split())
    for item in inspect.signature(function).parameters.values():
        option = declared(item.annotation, function.__globals__)
        if option is not None:
            assert " ".join(option.help.split()) in text
