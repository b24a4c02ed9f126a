"""The public names exist, keep the naming rules, and have the defaults that they document."""

import ast
import inspect
import re

import pytest

import slipfold
from helpers.public_api import default, documented, parameters, public_objects


def stated_default(kind: str) -> str | None:
    """Return the default that the type line of a docstring states.

    >>> stated_default("float, default 1e-10")
    '1e-10'
    >>> stated_default("tuple of float, optional (default: (0, 1))")
    '(0, 1)'
    >>> stated_default("int, optional") is None
    True
    """
    match = re.search(r"\bdefaults?\b(?:\s+to|\s+is)?\s*[:=]?\s*(.+)$", kind)
    if match is None:
        return None
    text = match[1].strip()
    if text.count(")") > text.count("("):
        text = text.removesuffix(")")
    return text.strip("`. ")


def holds(text: str, actual: object) -> bool:
    """Tell whether the text, a literal or an expression of public names, gives the default.

    >>> holds("1e-10", 1e-10), holds("3", 4), holds("None", None), holds("some number", 1)
    (True, False, True, False)
    """
    if text in (repr(actual), str(actual)):
        return True
    try:
        stated = ast.literal_eval(text)
    except (SyntaxError, ValueError):
        try:
            stated = eval(text, {"slipfold": slipfold, "sf": slipfold, **vars(slipfold)})
        except (AttributeError, NameError, SyntaxError, TypeError):
            return False
    return bool(stated == actual)


def test_public_names_exist_once():
    names = list(slipfold.__all__)
    assert len(names) == len(set(names))
    assert [name for name in names if not hasattr(slipfold, name)] == []


@pytest.mark.parametrize("name", slipfold.__all__)
def test_stated_defaults_are_the_defaults(name):
    for public in public_objects(name):
        docs = documented(public.value)
        for parameter in parameters(public.value).values():
            text = stated_default(docs[parameter.name].type) if parameter.name in docs else None
            if text is not None:
                actual = default(public.value, parameter)
                assert actual is not inspect.Parameter.empty
                assert holds(text, actual), f"docstring of {public.name}: {text}, code: {actual!r}"


@pytest.mark.parametrize("name", slipfold.__all__)
def test_frequencies_are_in_hertz(name):
    for public in public_objects(name):
        assert not {"omega", "w", "angular_frequency"} & parameters(public.value).keys()
