"""Tables checked by pydantic; the first thing that is wrong with one is one sentence."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from slipfold.errors import InputError


def validated(validate: Callable[[Any], Any], given: Any, place: str, key: str = "") -> Any:
    """Return what pydantic makes of a table that stands in some place.

    Where a key says what else the table has, pydantic puts its value before the other keys.
    """
    from pydantic import ValidationError

    try:
        return validate(given)
    except ValidationError as error:
        raise InputError(_sentence(error.errors(include_url=False)[0], place, key)) from None


def _sentence(first: Any, place: str, key: str) -> str:
    keys = [str(each) for each in first["loc"] if each not in ("float", "str")]
    path = ".".join([place, *keys[bool(key) :]])
    if first["type"] == "union_tag_not_found":
        return f"{path}.{key} is missing; give it"
    if first["type"] == "union_tag_invalid":
        context = first["ctx"]
        return f"{path}.{key} = {context['tag']!r} is unknown; give {context['expected_tags']}"
    if first["type"] == "extra_forbidden":
        return f"{path} is unknown; leave it out"
    if first["type"] == "missing":
        return f"{path} is missing; give it"
    return (
        f"{path} = {first['input']!r} cannot be used: {first['msg'][:1].lower()}{first['msg'][1:]}"
    )
