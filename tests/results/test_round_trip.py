"""What is saved is what is loaded, number for number; what slipfold did not save is refused."""

import json
import sys
from dataclasses import asdict

import h5py
import pytest
import xarray

from helpers.diagrams import made_diagram, response_branch, special_point
from slipfold import InputError, RationalStribeck, SlidingOscillator, load, simulate


class OtherModel(SlidingOscillator):
    """A model of the user's own."""

    name = "other"


def saved(tmp_path, result):
    path = tmp_path / "result.nc"
    result.save(path)
    return path


def test_what_is_loaded_integrates_nothing_for_summaries_and_files(tmp_path, monkeypatch):
    path = saved(tmp_path, made_diagram())

    def refuse(*given):
        raise AssertionError("a loaded result integrated an orbit")

    for module in ("bifurcations.branches.solution_curve", "orbits.periodic_orbit"):
        monkeypatch.setattr(sys.modules[f"slipfold.{module}"], "find_extrema", refuse)
    copy = load(path)
    copy.summary()
    copy.save(path)
    copy.to_csv(tmp_path / "x.csv")


def test_a_model_of_ones_own_is_given_to_load(tmp_path):
    model = OtherModel(f=12.5, friction=RationalStribeck(mu_s=0.4, d=2.0))
    path = saved(tmp_path, made_diagram(model=model, branches=()))
    copy = load(path, kind=OtherModel).model
    assert (copy, type(copy), copy.friction) == (model, OtherModel, model.friction)
    with pytest.raises(InputError, match="kind = 'other' is not the class of a model"):
        load(path, kind="other")
    with pytest.raises(InputError, match=r"its model 'other' is not a built-in one.*kind=TheClass"):
        load(path)


def test_a_file_from_before_an_optional_column(tmp_path):
    branch = response_branch(special=(special_point(images=2, rare=1),))
    path = saved(tmp_path, made_diagram(branches=(branch,)))
    with h5py.File(path, "r+") as file:
        del file["special_rare"]  # it came later than special_images
    (point,) = load(path).branches[0].special
    assert (point.images, point.rare) == (2, 0)


# -- files that are no results ---------------------------------------------------------------


def test_missing_file(tmp_path):
    with pytest.raises(InputError, match=r"none\.nc cannot be read \(no such file"):
        load(tmp_path / "none.nc")


def test_folder(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        load(tmp_path)


@pytest.mark.parametrize("content", [b"", b"Nd,x\n1,2\n", b"\x89HDF\r\n\x1a\n" + bytes(100)])
def test_file_of_another_kind(tmp_path, content):
    path = tmp_path / "foreign.nc"
    path.write_bytes(content)
    with pytest.raises(InputError, match="not a netCDF-4 file, or is damaged"):
        load(path)


def test_netcdf_of_another_program(tmp_path):
    path = tmp_path / "foreign.nc"
    xarray.Dataset({"x": ("time", [1.0, 2.0])}).to_netcdf(path, engine="h5netcdf")
    with pytest.raises(InputError, match=r"foreign\.nc is not a result of slipfold"):
        load(path)


def test_truncated_file(tmp_path):
    path = saved(tmp_path, made_diagram())
    content = path.read_bytes()
    for part in (0.01, 0.3, 0.6, 0.9):
        path.write_bytes(content[: int(len(content) * part)])
        with pytest.raises(InputError, match="damaged"):
            load(path)


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("schema", lambda text: "slipfold.response/2", r"slipfold\.response/2.*upgrade"),
        ("input", lambda text: text.replace('"mu": 0.5', '"mu": -1'), "mu must be >= 0"),
        ("input", lambda text: "", r"result\.nc is damaged.*compute it again"),
        ("input", lambda text: "{}", r"result\.nc is damaged.*compute it again"),
        ("input", lambda text: "[]", r"result\.nc is damaged.*compute it again"),
        ("input", lambda text: '{"model": "sliding"}', r"result\.nc is damaged.*compute it again"),
        ("input", lambda text: "no JSON", r"result\.nc is damaged.*compute it again"),
    ],
)
def test_a_file_with_a_changed_attribute(tmp_path, name, change, message):
    path = saved(tmp_path, made_diagram())
    with h5py.File(path, "r+") as file:
        file.attrs[name] = change(file.attrs[name])
    with pytest.raises(InputError, match=message):
        load(path)


def test_a_value_of_another_type_is_named(tmp_path):
    path = saved(tmp_path, simulate(SlidingOscillator(), 40))
    copy = load(path)
    with h5py.File(path, "r+") as file:
        text = file.attrs["settlement"]
        assert json.dumps(asdict(copy.settlement)) == text
        file.attrs["settlement"] = text.replace('"settled": false', '"settled": "no"')
    with pytest.raises(InputError, match="'no' is not of type bool"):
        load(path)
