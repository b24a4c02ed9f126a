"""Every module and public object is documented, and every parameter of it."""

import importlib
import inspect

import pytest

import slipfold
from helpers.public_api import documented, module_names, parameters, public_objects

# A test of every method would be thousands, which take longer to list than to run.
NAMES = pytest.mark.parametrize("name", slipfold.__all__)


def test_modules_have_docstrings():
    docs = {name: importlib.import_module(name).__doc__ or "" for name in module_names()}
    assert [name for name, doc in docs.items() if not doc.strip()] == []


@NAMES
def test_objects_have_docstrings(name):
    docs = [(item, inspect.getdoc(item.value) or "") for item in public_objects(name)]
    assert [item.name for item, doc in docs if not doc.strip()] == []
    # The signature that @dataclass writes into a missing docstring says nothing.
    called = [(item, f"{getattr(item.value, '__name__', '')}(", doc) for item, doc in docs]
    assert [item.name for item, start, doc in called if doc.startswith(start)] == []


@NAMES
def test_every_parameter_is_documented(name):
    for item in public_objects(name):
        known = documented(item.value)
        missing = [each for each in parameters(item.value) if each not in known]
        assert (item.name, missing) == (item.name, [])


@NAMES
def test_every_documented_parameter_exists(name):
    for item in public_objects(name):
        if not inspect.isclass(item.value):
            known = parameters(item.value)
            invented = [each for each in documented(item.value) if each not in known]
            assert (item.name, invented) == (item.name, [])
