"""Figures of studies."""

import numpy as np
import pytest

import slipfold as sf
from helpers.studies import CHEAP
from slipfold import InputError

SPEEDS = [0.7, 0.5, 0.6]


def study(grid):
    return sf.study({**CHEAP, "cases": {"grid": grid}})


def test_a_line_over_one_parameter():
    found = study({"Vd": SPEEDS})
    ax = found.plot("last_x")
    (line,) = ax.lines
    assert line.get_xdata().tolist() == sorted(SPEEDS)
    assert line.get_ydata().tolist() == found.values["last_x"][[1, 2, 0]].tolist()
    assert ax.get_xlabel() == "$V_d$ (m/s)"
    assert ax.get_ylabel() == "last_x"


def test_a_map_over_two():
    found = study({"Vd": SPEEDS, "mu": [0.3, 0.4]})
    ax = found.plot("last_x")
    (mesh,) = ax.collections
    shown = found.to_xarray().last_x.sortby("Vd").values.T
    np.testing.assert_array_equal(mesh.get_array(), shown)


def test_a_matrix_of_maps_over_four():
    grid = {"Vd": SPEEDS, "mu": [0.3, 0.4], "alpha": ["30deg", "60deg"], "Ns": [1, 1.1, 1.2]}
    found = study(grid)
    panels = found.plot("last_x")
    assert panels.shape == (3, 2)
    assert panels[2, 1].get_title() == "alpha = 60°, Ns = 1.2 N"
    (mesh,) = panels[2, 1].collections
    shown = found.to_xarray().last_x.sortby("Vd").values[:, :, 1, 2].T
    np.testing.assert_array_equal(mesh.get_array(), shown)


def test_what_cannot_be_drawn():
    found = study({name: [1] for name in ("f1", "f2", "kext", "k1", "k2")})
    with pytest.raises(InputError, match="has 5 parameters and a figure shows 4"):
        found.plot()
    with pytest.raises(InputError, match=r"has no quantity 'threshold'; .*it has settled, period"):
        found.plot("threshold")


def test_a_study_without_a_value_is_not_drawn():
    compute = {"what": "threshold", "vary": "Nd", "span": [0, 0.01]}
    found = sf.study({**CHEAP, "compute": compute, "cases": {"grid": {"Vd": SPEEDS}}})
    with pytest.raises(InputError, match="no case has a value of threshold, so there is nothing"):
        found.plot("threshold")
