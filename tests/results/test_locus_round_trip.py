"""Saved loci and regions are read back number for number; damaged files are refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from helpers.diagrams import STATES
from helpers.locus_diagrams import (
    MODEL,
    assert_same,
    doubling_locus,
    fold_locus,
    locus_point,
    made_locus_diagram,
    region_map,
)
from slipfold.errors import InputError
from slipfold.loci.locus import LocusEnd
from slipfold.loci.region_map import Region, RegionCheck, RegionMotion
from slipfold.models import SlidingOscillator
from slipfold.models.friction import RationalStribeck
from slipfold.results.locus_diagram import LocusDiagram
from slipfold.results.records import open_table
from slipfold.results.result import load
from slipfold.results.tables import Variable


class OtherModel(SlidingOscillator):
    """A model of the user's own."""

    name = "other"


NO_REGIONS = region_map(regions=(), labels=np.zeros((3, 2), np.int64))
NOTHING_STABLE = region_map(
    regions=(Region(1, (), 1.0, (12.0, 0.5)),), labels=np.ones((3, 2), np.int64)
)


def saved(tmp_path, diagram):
    path = tmp_path / "result.nc"
    diagram.save(path)
    return path


@pytest.mark.parametrize(
    "changes",
    [
        pytest.param({"loci": ()}, id="no loci"),
        pytest.param({"loci": (), "regions": None}, id="nothing"),
        pytest.param({"loci": (doubling_locus(special=()),)}, id="no special points"),
        pytest.param({"loci": (fold_locus(),)}, id="first locus missing"),
        pytest.param({"regions": None}, id="no regions asked for"),
        pytest.param({"regions": NO_REGIONS}, id="no regions found"),
        pytest.param({"regions": NOTHING_STABLE}, id="nothing stable"),
        pytest.param({"interrupted": True}, id="interrupted"),
        pytest.param(
            {"loci": (doubling_locus(stopped=LocusEnd("failed", "", (np.nan, np.inf))),)}, id="nan"
        ),
    ],
)
def test_diagrams_that_lack_something(tmp_path, changes):
    diagram = made_locus_diagram(**changes)
    assert_same(diagram, load(saved(tmp_path, diagram)))


anything = st.floats(allow_nan=True, allow_infinity=True)
exponents = st.none() | st.floats(allow_nan=False)
words = st.text(st.characters(blacklist_categories=["Cs"], blacklist_characters="\0"), max_size=30)
inside = st.tuples(st.floats(11, 14), st.floats(0, 0.99))


def numbers(draw, *shape, kind=anything):
    return draw(arrays(float, shape, elements=kind))


def complexes(draw, *shape):
    values = np.empty(shape, complex)
    values.real, values.imag = numbers(draw, *shape), numbers(draw, *shape)
    return values


@st.composite
def points(draw):
    return locus_point(
        draw(st.sampled_from(["GPD", "CH", "MIN", "R1"])),
        name=draw(words),
        values=draw(inside),
        uncertainty=draw(st.tuples(anything, anything)),
        nodes=STATES[: draw(st.integers(1, 3))] * draw(st.floats(0, 1)),
        multipliers=complexes(draw, 4),
        residual=draw(anything),
        arclength=draw(anything),
        coefficients=draw(st.dictionaries(words, anything, max_size=3)),
        leads_to=tuple(draw(st.lists(st.integers(1, 99), max_size=3))),
    )


@st.composite
def loci(draw):
    count, segments = draw(st.integers(1, 4)), draw(st.integers(1, 3))
    period = draw(st.integers(1, 8))
    return doubling_locus(
        type=draw(st.sampled_from(["LP", "PD", "NS"])),
        period=period,
        parent=draw(st.none() | st.integers(1, 9)),
        model=MODEL.replace(**dict(zip(("f", "Nd"), draw(inside), strict=True))),
        values=numbers(draw, count, 2),
        nodes=numbers(draw, count, segments, 4),
        multipliers=complexes(draw, count, 4),
        coefficient=numbers(draw, count),
        residual=numbers(draw, count),
        arclength=numbers(draw, count),
        special=tuple(
            type(item)(**{**vars_of(item), "period": period})
            for item in draw(st.lists(points(), max_size=2))
        ),
        begun=LocusEnd(draw(words), draw(words), draw(st.tuples(anything, anything))),
    )


def vars_of(item):
    return {name: getattr(item, name) for name in type(item).__dataclass_fields__}


@st.composite
def regions(draw):
    items = []
    for number in range(1, draw(st.integers(1, 3)) + 1):
        checks = [
            RegionCheck(
                draw(st.tuples(anything, anything)),
                draw(words),
                draw(st.integers(0, 9)),
                draw(st.booleans()),
                draw(words),
            )
            for _ in range(draw(st.integers(0, 2)))
        ]
        motions = [
            RegionMotion(draw(st.tuples(anything, anything)), draw(words), 4, draw(exponents))
            for _ in range(draw(st.integers(0, 2)))
        ]
        stable = tuple(sorted(draw(st.sets(st.integers(1, 4)))))
        place = draw(st.tuples(anything, anything))
        share, agree = draw(anything), draw(st.booleans())
        items.append(Region(number, stable, share, place, agree, tuple(checks), tuple(motions)))
    rows, columns = draw(st.integers(1, 3)), draw(st.integers(1, 3))
    labels = draw(arrays(np.int64, (rows, columns), elements=st.integers(0, len(items))))
    first, second = numbers(draw, columns), numbers(draw, rows)
    return region_map(first=first, second=second, labels=labels, regions=tuple(items))


@given(loci(), st.none() | regions(), st.booleans())
@settings(max_examples=12)
def test_any_numbers_survive(tmp_path_factory, one, map_, interrupted):
    diagram = made_locus_diagram(loci=(one, fold_locus()), regions=map_, interrupted=interrupted)
    path = tmp_path_factory.mktemp("any") / "x.nc"
    diagram.save(path)
    assert_same(diagram, load(path))


def test_dataset_is_labelled():
    dataset = made_locus_diagram().to_xarray()
    on_fold = dataset.isel(point=dataset.locus_of_point == 2)
    assert on_fold["value"].sel(parameter="Nd").values.tolist() == [0.042, 0.15]
    assert dataset.parameter_units.sel(parameter="f") == "Hz"
    assert "amplitude" in dataset["value"].attrs["long_name"]
    assert int(dataset.region_of_cell.sel(first=12.9, second=0.09, method="nearest")) == 2
    assert dataset["first"].attrs["units"] == "Hz"
    assert dataset.criticality.values.tolist()[:4] == ["subcritical", "", "supercritical", ""]
    assert dataset.attrs["schema"] == "slipfold.locus/1"
    assert all("long_name" in variable.attrs for variable in dataset.variables.values())
    assert not any(np.iscomplexobj(variable.values) for variable in dataset.variables.values())


def test_a_model_of_ones_own_is_given_to_load(tmp_path):
    model = OtherModel(f=12.5)
    path = saved(tmp_path, made_locus_diagram(model=model, loci=()))
    assert load(path, kind=OtherModel).model == model
    with pytest.raises(InputError, match=r"its model 'other' is not a built-in one.*kind=TheClass"):
        load(path)
    with pytest.raises(InputError, match="kind = 'other' is not the class of a model"):
        load(path, kind="other")


def test_a_model_of_ones_own_keeps_its_friction_law(tmp_path):
    model = OtherModel(f=12.5, friction=RationalStribeck(mu_s=0.4, d=2.0))
    path = saved(tmp_path, made_locus_diagram(model=model, loci=()))
    copy = load(path, kind=OtherModel).model
    assert (copy, type(copy), copy.friction) == (model, OtherModel, model.friction)
    with pytest.raises(InputError, match="its model 'other' is not a built-in one"):
        load(path)


def test_loaded_arrays_are_locked(tmp_path):
    copy = load(saved(tmp_path, made_locus_diagram()))
    for values in (copy.loci[0].values, copy.loci[0].special[0].nodes, copy.regions.labels):
        assert not values.flags.writeable


# -- damaged files -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("value", np.zeros((2, 2))),
        ("special_value", np.zeros((3, 3))),
        ("region_of_cell", np.zeros((2, 2), int)),
        ("region_of_cell", np.full((3, 2), 4)),
        ("check_note", np.array(["one"])),
    ],
)
def test_column_that_does_not_fit(name, values):
    table = made_locus_diagram()._table()
    variables = dict(table.variables)
    variables[name] = Variable(variables[name].dimensions, values)
    with pytest.raises(ValueError, match=r"rows|shape|unpack|names a region"):
        LocusDiagram._read(open_table(type(table)(variables, table.attributes)))
