"""How sentences begin that summaries show."""

import pytest

from slipfold.models.quantities import Parameter
from slipfold.text import capitalized

NAMED = [Parameter("c", 1.0, "N s/m", "damping"), Parameter("mu", 0.3, "", "friction")]


@pytest.mark.parametrize(("text", "expected"), [
    ("c is at its bound", "c is at its bound"),
    ("mu is at its bound", "mu is at its bound"),
    ("correlated parameters", "Correlated parameters"),
    ("settled on a cycle", "Settled on a cycle"),
    ("", ""),
])  # fmt: skip
def test_the_name_of_a_parameter_is_not_capitalized(text, expected):
    assert capitalized(text, NAMED) == expected
