"""What the page shows of a model at first, as far as the package knows better than its values."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from slipfold.models.model import Model
from slipfold.models.registry import built_in_models


def first_view(model: Model) -> dict[str, Any]:
    """Return what is known of the first view of a model.

    It is known of built-in models. One of a user's own may have the name of one of them and other
    parameters: what is said of a parameter that is not the same is left out.

    >>> from slipfold.models import System
    >>> own = System(name="duffing", parameters={"a": 1}, states={"q": "a - q"})
    >>> first_view(own)
    {'sliders': {}, 'show': 'q'}
    """
    known = _known().get(model.name)
    if known is None:
        return {"sliders": {}}
    named = {item.name: item for item in built_in_models()[model.name]().variable_parameters}
    same = {item.name for item in model.variable_parameters if named.get(item.name) == item}
    sliders = known.get("sliders", {})
    found = {"sliders": {name: ends for name, ends in sliders.items() if name in same}}
    if known["vary"] in same:
        found |= {"vary": known["vary"], "span": known["span"]}
    if known["show"] in {item.name for item in model.states}:
        found["show"] = known["show"]
    if "plane" in known and {axis["name"] for axis in known["plane"].values()} <= same:
        found["plane"] = known["plane"]
    return found


@cache
def _known() -> Mapping[str, Any]:
    text = (files("slipfold.explorer") / "first_view.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)
