"""Files with something wrong in them, and what must come of any: a model or one clear message."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slipfold import InputError


@st.composite
def spoilt_files(draw, texts, pieces):
    """One of the texts with a few pieces replaced, left out or put in."""
    text = draw(st.sampled_from(texts))
    for _ in range(draw(st.integers(1, 4))):
        place = draw(st.integers(0, len(text)))
        length = draw(st.sampled_from([0, 0, 1, 3, 10, 60]))
        text = text[:place] + draw(pieces) + text[place + length :]
    return text


def check_made(make, use):
    """What is made is of use, or there is a message."""
    try:
        found = make()
    except InputError as error:
        found = str(error)
    if isinstance(found, str):
        assert found.strip()
        assert len(found) < 5000
    else:
        use(found)


MANY = 10_000


def fuzzed(strategy, check, few):
    """Return a test of a few examples, and of many in long runs."""

    @pytest.mark.parametrize("examples", [few, pytest.param(MANY, marks=pytest.mark.long)])
    def test(examples):
        settings(max_examples=examples)(given(strategy)(check))()

    return test
