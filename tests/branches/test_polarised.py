"""Bilinear forms are made from squares, of vectors of any length."""

import numpy as np
import pytest

from slipfold.normal_forms.maps import polarised


def squares(directions):
    return directions**2


def test_a_form_of_complex_vectors_comes_from_squares_of_real_ones():
    u, v = np.array([1 + 2j, 3.0]), np.array([2.0, 1e-8 - 1j])
    assert polarised(squares, [(u, v)])[0] == pytest.approx(u * v, rel=1e-12)


def test_a_vector_whose_squares_underflow_has_no_part():
    u, v = np.array([1.0 + 0j, 0.0]), np.array([1e-200 + 0j, 0.0])
    assert not polarised(squares, [(u, v)])[0].any()
