"""Schema of a file with a system of equations."""

from __future__ import annotations

import dataclasses
import json
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from numbers import Real
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    StrictBool,
    StrictStr,
    ValidationInfo,
    create_model,
    field_serializer,
    model_serializer,
    model_validator,
)

from slipfold.errors import InputError, suggest
from slipfold.models.definitions.source import Keys, Source
from slipfold.models.definitions.tables import WrongEntry, check_keys, type_name, validate
from slipfold.models.formulas.functions import CONSTANTS, FUNCTIONS, TIME
from slipfold.models.formulas.grammar import BOUNDS
from slipfold.models.friction.law import FrictionLaw
from slipfold.models.friction.record import friction_laws, law_record
from slipfold.models.model import Model
from slipfold.models.parametric import declared
from slipfold.models.quantities import Limit, Parameter, check_state_name
from slipfold.models.units import check_unit, parse_quantity


class Table(BaseModel):
    """A table of a file, which may have the entries that are its fields."""

    model_config = ConfigDict(frozen=True, arbitrary_types_allowed=True)
    sole: ClassVar[str | None] = None
    """Entry that a value alone stands for."""

    @model_validator(mode="before")
    @classmethod
    def _check_keys(cls, given: Any) -> Any:
        if not isinstance(given, Mapping) and cls.sole is not None:
            return {cls.sole: given}
        examples = {
            name: (item.examples or [""])[0]
            for name, item in cls.model_fields.items()
            if item.is_required()
        }
        check_keys(given, list(cls.model_fields), examples)
        return given

    @model_serializer(mode="wrap")
    def _shorten(self, write: Any) -> Any:
        """Write the sole entry first, and its value alone if there is no other."""
        entries = write(self)
        if self.sole is None:
            return entries
        entries = {self.sole: entries[self.sole], **entries}
        return entries if len(entries) > 1 else entries[self.sole]


def _one_line(text: str) -> str:
    if not text.isprintable():
        raise WrongEntry(f"= {text[:80]!r} is more than one line; give one line")
    return text


def _number(given: Any, info: ValidationInfo) -> float:
    """Return a finite number, given as one or as a text with the unit of the table."""
    name, unit = str(info.field_name), info.data.get("unit", "")
    if isinstance(given, bool) or not isinstance(given, (Real, str)):
        raise WrongEntry(f"is {type_name(given)}; give a number")
    try:
        number = parse_quantity(given if isinstance(given, str) else _float(given), unit, name)
    except InputError as error:
        declared = name == "value" and not unit
        how = ', or declare a unit as in { value = 10, unit = "Hz" }' if declared else ""
        raise InputError(f"{error}{how}") from None
    if not math.isfinite(number):
        raise WrongEntry(f"= {number} is not a finite number; leave it out or give one")
    return number


def _float(given: Any) -> float:
    try:
        return float(given)
    except OverflowError:  # a whole number beyond floats
        return math.inf


def _formula(given: Any) -> Any:
    """Return a number as a formula, anything else as it is."""
    if isinstance(given, bool) or not isinstance(given, Real):
        return given
    if not math.isfinite(_float(given)):
        raise WrongEntry(f"= {_float(given)} is not a finite number; give a formula")
    return repr(_float(given))


Line = Annotated[StrictStr, AfterValidator(_one_line)]
Unit = Annotated[Line, AfterValidator(check_unit)]
Number = Annotated[float, BeforeValidator(_number)]
"""A number, or a text with a unit; the unit of the table, if it has one, is declared before."""
Formula = Annotated[StrictStr, BeforeValidator(_formula)]


_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,59}")

_TAKEN = frozenset(
    (
        # Attributes of models, which would hide a parameter of that name ...
        *(name for name in (*dir(Model), *Model.__annotations__) if not name.startswith("_")),
        *("events", "resting", "from_toml", "to_toml"),
        # ... and arguments of what takes parameters by name.
        *(
            "self",
            "definition",
            "sizes",
            "formulas",
            "forcing",
            "model",
            "vary",
            "span",
            "settings",
        ),
        *("on_progress", "plane", "window", "types", "regions", "regimes", "periods", "state"),
        *("tolerance", "settled", "search", "tori", "gradients", "duration", "also", "gaps"),
    )
)

_BRACES = re.compile(r"\{value(?::\.\d[efg])?\}")
"""Placeholders that a reason may have: others would be looked up in Python objects."""


def _name(text: str) -> str:
    """Refuse names that formulas cannot use."""
    if _NAME.fullmatch(text) is None:
        raise InputError(
            f"{text[:80]!r} cannot be a name in formulas; give at most 60 ASCII letters, "
            "digits and _, a letter first"
        )
    if text in FUNCTIONS or text in CONSTANTS or text == TIME:
        what = "a function" if text in FUNCTIONS else "a constant"
        meaning = "the time" if text == TIME else what
        raise InputError(f"{text} is {meaning} in formulas; choose another name")
    return text


def _title(text: str) -> str:
    """Refuse text that cannot name a limit or an event."""
    if not text.strip() or len(text) > 60 or not text.isprintable() or set(text) & set("{}"):
        raise InputError(f"{text[:80]!r} is not a name of a limit or event; give a few words")
    return text


def _reason(text: str) -> str:
    if set(_BRACES.sub("", text)) & set("{}"):
        raise WrongEntry("may have {value} and {value:.3g} for the value, but no other braces")
    return text


T = TypeVar("T")
Named = Annotated[dict[Annotated[str, AfterValidator(_name)], T], Field(max_length=BOUNDS.entries)]
Titled = Annotated[
    dict[Annotated[str, AfterValidator(_title)], T], Field(max_length=BOUNDS.entries)
]


class ParameterTable(Table):
    """A parameter, or its value alone."""

    sole: ClassVar[str] = "value"
    unit: Unit = ""
    doc: Line = ""
    value: Number = Field(examples=["value = 1.0"])
    min: Number = -math.inf
    above: Number = -math.inf
    max: Number = math.inf
    below: Number = math.inf
    symbol: Line = ""

    @model_validator(mode="after")
    def _check_bounds(self) -> Self:
        for closed, opened in (("min", "above"), ("max", "below")):
            if {closed, opened} <= self.model_fields_set:
                message = f"has both {closed} and {opened}; give the one that is meant"
                raise WrongEntry(message, opened)
        bounds = self.parameter("")
        lower, upper = bounds.lower, bounds.upper
        if lower > upper or (lower == upper and (bounds.lower_open or bounds.upper_open)):
            raise WrongEntry(f"has no value from {lower:g} to {upper:g}; exchange the bounds")
        return self

    def parameter(self, name: str) -> Parameter:
        """Return the parameter of this name."""
        lower_open, upper_open = (key in self.model_fields_set for key in ("above", "below"))
        return Parameter(
            name,
            self.value,
            self.unit,
            self.doc,
            self.above if lower_open else self.min,
            self.below if upper_open else self.max,
            lower_open,
            upper_open,
            self.symbol,
        )


class StateTable(Table):
    """A state, or the formula of its rate alone."""

    sole: ClassVar[str] = "rate"
    unit: Unit = ""
    doc: Line = ""
    label: Line = ""
    rate: Formula = Field(examples=['rate = "2*q"'])  # time derivative, per second
    scale: Number | None = Field(default=None, gt=0)  # typical size; None if it is to be estimated
    angle: StrictBool = False
    start: Number = 0.0  # value from which trajectories and searches start


EXAMPLE = 'F = { slip = "Vd - v", normal = "N", friction = "Coulomb" }'


@dataclass(frozen=True)
class LawFormulas:
    """A friction law with default values, and a formula for each of its parameters."""

    law: FrictionLaw
    formulas: Mapping[str, str]


def _law(given: Any) -> LawFormulas:
    """Read a friction law whose parameters are formulas."""
    record: Any = law_record(given) if isinstance(given, FrictionLaw) else given
    table = {"law": record} if isinstance(record, str) else record
    if not isinstance(table, Mapping):
        raise WrongEntry(f'is {type_name(given)}; give a law, e.g. friction = "Coulomb"')
    laws = {name: law for name, law in friction_laws().items() if law.sticks}
    name = table.get("law")
    if not isinstance(name, str) or name not in laws:
        shown = name[:80] if isinstance(name, str) else type_name(name)
        raise WrongEntry(
            f"has {shown!r}, not a law that sticks; {suggest(shown, laws)}there are "
            f"{', '.join(laws)}, and laws that do not stick are written as formulas",
            "law",
        )
    law = laws[name]
    read = validate(_law_table(law).model_validate, table)
    values = {item.name: getattr(read, item.name) for item in declared(law)}
    # Coefficients that are equal if only one is given, as in `Coulomb`, have no value by default.
    fields = dataclasses.fields(law)
    alike = [item.name for item in fields if item.name in values and item.default is None]
    given = [values[name] for name in alike if name in table]
    values |= {name: given[0] for name in alike if given and name not in table}
    own = [item.name for item in dataclasses.fields(law)]
    made = law(**{key: table[key] for key in own if key in table and key not in values})
    return LawFormulas(made, values)


@cache
def _law_table(law: type[FrictionLaw]) -> type[Table]:
    """Return the table of a law: formulas for its parameters, its other fields as they are."""
    fields: dict[str, Any] = {item.name: (Any, None) for item in dataclasses.fields(law)}
    fields |= {item.name: (Formula, repr(item.default)) for item in declared(law)}
    return create_model(law.__name__, __base__=Table, law=(str, law.__name__), **fields)


def _components(given: Any) -> Any:
    several = given if isinstance(given, list | tuple) else (given,)
    if len(several) not in (1, 2):
        raise WrongEntry(
            f"has {len(several)} components; give one formula on a line, or two in a plane"
        )
    return several


class ContactTable(Table):
    """A contact; its friction force has its name in other formulas."""

    # One or two components of the relative velocity along which it rubs
    slip: Annotated[tuple[Formula, ...], BeforeValidator(_components)] = Field(examples=[EXAMPLE])
    normal: Formula = Field(examples=[EXAMPLE])
    friction: Annotated[LawFormulas, BeforeValidator(_law)] = Field(
        default="Coulomb", validate_default=True
    )

    @field_serializer("slip")
    def _write_slip(self, slip: tuple[str, ...]) -> str | tuple[str, ...]:
        return slip[0] if len(slip) == 1 else slip

    @field_serializer("friction")
    def _write_law(self, friction: LawFormulas) -> dict[str, Any]:
        return {**law_record(friction.law), **friction.formulas}

    def forces(self, name: str) -> tuple[str, ...]:
        """Return the names of the components of friction."""
        return (name,) if len(self.slip) == 1 else (f"{name}x", f"{name}y")

    def force_names(self, name: str) -> tuple[str, ...]:
        """Return the names of friction and the normal force in other formulas."""
        return (*self.forces(name), f"{name}_normal")

    def output_names(self, name: str) -> tuple[str, ...]:
        """Return the names of forces, slip speed, and that over the moving surface's speed."""
        return (*self.force_names(name), f"{name}_slip", f"{name}_ratio")

    def texts(self, name: str) -> dict[Keys, str]:
        """Return all formulas, by the path of the entry that holds them."""
        path: Keys = ("contacts", name)
        several = len(self.slip) > 1
        slips: dict[Keys, str] = {
            (*path, "slip", *([str(axis)] if several else [])): text
            for axis, text in enumerate(self.slip)
        }
        values = self.friction.formulas.items()
        law: dict[Keys, str] = {(*path, "friction", key): text for key, text in values}
        return {**slips, (*path, "normal"): self.normal, **law}


class OutputTable(Table):
    """A quantity of interest, or its formula alone."""

    sole: ClassVar[str] = "formula"
    unit: Unit = ""
    doc: Line = ""
    label: Line = ""
    formula: Formula = Field(examples=['formula = "2*q"'])  # in states, parameters and the time


class ForcingTable(Table):
    """The periodic forcing."""

    period: Formula = Field(  # in seconds
        examples=['period = "2*pi/W" in seconds, or leave the table out for an autonomous system']
    )
    amplitude: Line | None = None  # name of the parameter that switches the forcing off


class LimitTable(Table):
    """A bound of validity: an output that stays above it."""

    output: Line
    bound: Number
    reason: Annotated[Line, AfterValidator(_reason)] = ""

    def limit(self, name: str) -> Limit:
        """Return the limit of this name."""
        default = f"{name}: {self.output} fell to {{value:.3g}}; the model ends at {self.bound:g}"
        return Limit(name, self.output, self.bound, self.reason or default)


class EventTable(Table):
    """A value to be located on every branch."""

    output: Line = ""
    value: Number = Field(examples=["value = 1.0"])
    measure: Literal["max", "min", "peak_to_peak", "rms", "harmonic", "parameter"] = "max"
    stop: StrictBool = False


@dataclass(frozen=True)
class WatchedValue:
    """An event: a value of an output, or of a parameter, to be located on every branch."""

    name: str  # name of the event
    output: str  # a state, an output or, with the measure ``"parameter"``, a parameter
    value: float  # the value, in its unit
    measure: str = "max"  # as in `EventTable`
    stop: bool = False  # whether the branch ends there


class SystemFile(Table):
    """A system of first-order equations."""

    name: Line = "system"
    title: Line = ""
    sizes: Any = None  # of arrays, which are written out before
    parameters: Named[ParameterTable] = Field(default_factory=dict)
    formulas: Named[Formula] = Field(default_factory=dict)
    states: Annotated[Named[StateTable], Field(min_length=1)] = Field(
        examples=['a table [states] with the rate of each state, e.g. q = "v"']
    )
    contacts: Named[ContactTable] = Field(default_factory=dict)
    forcing: ForcingTable | None = None  # None for an autonomous system
    outputs: Named[OutputTable] = Field(default_factory=dict)
    limits: Titled[LimitTable] = Field(default_factory=dict)
    events: Titled[EventTable] = Field(default_factory=dict)

    @property
    def period(self) -> str | None:
        """Formula of the forcing period in seconds; None for an autonomous system."""
        return None if self.forcing is None else self.forcing.period

    @property
    def watched_values(self) -> tuple[WatchedValue, ...]:
        """The events."""
        return tuple(
            WatchedValue(name, item.output or name, item.value, item.measure, item.stop)
            for name, item in self.events.items()
        )

    def own_parameters(self) -> tuple[Parameter, ...]:
        """Return the parameters."""
        return tuple(item.parameter(name) for name, item in self.parameters.items())


def read_system(source: Source, default_name: str = "system") -> SystemFile:
    """Read a definition; formulas stay texts."""
    named = {"name": default_name} if source.tables.get("name", "") == "" else {}
    definition: SystemFile = source.read(
        partial(validate, SystemFile.model_validate), {**source.tables, **named}
    )
    for parameter in definition.own_parameters():
        try:
            parameter.check(parameter.default)
        except InputError as error:
            raise source.error(("parameters", parameter.name), str(error)) from None
    _check_names(definition, source)
    _check_references(definition, source)
    return definition


def _check_names(definition: SystemFile, source: Source) -> None:
    """Refuse names that are taken, or given twice."""
    owners: dict[str, str] = {}

    def claim(path: Keys, names: Iterable[str], what: str) -> None:
        for name in names:
            if owners.setdefault(name, what) != what:
                message = f"{name} is {owners[name]} and {what}; a name can be one of them only, "
                raise source.error(path, f"{message}rename one", key=True)

    for name in definition.parameters:
        claim(("parameters", name), [name], "a parameter")
        if name in _TAKEN:
            raise source.error(
                ("parameters", name),
                f"a parameter cannot be called {name}, which is an attribute or argument in Python "
                f"already; call it e.g. {name}_0",
                key=True,
            )
    for name in definition.formulas:
        claim(("formulas", name), [name], "a formula")
    for name in definition.states:
        claim(("states", name), [name], "a state")
        try:
            check_state_name(name)
        except InputError as error:
            raise source.error(("states", name), str(error), key=True) from None
    for name, contact in definition.contacts.items():
        claim(("contacts", name), contact.output_names(name), f"a quantity of the contact {name}")
    for name in definition.outputs:
        # An output may show a formula under its own name; states are outputs already.
        if name not in definition.formulas:
            claim(("outputs", name), [name], "an output")


def _check_references(definition: SystemFile, source: Source) -> None:
    """Refuse limits, events and amplitudes with unknown names."""
    parameters = list(definition.parameters)
    outputs = [*definition.states, *definition.outputs]
    for name, contact in definition.contacts.items():
        outputs += contact.output_names(name)

    def look_up(path: Keys, name: str, known: list[str], what: str) -> None:
        if name not in known:
            message = f"there is no {what} {name[:80]!r}; {suggest(name[:80], known)}"
            raise source.error(path, f"{message}there are {', '.join(known) or 'none'}")

    if definition.forcing is not None and definition.forcing.amplitude is not None:
        look_up(("forcing", "amplitude"), definition.forcing.amplitude, parameters, "parameter")
    for name, limit in definition.limits.items():
        look_up(("limits", name, "output"), limit.output, outputs, "output")
    for event in definition.watched_values:
        of_parameter = event.measure == "parameter"
        known, what = (parameters, "parameter") if of_parameter else (outputs, "output")
        look_up(("events", event.name, "output"), event.output, known, what)


def write_system(definition: SystemFile) -> str:
    """Write a definition as TOML, always the same for the same definition.

    >>> print(write_system(SystemFile(name="decay", states={"q": "-q"})))
    name = "decay"
    <BLANKLINE>
    [states]
    q = "-q"
    <BLANKLINE>
    """
    entries = definition.model_dump(exclude_defaults=True, exclude={"name", "sizes"})
    return write_tables({"name": definition.name, **entries})


def write_tables(tables: Mapping[str, Any]) -> str:
    """Write a file as TOML: single entries first, then tables and lists of tables.

    >>> print(write_tables({"name": "own", "elements": [{"k": 2}], "watch": {"u": "tip"}}))
    name = "own"
    <BLANKLINE>
    [[elements]]
    k = 2
    <BLANKLINE>
    [watch]
    u = "tip"
    <BLANKLINE>
    """
    single = {key: value for key, value in tables.items() if isinstance(value, str)}
    blocks = [_lines(single)] if single else []
    for key, table in tables.items():
        if isinstance(table, Mapping):
            blocks += [f"[{key}]\n{_lines(table)}"] if table else []
        elif isinstance(table, list | tuple):
            blocks += [f"[[{key}]]\n{_lines(item)}" for item in table]
    return "\n\n".join(blocks) + "\n"


def _lines(entries: Mapping[str, Any]) -> str:
    return "\n".join(f"{_key(key)} = {toml_value(value)}" for key, value in entries.items())


def _key(name: str) -> str:
    plain = name.isascii() and name.replace("_", "a").isalnum()
    return name if plain else toml_value(name)


def toml_value(value: Any) -> str:
    """Write a value as TOML, tables and arrays in one line."""
    if isinstance(value, Mapping):
        entries = ", ".join(f"{_key(key)} = {toml_value(item)}" for key, item in value.items())
        return f"{{ {entries} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(toml_value(item) for item in value)}]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # JSON escapes a string as TOML does, but for one character.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    number = float(value)
    return str(int(number)) if number.is_integer() and abs(number) < 1e15 else repr(number)
