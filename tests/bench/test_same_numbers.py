"""A moved special point is a difference between two trees, a longer curve is not."""

import importlib
from pathlib import Path

import pytest
import xarray as xr

BENCH = Path(__file__).parents[2] / "bench"


@pytest.fixture
def script(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCH))
    return importlib.import_module("same_numbers")


def saved(path, value=0.0436, points=(0.0, 0.1), coefficient=2.0):
    xr.Dataset(
        {
            "special_value": ("special", [value]),
            "special_uncertainty": ("special", [1e-14]),
            "special_coefficient": ("special", [coefficient]),
            "parameter": ("point", list(points)),
        },
        attrs={"vary": "Nd", "seconds": value},
    ).to_netcdf(path)
    return path


@pytest.mark.parametrize(
    ("change", "serious", "steps"),
    [
        ({"value": 0.0436 * (1 + 1e-15)}, 0, 0),
        ({"value": 0.0436 * (1 + 1e-10)}, 1, 0),
        ({"coefficient": 2.0000001}, 1, 0),
        ({"points": (0.0, 0.05, 0.1)}, 0, 1),
    ],
)
def test_what_differs_is_serious_or_due_to_steps(script, tmp_path, change, serious, steps):
    before, after = saved(tmp_path / "before.nc"), saved(tmp_path / "after.nc", **change)
    result = script.compare_files(before, after)
    assert (len(result.serious), len(result.steps)) == (serious, steps)
