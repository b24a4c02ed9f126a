"""Data classes with read-only arrays and documented fields."""

from __future__ import annotations

import re
from collections.abc import Mapping
from inspect import cleandoc, get_annotations
from textwrap import fill
from typing import Any, ClassVar, get_origin, get_type_hints

import numpy as np


def _own(kind: type) -> dict[str, Any]:
    """Return the annotations of a class, those of its bases first."""
    found: dict[str, Any] = {}
    for each in reversed(kind.__mro__):
        found |= get_annotations(each)
    return found


class Documented:
    """Base of data classes whose docstrings get their section on parameters from annotations.

    Fields declare what they mean, ``Annotated[type, "text"]``; an empty text is that of the field
    before.
    """

    def __init_subclass__(cls, **options: Any) -> None:
        """Write the section on parameters into the docstring."""
        super().__init_subclass__(**options)
        text = cleandoc(cls.__doc__ or "")
        section = re.search(r"\n(Notes|References|Examples)\n-+\n", text)
        before, after = (
            (text[: section.start()], text[section.start() :]) if section else (text, "")
        )
        if "\nParameters\n" in before or "Annotated" not in str(_own(cls)):
            return
        hints = get_type_hints(cls, include_extras=True)
        lines = [before.rstrip("\n"), "", "Parameters", "----------"]
        for name in _own(cls):
            if get_origin(hints[name]) is not ClassVar:
                if getattr(hints[name], "__metadata__", ()) == ("",):
                    lines[-2] += f", {name}"
                    continue
                text = cls._field_text(name, hints[name])
                lines += [name, fill(text, 96, initial_indent="    ", subsequent_indent="    ")]
        if more := cls._more_notes():
            lines += ["", "Notes", "-----", fill(more, 96)]
            if section and section[1] == "Notes":
                after = "\n" + after.removeprefix(section[0])
        cls.__doc__ = "\n".join(lines) + f"\n{after}"

    @classmethod
    def _more_notes(cls) -> str:
        """Return what the notes begin with."""
        return ""

    @classmethod
    def _field_text(cls, name: str, hint: Any) -> str:
        """Return the text of a field, from its annotation."""
        (note,) = getattr(hint, "__metadata__", ("",))[:1]
        return note if isinstance(note, str) else note.described()


class ReadOnly(Documented):
    """Base of frozen data classes: arrays among their fields, and in mappings there, are locked."""

    def __post_init__(self) -> None:
        """Lock the arrays."""
        for value in vars(self).values():
            for each in value.values() if isinstance(value, Mapping) else (value,):
                if isinstance(each, np.ndarray):
                    each.setflags(write=False)
