"""Data classes with read-only arrays and documented fields."""

from __future__ import annotations

import re
from collections.abc import Mapping
from inspect import cleandoc, get_annotations, isfunction
from textwrap import fill
from typing import Annotated, Any, ClassVar, get_origin, get_type_hints

import numpy as np


def field_hints(kind: type) -> dict[str, Any]:
    """Return the types of fields, those of bases first, with what they mean."""
    hints = get_type_hints(kind, include_extras=True)
    for each in reversed(kind.__mro__):
        hints |= vars(each).get("_annotated", {})
    return hints


def _make_bare(kind: type[Documented]) -> None:
    """Leave the bare types of fields in annotations, which signatures show."""
    own, hints = get_annotations(kind), get_type_hints(kind, include_extras=True)
    found = {name: hints[name] for name in own if get_origin(hints[name]) is Annotated}
    kind._annotated = found
    kind.__annotations__ |= {name: hint.__origin__ for name, hint in found.items()}


SECTIONS = ("Parameters", "Returns", "Raises", "Notes", "References", "Examples")
"""Sections of docstrings, in their order."""


def with_section(doc: str, title: str, body: str, between: str = "\n\n") -> str:
    """Return a docstring with a section; one that is there has more at its beginning."""
    head = f"\n{title}\n{'-' * len(title)}\n"
    before, there, after = doc.partition(head)
    if there:
        return f"{before}{head}{body}{between}{after}"
    later = "|".join(SECTIONS[SECTIONS.index(title) + 1 :])
    section = re.search(rf"\n({later})\n-+\n", doc)
    end = section.start() if section else len(doc)
    return f"{doc[:end].rstrip()}\n{head}{body}\n{doc[end:]}"


def with_parameters(doc: str | None, meanings: Mapping[str, str]) -> str:
    """Return a docstring with parameters by name; an empty text is that of the one before."""
    lines = list[str]()
    for name, text in meanings.items():
        if text:
            lines += [name, fill(text, 96, initial_indent="    ", subsequent_indent="    ")]
        else:
            lines[-2] += f", {name}"
    text = cleandoc(doc or "")
    return with_section(text, SECTIONS[0], "\n".join(lines), "\n") if lines else text


def _describe(method: Any) -> None:
    """Add parameters to the docstring of a method whose types say what they mean."""
    meanings = {}
    for name, hint in method.__annotations__.items():
        note = getattr(method.__globals__.get(hint), "__metadata__", (None,))[0]
        if isinstance(note, str) and name != "return":
            meanings[name] = note
            method.__annotations__[name] = method.__globals__[hint].__origin__
    if meanings:
        method.__doc__ = with_parameters(method.__doc__, meanings)


class Documented:
    """Base of classes whose docstrings get their section on parameters from annotations.

    Fields of data classes declare what they mean, ``Annotated[type, "text"]``; an empty text is
    that of the field before. Parameters of methods have such a type by its name.
    """

    _annotated: ClassVar[dict[str, Any]] = {}  # the fields of the class itself with their texts

    def __init_subclass__(cls, **options: Any) -> None:
        """Write the sections on parameters into the docstrings of the class and its methods."""
        super().__init_subclass__(**options)
        if not cls.__module__.startswith("slipfold."):  # those of others may be no texts
            return
        for method in filter(isfunction, vars(cls).values()):
            _describe(method)
        if "Annotated" in str(get_annotations(cls)):
            _make_bare(cls)
        own = "\nParameters\n" in cleandoc(cls.__doc__ or "")
        if own or not any(vars(k).get("_annotated") for k in cls.__mro__):
            return
        meanings = {}
        for name, hint in field_hints(cls).items():
            if get_origin(hint) is not ClassVar:
                shared = getattr(hint, "__metadata__", ()) == ("",)
                text = "" if shared else cls._field_text(name, hint)
                if shared or text:  # classes derived from a base say what its fields mean
                    meanings[name] = text
        cls.__doc__ = with_parameters(cls.__doc__, meanings)
        if more := cls._more_notes():
            cls.__doc__ = with_section(cls.__doc__, "Notes", fill(more, 96))

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
