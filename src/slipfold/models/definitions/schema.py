"""Tables of model files as pydantic models: the types of their entries."""

from __future__ import annotations

import math
from collections.abc import Mapping
from numbers import Real
from typing import Annotated, Any, ClassVar

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    StrictStr,
    ValidationInfo,
    model_serializer,
    model_validator,
)

from slipfold.models.definitions.tables import WrongEntry, check_keys, type_name
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
    number = parse_quantity(given if isinstance(given, str) else _float(given), unit, name)
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
