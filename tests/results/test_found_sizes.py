"""What is loaded computes as what was saved did, in the sizes that were found for its states."""

import numpy as np
import pytest

import slipfold as sf
from slipfold import load

TINY = sf.System(
    name="micrometres",
    parameters={"W": 1.0, "F": 2e-7},
    states={"q": "v", "v": "F*cos(W*t) - 0.2*v - q - 1e12*q^3"},
    forcing={"period": "2*pi/W"},
)
WINDOW = ((0.9, 1.6), (1e-7, 3e-7))


@pytest.fixture(scope="module")
def response():
    return sf.response(TINY, vary="W", span=(0.5, 1.6))


def loaded(result, tmp_path):
    result.save(tmp_path / "saved.nc")
    return load(tmp_path / "saved.nc")


def assert_same_sizes(one, other):
    assert np.array_equal(one.state_scales(), other.state_scales())


def test_a_loaded_response_is_checked_and_followed_as_the_first_one(response, tmp_path):
    again = loaded(response, tmp_path)
    assert response.model.state_scales().max() < 1e-5
    for mine, other in zip(response.special, again.special, strict=True):
        assert_same_sizes(mine.point.model, other.point.model)
        assert other.point.orbit.check().states == mine.point.orbit.check().states
    first, second = (sf.locus(item.special[0], ("W", "F"), WINDOW) for item in (response, again))
    for mine, other in zip(first.loci, second.loci, strict=True):
        assert np.array_equal(mine.values, other.values)
    kept = loaded(first, tmp_path)
    assert_same_sizes(first.loci[0].model, kept.loci[0].model)
    assert_same_sizes(first.loci[0].special[0].model, kept.loci[0].special[0].model)
