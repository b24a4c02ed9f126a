"""Every result is saved, read back, exported, pickled and labeled alike; damage is seen."""

import csv
import json
import pickle
from itertools import product

import numpy as np
import pytest
import xarray

from helpers.all_results import MADE
from slipfold import InputError, load
from slipfold.results import result as load_module
from slipfold.results.tables import LabeledTable, read_netcdf


@pytest.fixture(scope="module", params=list(MADE))
def result(request):
    return MADE[request.param]()


@pytest.fixture(scope="module")
def file(result, tmp_path_factory):
    path = tmp_path_factory.mktemp("results") / "x.nc"
    result.save(path)
    return path


def assert_same(one, other):
    """Compare all that two results show of themselves, number for number."""
    xarray.testing.assert_identical(one.to_xarray(), other.to_xarray())
    for name in ("to_json", "summary", "_repr_html_", "__repr__"):
        assert getattr(one, name)() == getattr(other, name)(), name


def test_it_loads_again_number_for_number(result, file):
    copy = load(file)
    assert type(copy) is type(result)
    assert_same(copy, result)
    assert (copy.model, copy.provenance) == (result.model, result.provenance)


def test_xarray_reads_the_file_as_the_same_dataset(result, file):
    with xarray.open_dataset(file, engine="h5netcdf") as dataset:
        xarray.testing.assert_identical(dataset.load(), result.to_xarray())


def test_what_is_no_path_and_no_axes_is_refused(result):
    for attempt, given in product((result.save, result.to_csv, load), (None, "", 3)):
        with pytest.raises(InputError, match="is no path of a file; give one"):
            attempt(given)
    if hasattr(result, "plot"):
        with pytest.raises(InputError, match=r"; (give|those)"):  # or because nothing is drawn
            result.plot(ax=3)


def test_it_is_pickled(result):
    copy = pickle.loads(pickle.dumps(result))
    assert_same(copy, result)
    assert_locked(copy)


def test_all_variables_have_units_and_meanings(result):
    dataset = result.to_xarray()
    for name, variable in dataset.variables.items():
        assert variable.attrs.get("long_name"), name
        assert variable.attrs.get("units"), name
        see, _, where = variable.attrs["units"].partition("see ")
        assert see or where.split(", ")[0] in dataset.variables, name
        assert not np.iscomplexobj(variable.values), name
    assert dataset.attrs["schema"] == result.schema


def test_records_hold_what_json_can(result):
    record = result.to_json()
    assert json.loads(json.dumps(record, allow_nan=False)) == record
    assert (record["schema"], record["model"]) == (result.schema, result.model.name)


def test_spreadsheets_hold_exact_numbers_and_are_tables_of_pandas(result, tmp_path):
    result.to_csv(tmp_path / "x.csv")
    heads, *rows = csv.reader((tmp_path / "x.csv").read_text().splitlines())
    table = result.to_dataframe()
    assert [head.split(" (")[0] for head in heads] == [name.split(" (")[0] for name in table]
    assert len(set(heads)) == len(heads)
    assert len(rows) == len(table)
    for cells, name in zip(zip(*rows, strict=True), table, strict=False):
        column = table[name]
        if column.dtype.kind in "fi":
            read = [float(cell) if cell else np.nan for cell in cells]
            np.testing.assert_array_equal(read, column.to_numpy(), err_msg=name)


def test_arrays_and_mappings_are_locked(result, file):
    assert_locked(result)
    assert_locked(load(file))


def assert_locked(result):
    for value in vars(result).values():
        assert not isinstance(value, dict)
        assert not (isinstance(value, np.ndarray) and value.flags.writeable)


def damaged(table):
    """Yield a table without one of its variables or attributes, or with a spoilt one, at a time."""
    for name in table.variables:
        left = {key: item for key, item in table.variables.items() if key != name}
        yield name, LabeledTable(left, table.attributes)
    for name in table.attributes:
        if name not in ("title", "model", "checked", "seconds"):
            left = {key: item for key, item in table.attributes.items() if key != name}
            yield name, LabeledTable(table.variables, left)
        if name not in ("title", "model"):
            yield name, LabeledTable(table.variables, {**table.attributes, name: "[nothing"})


def test_a_damaged_file_is_refused_or_nothing_is_lost(result, file, monkeypatch):
    refused = 0
    for name, table in damaged(read_netcdf(file)):
        monkeypatch.setattr(load_module, "read_netcdf", lambda path, table=table: table)
        if refusal := refusal_of(result, name):
            refused += 1
            assert refusal.startswith("x.nc"), name
    assert refused >= 3


def refusal_of(result, name):
    """Return why what is read is refused; if it is not, nothing may be missing."""
    try:
        copy = load("x.nc")
    except InputError as error:
        return str(error)
    if name in result.to_xarray().variables:
        assert copy.to_json() == result.to_json(), name
        assert copy.summary() == result.summary(), name
    return ""
