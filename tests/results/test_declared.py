"""A result that is declared once is saved, read back, recorded and exported, whatever it holds."""

import csv
from dataclasses import dataclass

import numpy as np
import pytest
import xarray

from slipfold.models import SlidingOscillator
from slipfold.results.column import COMPLEX, TEXT, TRUTH, WHOLE, Column
from slipfold.results.labelled_table import Variable, read_netcdf
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.results.saved_table import open_table
from slipfold.results.sheet import Sheet
from slipfold.results.table import Table, axes_of, names

ORIGIN = Provenance("1", "2", "3", "4", "2026-01-01T00:00:00+00:00", 0.1)


@dataclass(frozen=True)
class Peak:
    """Something with a value of every kind, one missing where it may be."""

    name: str
    count: int | None
    height: float | None
    real: bool
    state: np.ndarray
    mode: np.ndarray
    near: tuple[int, ...]


TABLE = Table(
    ("peak",),
    (
        Column("name", TEXT, "what it is called", label=True, record=True),
        Column("count", WHOLE, "how often it was seen, 0: not counted", optional=True, record=True),
        Column("height", meaning="how high it is", unit="m", optional=True, record=True),
        Column("real", TRUTH, "whether it is one"),
        Column("state", meaning="where it is", dimensions=("state",)),
        Column("mode", COMPLEX, "its mode", "", ("state",), record=True),
        Column("near", WHOLE, "numbers of its neighbours, 0: no more", "", ("neighbour",)),
        Column("twice", get=lambda peak: None if peak.height is None else 2 * peak.height,
               meaning="twice its height", unit="m", derived=True),
    ),
    "peak_",
)  # fmt: skip


@dataclass(frozen=True)
class Peaks(Result):
    """All that a new kind of result says of itself."""

    schema = "slipfold.peaks/1"

    model: SlidingOscillator
    peaks: tuple[Peak, ...]
    provenance: Provenance = ORIGIN

    def summary(self) -> str:
        return f"{len(self.peaks)} peaks"

    def _title(self) -> str:
        return "peaks"

    def _given(self) -> dict:
        return {"wanted": 2}

    def _attributes(self) -> dict:
        return {}

    def _variables(self) -> dict[str, Variable]:
        labels = names("state", self.model.states)
        return labels | TABLE.variables(self.peaks, axes_of(self.model))

    def _record(self) -> dict:
        return {"peaks": [TABLE.record(peak) for peak in self.peaks]}

    def _csv(self) -> str:
        heads = {"name": "name", "height": "height (m)", "mode": "mode", "real": "real"}
        sheet = Sheet(heads, (TABLE,), axes_of(self.model))
        return sheet.text(sheet.rows(TABLE, self.peaks, {}))

    @classmethod
    def _read(cls, saved):
        axes = axes_of(saved.model)
        rows = range(len(saved.columns["peak_name"]))
        return cls(saved.model, tuple(Peak(**TABLE.read(saved, axes, row)) for row in rows))


def peak(name="first", **changes):
    state = np.array([0.1, np.nan, -np.inf, 1e-300])
    given = {"name": name, "count": 3, "height": 1 / 3, "real": True, "state": state}
    mode = np.array([1 + 2j, complex(0.0, np.nan), complex(-np.inf, 0.5), -0.1j])
    return Peak(**(given | {"mode": mode, "near": (4, 2)} | changes))


SECOND = peak("second", count=None, height=None, near=(), real=False)
PEAKS = Peaks(SlidingOscillator(f=12.0), (peak(), SECOND))


def saved(tmp_path, result):
    result.save(tmp_path / "x.nc")
    return read_netcdf(tmp_path / "x.nc")


@pytest.mark.parametrize("result", [PEAKS, Peaks(PEAKS.model, ())], ids=["two", "none"])
def test_it_is_read_back_number_for_number(tmp_path, result):
    copy = Peaks._read(open_table(saved(tmp_path, result)))
    assert len(copy.peaks) == len(result.peaks)
    for one, other in zip(result.peaks, copy.peaks, strict=True):
        for name in ("name", "count", "height", "real", "near"):
            assert getattr(one, name) == getattr(other, name), name
            assert type(getattr(one, name)) is type(getattr(other, name)), name
        np.testing.assert_array_equal(one.state, other.state, strict=True)
        for part in ("real", "imag"):
            np.testing.assert_array_equal(getattr(one.mode, part), getattr(other.mode, part))
    with xarray.open_dataset(tmp_path / "x.nc", engine="h5netcdf") as dataset:
        xarray.testing.assert_identical(dataset.load(), result.to_xarray())


def test_units_meanings_and_what_is_derived(tmp_path):
    data = PEAKS.to_xarray()
    assert data.peak_height.attrs == {"long_name": "how high it is", "units": "m"}
    assert data.peak_mode_imag.attrs["long_name"] == "its mode, imaginary part"
    assert data.peak_near.values.tolist() == [[4, 2], [0, 0]]
    assert data.peak_twice.values[0] == 2 / 3
    assert np.isnan(data.peak_twice.values[1])
    assert "peak_name" in data.coords


def test_records_hold_what_json_can():
    first, second = PEAKS.to_json()["peaks"]
    assert list(first) == ["name", "count", "height", "mode"]
    assert first["mode"] == [[1.0, 2.0], [0.0, None], [None, 0.5], [0.0, -0.1]]
    assert (second["count"], second["height"]) == (None, None)


def test_spreadsheets_have_two_columns_for_complex_numbers(tmp_path):
    PEAKS.to_csv(tmp_path / "x.csv")
    rows = list(csv.DictReader((tmp_path / "x.csv").read_text().splitlines()))
    assert [row["height (m)"] for row in rows] == [repr(1 / 3), ""]
    assert [row["mode x imaginary"] for row in rows] == ["2.0", "2.0"]
    assert [row["real"] for row in rows] == ["1", "0"]


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("peak_state", np.zeros((2, 3)), "shape"),
        ("peak_height", np.zeros((2, 4)), "shape"),
        ("peak_mode_imag", np.zeros((2, 3)), "shape|broadcast"),
    ],
)
def test_columns_of_another_shape_are_refused(tmp_path, name, values, message):
    table = saved(tmp_path, PEAKS)
    changed = {**table.variables, name: Variable(table.variables[name].dimensions, values)}
    with pytest.raises(ValueError, match=message):
        Peaks._read(open_table(type(table)(changed, table.attributes)))
