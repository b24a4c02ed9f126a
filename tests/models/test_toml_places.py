"""Places of keys and values in TOML texts, against the text itself."""

import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipfold.models.definitions.source import find_places

TEXT = '''# a comment with = and "quotes"
name = "Duffing" # here too: [states]
"quoted key" = 'literal'
dotted.key.here = 1.5

[parameters]
W = { value = 0.9, unit = "rad/s", nested = { a = 1, b = [1, 2, { c = 3 }] } }
F=0.18
date = 1979-05-27T07:32:00Z
list = [ "a]", 'b}', # not the end
  3 ]
[ states . inner ]
q = """
many "lines"
"""
v = \'\'\'x = 1\'\'\'
[[array]]
a = 1
[[array]]
a = 2
'''


def entries(table, path=()):
    for key, value in table.items():
        yield (*path, key), value
        if isinstance(value, dict):
            yield from entries(value, (*path, key))


def test_every_entry_is_found():
    places = find_places(TEXT)
    for path, value in entries(tomllib.loads(TEXT)):
        place = places.get(path)
        if place is None:
            assert path in {("dotted",), ("dotted", "key"), ("states",)}
            continue
        assert TEXT[place.key :].lstrip("[ \"'").startswith(
            path[0 if path == ("q",) else -1][:1]
        ) or (path[0] in ("dotted", "states"))
        if isinstance(value, (int, float)):
            assert float(TEXT[place.value :].split()[0].rstrip(",}")) == value
        if isinstance(value, str):
            assert TEXT[place.value] in "\"'"


def test_places_are_exact():
    places = find_places(TEXT)
    place = places[("parameters", "W", "unit")]
    assert TEXT[place.key :].startswith('unit = "rad/s"')
    assert TEXT[place.value :].startswith('"rad/s"')
    assert TEXT[places[("parameters",)].key :].startswith("[parameters]")
    assert TEXT[places[("parameters", "F")].value :].startswith("0.18")
    assert TEXT[places[("parameters", "W", "nested", "b")].value :].startswith("[1, 2")
    assert TEXT[places[("states", "inner", "v")].value :].startswith("'''x = 1'''")
    assert TEXT[places[("dotted", "key", "here")].value :].startswith("1.5")


@given(st.text(alphabet="[]{}=,.\"'\n#a1 \\", max_size=60))
def test_any_text_is_walked_through(text):
    for place in find_places(text).values():
        assert 0 <= place.key <= place.value <= len(text)


@pytest.mark.parametrize("opening", ["[", "{a=", "a={", '"', "'''", "a."])
def test_deep_nesting_is_no_trouble(opening):
    find_places("a = " + opening * 20000)
    find_places(opening * 20000)
