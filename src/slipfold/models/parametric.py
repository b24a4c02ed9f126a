"""Parts of models with parameters of their own: friction laws, springs, contacts, forces."""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, dataclass, field, fields
from functools import cache, cached_property
from typing import Any, ClassVar, Self

from slipfold.errors import InputError, unknown
from slipfold.models.quantities import Parameter
from slipfold.models.units import parse_quantity
from slipfold.read_only import Documented, with_parameters

SYMBOL = re.compile(r"^\$([^_]+)_?\{?(\\?\w*(?:\{\w*\})?)\}?\$$")
"""A symbol in mathtext: what the number of its part goes below."""


def described(parameter: Parameter, default: Any = MISSING) -> Any:
    """Return the dataclass field that holds the value of a parameter.

    A parameter whose default is None is none unless it is given, or `prepare` gives it a value.
    """
    given = parameter.default if default is MISSING else default
    return field(default=given, metadata={"parameter": parameter})


def structural(
    doc: str, default: Any = MISSING, read: Callable[[Any, str], Any] | None = None, **options: Any
) -> Any:
    """Return a dataclass field that distinguishes equations.

    `read` makes the value of a given one and the title of the part; a default of None stays.
    """
    metadata = {"doc": doc, "read": read, **options.pop("metadata", {})}
    return field(default=default, metadata=metadata, **options)


_fields: Callable[[type], tuple[dataclasses.Field[Any], ...]] = cache(fields)


def declared(cls: type) -> tuple[Parameter, ...]:
    """Return the parameters whose values a dataclass holds."""
    parameters = (item.metadata.get("parameter") for item in _fields(cls))
    return tuple(item for item in parameters if item is not None)


@dataclass(frozen=True)
class Parametric(Documented):
    """A part of a model with parameters of its own; immutable, comparable, picklable.

    A subclass is a frozen dataclass. Its parameters are fields made by `described`; all other
    fields, made by `structural`, distinguish equations. The parameters of parts in them are its own
    as well; those of several parts in a tuple are numbered. The section on parameters in the
    docstring follows from the fields.
    """

    title: ClassVar[str] = ""

    def __init_subclass__(cls, **options: Any) -> None:
        """Complete the section on parameters in the docstring."""
        super().__init_subclass__(**options)
        bases = [base for base in reversed(cls.__mro__[1:]) if dataclasses.is_dataclass(base)]
        held = [item for base in bases for item in fields(base)]
        first = {item.name: item.metadata for item in held if not item.kw_only}
        own = {name: vars(cls).get(name) for name in inspect.get_annotations(cls)}
        new = {name: getattr(item, "metadata", {}) for name, item in own.items()}
        last = {item.name: item.metadata for item in held if item.kw_only}
        known = {**first, **new, **last, **new}
        meanings = {name: _meaning(metadata) for name, metadata in known.items()}
        said = {name: meaning for name, meaning in meanings.items() if meaning}
        cls.__doc__ = with_parameters(cls.__doc__, said)

    def __post_init__(self) -> None:
        """Check the fields and convert what has a unit."""
        self._convert(_as_read)
        self.prepare()
        self._convert(_as_number)
        self.check(self.values)

    def _convert(self, convert: Callable[[dataclasses.Field[Any], Any, str], Any]) -> None:
        for item in _fields(type(self)):
            given = getattr(self, item.name)
            try:
                made = convert(item, given, self.title)
            except InputError as error:
                error.entry = (item.metadata.get("entry", item.name), *error.entry)
                raise
            if made is not given:
                object.__setattr__(self, item.name, made)

    def prepare(self) -> None:
        """Raise `InputError` if the fields that are not parameters contradict each other."""

    def check(self, values: Mapping[str, float]) -> None:
        """Raise `InputError` if parameter values contradict each other.

        Parameters
        ----------
        values
            Values of the parameters by name; others may be among them.
        """
        for part in self._parts:
            part.check(values)

    @cached_property
    def _parts(self) -> list[Parametric]:
        """The parts that fields hold, without those that are numbered."""
        values = (getattr(self, item.name) for item in _fields(type(self)))
        return [value for value in values if isinstance(value, Parametric)]

    def _pairs(self) -> Iterator[tuple[Parameter, float]]:
        """Yield the parameters and their values, in the order of the fields."""
        for item in _fields(type(self)):
            value, parameter = getattr(self, item.name), item.metadata.get("parameter")
            if parameter is not None:
                if value is not None:
                    yield parameter, value
            elif isinstance(value, Parametric):
                yield from value._pairs()
            else:
                for number, part in enumerate(_several(value), 1):
                    for each, own in part._pairs():
                        doc = f"{each.doc}, number {number}"
                        name = f"{each.name}{number}"
                        symbol = SYMBOL.sub(rf"$\1_{{\g<2>{number}}}$", each.symbol)
                        yield dataclasses.replace(each, name=name, doc=doc, symbol=symbol), own

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Names, units, bounds and meanings of the parameters."""
        return tuple(parameter for parameter, _ in self._pairs())

    @property
    def values(self) -> dict[str, float]:
        """Values of the parameters by name, in SI units."""
        return {parameter.name: value for parameter, value in self._pairs()}

    @property
    def kind(self) -> Self:
        """The part with default values: equal for all parts with the same equations."""
        return self._with(lambda name, parameter, value: parameter.default)

    def replace(self, **changes: Any) -> Self:
        """Return a new part with some values changed.

        Parameters
        ----------
        **changes
            New values by name, numbers in SI units or text with a unit; or new values of fields
            that are not parameters.
        """
        names = [item.name for item in _fields(type(self))]
        new = {name: changes.pop(name) for name in names if name in changes}
        made = dataclasses.replace(self, **new) if new else self
        if changes:
            made = made._with(lambda name, parameter, value: changes.pop(name, value))
        for name in changes:
            known = list(dict.fromkeys([*names, *self.values]))
            raise unknown(f"{type(self).__name__} has no parameter", name, known)
        return made

    def _with(self, value_of: Callable[[str, Parameter, float], Any]) -> Self:
        """Return the part with values by name, parameter and present value."""
        changes: dict[str, Any] = {}
        for item in _fields(type(self)):
            value, parameter = getattr(self, item.name), item.metadata.get("parameter")
            if parameter is not None:
                if value is not None:
                    changes[item.name] = value_of(parameter.name, parameter, value)
            elif isinstance(value, Parametric):
                changes[item.name] = value._with(value_of)
            elif several := _several(value):
                changes[item.name] = tuple(
                    part._with(lambda name, *given, n=number: value_of(f"{name}{n}", *given))
                    for number, part in enumerate(several, 1)
                )
        return dataclasses.replace(self, **changes)


def _as_read(item: dataclasses.Field[Any], given: Any, title: str) -> Any:
    read = item.metadata.get("read")
    if read is None or (given is None and item.default is None):
        return given
    return read(given, title)


def _as_number(item: dataclasses.Field[Any], given: Any, title: str) -> Any:
    parameter = item.metadata.get("parameter")
    if parameter is None or (given is None and item.default is None):
        return given
    return parameter.check(parse_quantity(given, parameter.unit, parameter.name))


def _several(value: Any) -> tuple[Parametric, ...]:
    """Return the parts in a tuple of parts; none if it is something else."""
    if isinstance(value, tuple) and value and all(isinstance(part, Parametric) for part in value):
        return value
    return ()


def _meaning(metadata: Mapping[str, Any]) -> str:
    """Return what a field means, as a sentence."""
    parameter, meaning = metadata.get("parameter"), str(metadata.get("doc", ""))
    if parameter is not None:
        bounded = parameter.bounds != Parameter("", 0.0).bounds
        unit = f", in {parameter.unit}" if parameter.unit else ""
        meaning = parameter.doc + (f" ({parameter.bounds})" if bounded else unit)
        meaning = meaning.replace("|", r"\|")  # else Sphinx takes it for a substitution
    return meaning and f"{meaning[0].upper()}{meaning[1:]}."
