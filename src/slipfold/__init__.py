"""Vibration of sliding structures with friction, and how it loses stability.

Three lines lead to a bifurcation diagram:

>>> import slipfold as sf
>>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.98), f=12.5)
>>> [point.type for branch in diagram.branches for point in branch.special]
['PD', 'NS', 'NS']
"""

import re
from importlib import import_module
from pathlib import Path

_HOMES = {
    name: home
    for home, name in re.findall(
        r"^from (\S+) import (\w+) as \2$",
        Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"),
        re.MULTILINE,
    )
}
"""Modules of the public names, as type checkers read them."""

__all__ = sorted(_HOMES)


def __getattr__(name: str) -> object:
    """Import a public name, or look the version up."""
    if name == "__version__":
        return import_module("slipfold.version").package_version()
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(import_module(_HOMES[name]), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """List the public names and the attributes of every module."""
    return sorted({*__all__, "__version__", *(name for name in globals() if name.startswith("__"))})
