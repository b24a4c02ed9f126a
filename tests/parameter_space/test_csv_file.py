"""Files of measurements: their content is read back, and mistakes in them are reported."""

import numpy as np
import pytest

import slipfold as sf
from slipfold import InputError, read_measurement
from slipfold.parameter_space.measurement import csv_of

MODEL = sf.SlidingOscillator()


def read(tmp_path, text):
    path = tmp_path / "data.csv"
    path.write_text(text, encoding="utf-8")
    return read_measurement(path, MODEL)


def test_units_become_si_and_what_is_empty_is_missing(tmp_path):
    found = read(
        tmp_path,
        "\ufeff# a test stand\nNd (mN), max N [mN], error of max N [mN], sweep\n"
        "10, 1010, 2, up\n\n20,, 2, down\n",
    )
    assert (found.vary, found.unit) == ("Nd", "N")
    assert np.array_equal(found.values, [0.01, 0.02])
    assert np.array_equal(found.measured, [[1.01], [np.nan]], equal_nan=True)
    assert np.array_equal(found.errors, [[0.002], [0.002]])
    assert found.sweep == ("up", "down")
    assert [(item.measure, item.output) for item in found.quantities] == [("max", "N")]


def test_what_is_written_is_read_back_to_the_last_digit(tmp_path):
    first = read(
        tmp_path,
        "f [Hz],max y,min x,error of max y,sweep\n"
        "12.1,0.1,-0.2,1e-3,\n12.3,0.30000000000000004,,2e-3,up\n",
    )
    first.to_csv(tmp_path / "written.csv")
    remarked = read(tmp_path, csv_of(first, ["a remark"]))
    for again in (remarked, read_measurement(tmp_path / "written.csv", MODEL)):
        for name in ("values", "measured", "errors"):
            assert np.array_equal(getattr(first, name), getattr(again, name), equal_nan=True)
        assert (first.quantities, first.sweep) == (again.quantities, again.sweep)
    with pytest.raises(InputError, match=r"cannot be written \(is a directory\); give another"):
        first.to_csv(tmp_path)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "holds no measurements; give a head"),
        ("f [Hz],max y\n", "holds no measurements"),
        ("f [Hz]\n1\n", "holds no measurements besides f"),
        ("q [Hz],max y\n1,2\n", "sliding has no parameter 'q'"),
        ("f,max y\n1,2\n", "'f' has no unit; write f .Hz., or one of GHz, Hz, MHz, kHz, mHz"),
        ("f [rpm],max y\n1,2\n", "has the unit 'rpm'"),
        ("f [Hz],largest y\n1,2\n", "does not say what is measured"),
        ("f [Hz],max z\n1,2\n", "sliding has no output 'z'"),
        ("f [Hz],max y,max y\n1,2,3\n", "2 columns 'max y'"),
        ("f [Hz],max y,error of min y\n1,2,3\n", "errors of min y but no measurements of it"),
        ("f [Hz],max y\n1,2,3\n", "line 2 of .* has 3 cells under 2 heads"),
        ("f [Hz],max y\n1,zwei\n", "line 2 of .*'zwei' under 'max y' is not a finite number"),
        ("f [Hz],max y\n1,inf\n", "is not a finite number"),
        ("f [Hz],max y\n,2\n", "line 2 of .* has no value of f"),
        ("f [Hz],max y,error of max y\n1,2,0\n", "line 2 of .* error that is not above zero"),
        ("f [Hz],max y,sweep\n1,2,left\n", "'left' is not a direction of a sweep"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(tmp_path, text, words):
    with pytest.raises(sf.InputError, match=words):
        read(tmp_path, text)


def test_a_file_that_is_not_there_or_no_text(tmp_path):
    with pytest.raises(sf.InputError, match="cannot be read: No such file"):
        read_measurement(tmp_path / "none.csv", MODEL)
    (tmp_path / "data.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(sf.InputError, match="it is no text"):
        read_measurement(tmp_path / "data.csv", MODEL)
    (tmp_path / "data.csv").write_text("f [Hz],max y\n1," + 200_000 * "9")
    with pytest.raises(sf.InputError, match="field larger than"):
        read_measurement(tmp_path / "data.csv", MODEL)


@pytest.mark.parametrize(("separator", "point"), [(";", "."), (";", ","), ("\t", ",")])
def test_spreadsheets_of_other_countries_are_read(tmp_path, separator, point):
    rows = [["Nd [N]", "max y [1]"], ["0.01", "0.107"], ["2e-2", "0.153"]]
    text = "\n".join(separator.join(row) for row in rows)
    path = tmp_path / "data.csv"
    path.write_text(text.replace(".", point))
    read = sf.read_measurement(path, sf.SlidingOscillator())
    assert read.values.tolist() == [0.01, 0.02]
    assert read.measured[:, 0].tolist() == [0.107, 0.153]
