"""Every module and public object is documented, and every parameter of it."""

import importlib
import inspect

import pytest

from helpers.public_api import documented, module_names, parameters, public_objects

PUBLIC = [pytest.param(o.value, id=o.name) for o in public_objects()]


@pytest.mark.parametrize("name", module_names())
def test_module_has_docstring(name):
    assert (importlib.import_module(name).__doc__ or "").strip()


@pytest.mark.parametrize("value", PUBLIC)
def test_object_has_docstring(value):
    doc = inspect.getdoc(value) or ""
    assert doc.strip()
    # The signature that @dataclass writes into a missing docstring says nothing.
    assert not doc.startswith(f"{getattr(value, '__name__', '')}(")


@pytest.mark.parametrize("value", PUBLIC)
def test_every_parameter_is_documented(value):
    assert [name for name in parameters(value) if name not in documented(value)] == []


@pytest.mark.parametrize("value", [p for p in PUBLIC if not inspect.isclass(p.values[0])])
def test_every_documented_parameter_exists(value):
    assert [name for name in documented(value) if name not in parameters(value)] == []
