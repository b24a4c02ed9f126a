"""What is saved is what is loaded, number for number; what slipfold did not save is refused."""

import sys

import h5netcdf
import numpy as np
import pytest
import xarray
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from helpers.diagrams import (
    MODEL,
    STATES,
    assert_same_diagram,
    doubled_branch,
    made_diagram,
    response_branch,
    special_point,
)
from helpers.dry_friction import den_hartog
from slipfold.branches.event import Event
from slipfold.branches.settings import Settings
from slipfold.computations.long_term import simulate
from slipfold.continuation.end import End
from slipfold.continuation.settings import Newton, Steps
from slipfold.errors import InputError
from slipfold.models import SlidingOscillator
from slipfold.orbits.extrema import Extrema
from slipfold.results.result import load

OUTPUTS = ("x", "y", "vx", "vy", *(item.name for item in MODEL.outputs()))


class OtherModel(SlidingOscillator):
    """A model of the user's own."""

    name = "other"


def saved(tmp_path, result):
    path = tmp_path / "result.nc"
    result.save(path)
    return path


@pytest.mark.parametrize(
    "changes",
    [
        pytest.param({"branches": ()}, id="no branches"),
        pytest.param({"branches": (response_branch(special=()),)}, id="no special points"),
        pytest.param({"branches": (doubled_branch(),)}, id="first branch missing"),
        pytest.param({"events": ()}, id="no events"),
        pytest.param(
            {"branches": (response_branch(stopped=End("failed", "", np.nan)),)}, id="no value"
        ),
    ],
)
def test_diagrams_that_lack_something(tmp_path, changes):
    diagram = made_diagram(**changes)
    assert_same_diagram(diagram, load(saved(tmp_path, diagram)))


finite = st.floats(-1e300, 1e300)
anything = st.floats(allow_nan=True, allow_infinity=True)
words = st.text(st.characters(blacklist_categories=["Cs"], blacklist_characters="\0"), max_size=30)


@st.composite
def branches(draw):
    points = draw(st.integers(1, 4))
    segments = draw(st.integers(1, 3))

    def numbers(*shape, kind=anything):
        return draw(arrays(float, shape, elements=kind))

    special = tuple(
        special_point(
            draw(st.sampled_from(["LP", "PD", "NS", "BP", "EVENT"])),
            name=draw(words),
            value=draw(st.floats(0, 0.99)),
            uncertainty=draw(anything),
            nodes=STATES[:2] * draw(st.floats(0, 1)),
            residual=draw(anything),
            criticality=draw(st.sampled_from([None, "supercritical", "subcritical"])),
            coefficient=draw(st.none() | finite),
            leads_to=draw(st.none() | st.integers(1, 99)),
        )
        for _ in range(draw(st.integers(0, 2)))
    )
    multipliers = np.empty((points, 4), complex)
    multipliers.real, multipliers.imag = numbers(points, 4), numbers(points, 4)
    branch = response_branch(
        period=draw(st.integers(1, 8)),
        parent=draw(st.none() | st.integers(1, 9)),
        parameter=numbers(points, kind=st.floats(0, 0.99)),
        nodes=numbers(points, segments, 4),
        multipliers=multipliers,
        residual=numbers(points),
        arclength=numbers(points),
        special=special,
        stopped=End(draw(words), draw(words), draw(anything)),
    )
    vars(branch)["extrema"] = Extrema(OUTPUTS, numbers(points, 16), numbers(points, 16))
    vars(branch)["multiplier_uncertainty"] = numbers(points, 4)
    return branch


@given(branches(), st.floats(0, 0.99), st.integers(1, 16))
@settings(max_examples=15)
def test_any_numbers_and_words(tmp_path_factory, branch, last, largest_period):
    diagram = made_diagram(
        branches=(branch,),
        span=(0.0, last),
        settings=Settings(Newton(1e-9, 5), Steps(turn=0.1 + 0.2), largest_period),
        events=(Event("x", last, "peak_to_peak"),),
    )
    path = tmp_path_factory.mktemp("any") / "result.nc"
    diagram.save(path)
    assert_same_diagram(diagram, load(path))


def test_what_is_loaded_integrates_nothing_for_summaries_and_files(tmp_path, monkeypatch):
    path = saved(tmp_path, made_diagram())

    def refuse(*given):
        raise AssertionError("a loaded result integrated an orbit")

    for module in ("slipfold.branches.branch", "slipfold.orbits.periodic_orbit"):
        monkeypatch.setattr(sys.modules[module], "find_extrema", refuse)
    copy = load(path)
    copy.summary()
    copy.save(path)
    copy.to_csv(tmp_path / "x.csv")


def test_dataset_is_labelled():
    dataset = made_diagram().to_xarray()
    on_second = dataset.isel(point=dataset.branch_of_point == 2)
    assert on_second.parameter.values.tolist() == [0.05, 0.1]
    assert on_second.parameter.attrs["units"] == "N"
    assert "amplitude" in on_second.parameter.attrs["long_name"]
    assert on_second.maximum.sel(output="x").shape == (2,)
    assert dataset.output_units.sel(output="Vrel") == "m/s"
    assert dataset.attrs["schema"] == "slipfold.response/1"
    assert all("long_name" in variable.attrs for variable in dataset.variables.values())
    assert not any(np.iscomplexobj(variable.values) for variable in dataset.variables.values())


def test_a_model_of_ones_own_is_given_to_load(tmp_path):
    diagram = made_diagram(model=OtherModel(f=12.5), branches=())
    path = saved(tmp_path, diagram)
    assert load(path, kind=OtherModel).model == OtherModel(f=12.5)
    with pytest.raises(InputError, match=r"its model 'other' is not a built-in one.*kind=TheClass"):
        load(path)


def test_a_motion_that_sticks(tmp_path):
    motion = simulate(den_hartog(0.6, 0.5, 0.8), 20)
    assert motion.regime == "stick-slip"
    copy = load(saved(tmp_path, motion))
    assert copy.sticking.contacts == ("contact",)
    assert copy.sticking.intervals == motion.sticking.intervals
    assert copy.sticking.modes.tolist() == motion.sticking.modes.tolist()
    assert copy.at(1.0).tolist() == motion.at(1.0).tolist()
    assert copy.to_json() == motion.to_json()
    assert copy.summary() == motion.summary()
    (line,) = [line for line in motion.summary().splitlines() if "contacts stick" in line]
    assert line.endswith("(forcing periods from its start)")
    first = motion.last_round.sticking[0]
    assert f"contact from {first.begin:.6g} to {first.end:.6g}" in line
    assert line in copy._repr_html_()
    copy.to_csv(tmp_path / "motion.csv")
    rows = (tmp_path / "motion.csv").read_text().splitlines()
    assert rows[0] == "time (s),x (m),vx (m/s),contact"
    words = {0: "stick", 1: "slip", -1: "slip backwards"}
    assert [row.split(",")[-1] for row in rows[1:]] == [
        words[mode] for mode in motion.sticking.modes[:, 0].tolist()
    ]


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


def test_file_of_a_later_version(tmp_path):
    path = saved(tmp_path, made_diagram())
    with h5netcdf.File(path, "r+") as file:
        file.attrs["schema"] = "slipfold.response/2"
    with pytest.raises(InputError, match=r"slipfold\.response/2.*upgrade"):
        load(path)


def test_truncated_file(tmp_path):
    path = saved(tmp_path, made_diagram())
    content = path.read_bytes()
    for part in (0.01, 0.3, 0.6, 0.9):
        path.write_bytes(content[: int(len(content) * part)])
        with pytest.raises(InputError, match="damaged"):
            load(path)


@pytest.mark.parametrize("text", ["", "{}", "[]", '{"model": "sliding"}', "no JSON"])
def test_damaged_input(tmp_path, text):
    path = saved(tmp_path, made_diagram())
    with h5netcdf.File(path, "r+") as file:
        file.attrs["input"] = text
    with pytest.raises(InputError, match=r"result\.nc is damaged.*compute it anew"):
        load(path)


def test_a_damaged_file_that_names_an_impossible_value(tmp_path):
    path = saved(tmp_path, made_diagram())
    with h5netcdf.File(path, "r+") as file:
        file.attrs["input"] = file.attrs["input"].replace('"mu": 0.5', '"mu": -1')
    with pytest.raises(InputError, match="mu must be >= 0"):
        load(path)
