"""The base class of all results: printing, saving, exporting, loading."""

from __future__ import annotations

import json
from abc import ABC
from collections.abc import Mapping, Sequence
from dataclasses import fields
from functools import cache
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Self, cast

from slipfold.drawing import Drawn
from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.models.quantities import Output, Parameter, State
from slipfold.read_only import ReadOnly
from slipfold.results.checks.checked import Checked
from slipfold.results.fields import ResultPart, bound, names, parts_of
from slipfold.results.records import (
    Provenance,
    SavedTable,
    decoded,
    encoded,
    finite,
    open_table,
    scales_record,
    structure_record,
    types_of,
)
from slipfold.results.tables import Frame, LabeledTable, Variable, frame_of, read_netcdf
from slipfold.text import OneLine, PrintedTable, html_list
from slipfold.writing import NETCDF, check_writable, write_file

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]
    import xarray

    from slipfold.orbits.periodic_orbit import PeriodicOrbit

USUAL = {
    "model": "The model with its parameter values.",
    "vary": "Name of the parameter.",
    "span": "First and last value requested.",
    "settings": "Options of continuation.",
    "box": "Corners ``low`` and ``high`` of the box of starts, each of shape (n_states,).",
    "seed": "Seed of the starts or samples.",
    "requested": "Periods that were requested; None if none were.",
    "ends": "How many trajectories ended early, by the limit of the model that they met.",
    "transient": "Forcing periods left out at each value.",
    "interrupted": "Whether the computation was interrupted, so that some of it is missing.",
    "provenance": "Versions and time.",
    "checked": "What was computed again by other means; None if nothing was.",
}
"""Docstrings of fields that many results have."""

COMMON = ("model", "provenance", "checked")
"""Fields that all results write alike."""

STANDARD = frozenset(
    f"{name}{end}"
    for name in ("state", "output", "multiplier", "parameter", "by_parameter")
    for end in ("", "_units", "_long_name")
)
"""Names of dimensions that results share, and of their labels."""


class Result(OneLine, Drawn, ReadOnly, ABC):
    """A result; each class declares its fields and says how it reads, the rest follows."""

    schema: ClassVar[str]
    row: ClassVar[str] = ""
    """What a row of a spreadsheet is."""
    title: ClassVar[str] = ""
    """Title of the file; ``{0}`` is the result."""
    arrays: ClassVar[Mapping[str, ResultPart]] = {}
    """Attributes that are arrays, besides fields that are declared so."""
    rows: ClassVar[str] = ""
    """Dimensions along which a table has a row for each place, separated by spaces."""
    recorded: ClassVar[tuple[str, ...]] = ()
    """Attributes in records."""

    gap: ClassVar[str] = "\n"
    """Separator of title, tables and sentences of a summary."""

    model: Model
    provenance: Provenance
    checked: Checked | None = None

    @classmethod
    def _field_text(cls, name: str, hint: Any) -> str:
        part = cls.arrays.get(name)
        text = super()._field_text(name, hint) if part is None else part.described()
        return text or USUAL[name]

    @classmethod
    def _more_notes(cls) -> str:
        return (
            (
                f"The arrays of `to_xarray` have the dimensions in brackets; a row of `to_csv` is "
                f"{cls.row}; files and `to_json` have the schema {cls.schema}."
            )
            if cls.row
            else ""
        )

    def summary(self) -> str:
        """Return a title, tables of the numbers and remarks as text."""
        return self._text(self._sections())

    @property
    def _loaded(self) -> Any:
        """What `slipfold.load` returns of a file that holds the result."""
        return self

    def _text(self, sections: Sequence[PrintedTable | list[str]]) -> str:
        lines = [each.text() if isinstance(each, PrintedTable) else each for each in sections]
        return self.gap.join("\n".join(each) for each in [[self._head()], *lines] if each)

    def to_json(self) -> dict[str, Any]:
        """Return the result as plain data for `json`; the notes of the class name the schema.

        What is not finite is None.
        """
        parameters = {name: float(value) for name, value in self.model.values.items()}
        head = {"schema": self.schema, "model": self.model.name, "parameters": parameters}
        checked = {} if self.checked is None else {"checked": self.checked.to_json()}
        return {**finite(head | scales_record(self.model) | self._record()), **checked}

    def to_xarray(self) -> xarray.Dataset:
        """Return all numbers as one labeled dataset; the notes of the class say along what.

        Returns
        -------
        xarray.Dataset
            Complex numbers are two variables, ``..._real`` and ``..._imag``; units and meanings are
            in the attributes, as is the full input.
        """
        return self._table().to_xarray()

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the table of `to_csv` as one of pandas.

        Returns
        -------
        pandas.DataFrame
            Units are in ``attrs["units"]``.
        """
        return self._frame().to_dataframe()

    def save(self, path: str | Path) -> None:
        """Write everything to a netCDF-4 file; `slipfold.load` reads it back.

        Parameters
        ----------
        path
            The file, ``....nc``; also ``.nc4``, ``.h5`` and ``.hdf5``. It is written whole or not
            at all.
        """
        check_writable(path, NETCDF)
        write_file(path, self._table().to_netcdf())

    def to_csv(self, path: str | Path) -> None:
        """Write a spreadsheet; the notes of the class say what is a row.

        Parameters
        ----------
        path
            The file. It is written whole or not at all.
        """
        write_file(path, self._frame().to_csv().encode())

    def _repr_html_(self) -> str:
        caption, *said = self._head().split("\n")
        page = ""
        for section in self._sections():
            if isinstance(section, PrintedTable):
                page += section.html(caption)
                caption = ""
            elif [*said, *section]:
                page += html_list([*said, *section])
                said = []
        return page

    def _head(self) -> str:
        """Return the first lines of the summary."""
        return self._line()

    def _sections(self) -> list[PrintedTable | list[str]]:
        """Return the tables and sentences of the summary."""
        return [self._rows(), self._notes()]

    def _notes(self) -> list[str]:
        """Return sentences that follow the tables, what was checked last."""
        return [] if self.checked is None else [str(self.checked)]

    def _line(self) -> str:
        """Return the title as a sentence."""
        title = self._title()
        return title[:1].upper() + title[1:]

    def _title(self) -> str:
        """Return a title in a few words."""
        return self.title.format(self)

    def _record(self) -> dict[str, Any]:
        """Return the record without the model."""
        parts = parts_of(type(self))
        return {
            name: parts[name].record(self, name) if name in parts else encoded(getattr(self, name))
            for name in self.recorded
        }

    def _frame(self) -> Frame:
        """Return the table of spreadsheets."""
        return frame_of(self._variables(), bound(self.rows, self, self._variable_name).split())

    def _variable_name(self, item: Parameter | State) -> str:
        """Return the name of the variable of a parameter or state, which no other variable has."""
        name = item.name
        while name in _taken(type(self)):
            name += "_value"
        return name

    def _given(self) -> dict[str, Any]:
        """Return the input besides the model, as plain data."""
        return {}

    def _attributes(self) -> dict[str, Any]:
        """Return the fields that are no arrays, as attributes of a dataset."""
        types = types_of(type(self))
        result = {}
        for name in _plain_fields(type(self)):
            value = getattr(self, name)
            if types[name] is bool:
                value = int(value)
            elif types[name] not in (str, int, float):
                value = json.dumps(encoded(value))
            result[name] = value
        for name, each in parts_of(type(self)).items():
            result |= each.attributes(self, name)
        return result

    def _variables(self) -> Mapping[str, Variable]:
        """Return all arrays with their names, units and meanings."""
        result: dict[str, Variable] = {}
        for name, each in parts_of(type(self)).items():
            result |= each.variables(self, name)
        return self._labels(result) | result

    def _labels(self, variables: Mapping[str, Variable]) -> dict[str, Variable]:
        """Return labels of the dimensions that results share, where they have them."""
        model = self.model
        known: dict[str, list[Parameter | State | Output]] = {
            "state": [*model.states],
            "output": [*model.states, *model.outputs()],
            "by_parameter": [*model.parameters],
        }
        dimensions = {name for item in variables.values() for name in item.dimensions}
        result: dict[str, Variable] = {}
        for name, items in known.items():
            if name in dimensions:
                result |= names(name, items)
        return result

    def _table(self) -> LabeledTable:
        """Return everything as labeled arrays, with the input and the origin as attributes."""
        model, structure = self.model, structure_record(self.model)
        given = {"model": model.name, "parameters": dict(model.values), **scales_record(model)}
        given |= ({"structure": structure} if structure else {}) | self._given()
        head = {"schema": self.schema, "title": self._title(), "model": model.name}
        checked = {} if self.checked is None else {"checked": json.dumps(self.checked.to_json())}
        origin = {"input": json.dumps(given), **self.provenance.attributes(), **checked}
        return LabeledTable(self._variables(), {**self._attributes(), **head, **origin})

    @classmethod
    def _read(cls, saved: SavedTable) -> Self:
        """Make a result from what a file holds."""
        types = types_of(cls)
        # Its fields are set as they are read, since names of later ones may depend on them.
        known = object.__new__(cls)
        result = vars(known)
        result |= {"model": saved.model, "provenance": saved.provenance}
        if "checked" in types:
            result["checked"] = saved.checked
        for name in _plain_fields(cls):
            value = saved.attributes[name]
            if types[name] not in (str, int, float, bool):
                value = json.loads(value)
            result[name] = decoded(types[name], value)
        own = {item.name for item in fields(cast(Any, cls))}
        for name, each in parts_of(cls).items():
            if name in own:
                result[name] = each.read(saved, known, name)
        return cls(**{name: result[name] for name in own if name in result})

    def __post_init__(self) -> None:
        """Lock arrays and mappings."""
        super().__post_init__()
        for name, value in vars(self).items():
            if isinstance(value, dict):
                vars(self)[name] = MappingProxyType(value)

    def __getstate__(self) -> dict[str, Any]:
        """Give what can be copied and sent to other processes: fields, mappings unlocked."""
        result = {item.name: getattr(self, item.name) for item in fields(cast(Any, self))}
        return {
            name: dict(value) if isinstance(value, MappingProxyType) else value
            for name, value in result.items()
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Lock it again."""
        vars(self).update(state)
        self.__post_init__()


class PerPeriod:
    """Base of results with Lyapunov exponents."""

    model: Model

    @property
    def per(self) -> str:
        """What Lyapunov exponents are per: ``"forcing period"``, or ``"s"``."""
        return "forcing period" if self.model.forced else "s"


def _plain_fields(kind: type[Result]) -> list[str]:
    """Return the names of fields that are no arrays."""
    parts = parts_of(kind)
    return [
        item.name
        for item in fields(cast(Any, kind))
        if item.name not in parts and item.name not in COMMON
    ]


@cache
def _taken(kind: type[Result]) -> frozenset[str]:
    """Return names of variables and dimensions that no parameter may take."""
    return STANDARD.union(*(each.names(name) for name, each in parts_of(kind).items()))


KINDS = {
    "attractors": "attractors.Attractors",
    "basin_fractions": "attractors.BasinFractions",
    "basins": "attractors.Basins",
    "design": "thresholds.Design",
    "fit": "measured.Fit",
    "locus": "locus_diagram.LocusDiagram",
    "lyapunov": "trajectories.LyapunovExponents",
    "measurement-plan": "measured.MeasurementPlan",
    "orbit": "orbit.SavedOrbit",
    "regimes": "trajectories.RegimeMap",
    "response": "diagram.Diagram",
    "responses": "responses.Responses",
    "simulation": "simulation.Simulation",
    "study": "study.StudyResult",
    "sweep": "trajectories.Sweep",
    "threshold_map": "thresholds.ThresholdMap",
    "uncertainty": "uncertainty.ThresholdUncertainty",
}
"""Class of each schema; it alone is imported."""


def load(path: str | Path, *, kind: type[Model] | None = None) -> Result | PeriodicOrbit:
    """Read a result that was saved.

    Parameters
    ----------
    path
        A file written by ``save``, by the command line's ``--out``, or saved from the explorer.
    kind
        The class of the model, if it is not a built-in one.

    Returns
    -------
    Result or PeriodicOrbit
        What was saved, number for number: a `slipfold.Diagram`, `slipfold.Simulation` or whatever
        else it was.

    Raises
    ------
    InputError
        If the file cannot be read, is damaged, or was not written by slipfold.
    """
    table = read_netcdf(path)
    schema = str(table.attributes.get("schema", ""))
    known = {f"slipfold.{name}/1": where for name, where in KINDS.items()}
    if schema in known:
        module, _, name = known[schema].rpartition(".")
        reader = getattr(import_module(f"slipfold.results.{module}"), name)
        try:
            result: Result = reader._read(open_table(table, kind))
            return result._loaded
        except InputError as error:
            raise InputError(f"{path}: {error}") from error
        # The numbers are those of the schema, or somebody changed the file.
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            raise InputError(
                f"{path} is damaged: it says it is {schema} but lacks parts of it "
                f"({type(error).__name__}: {error}); compute it again"
            ) from error
    if schema.startswith("slipfold."):
        raise InputError(
            f"{path} holds {schema}, which this version cannot read; it reads "
            f"{', '.join(known)}; upgrade slipfold"
        )
    raise InputError(f"{path} is not a result of slipfold; give a file that slipfold saved")
