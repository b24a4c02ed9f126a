"""Which names a system of equations may give to its parameters, states, formulas and outputs."""

from __future__ import annotations

import re
from collections.abc import Iterable

from slipfold.models.definitions.definition import Definition
from slipfold.models.definitions.source import Source
from slipfold.models.formulas.functions import CONSTANTS, FUNCTIONS

TIME = "t"
"""The time in seconds, in formulas of forced systems."""

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,59}")

_TAKEN = frozenset(
    (
        # Attributes of every model, where a parameter of that name would be hidden ...
        *(
            "name",
            "title",
            "states",
            "parameters",
            "limits",
            "quiet",
            "outputs",
            "period",
            "duration",
        ),
        *(
            "coefficients",
            "rates",
            "declared_scales",
            "found_sizes",
            "measured_in",
            "state_scales",
            "unit_scales",
            "quiet_scales",
            "check",
            "structure",
            "kind",
            "values",
        ),
        *("vector", "parameter", "parameter_index", "replace", "evaluate"),
        *("variable_parameter", "variable_parameters", "varied_first"),
        *(
            "events",
            "contacts",
            "resting",
            "whole_turns",
            "forced",
            "start",
            "from_toml",
            "to_toml",
        ),
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
        *("observer", "plane", "window", "types", "regions", "regimes", "periods", "state"),
        *("tolerance", "settled", "search", "tori", "gradients"),
    )
)

_SYMBOLS = ("c_", "p_", "carried_")
"""How the compiled equations begin the names of coefficients, parameters and variations."""


def check_names(definition: Definition, source: Source) -> None:
    """Refuse names that cannot be written in formulas, are taken, or are given twice."""
    parameters = [item.name for item in definition.parameters]
    states = [item.state.name for item in definition.states]
    formulas = [name for name, _ in definition.formulas]
    outputs = [item.name for item in definition.outputs]
    given: dict[str, str] = {}
    for table, what, names in (
        ("parameters", "a parameter", parameters),
        ("formulas", "a formula", formulas),
        ("states", "a state", states),
    ):
        _check_form(names, table, source)
        _check_double(names, table, what, given, source)
        given |= dict.fromkeys(names, what)
    for item in definition.contacts:
        _check_form([item.name], "contacts", source)
        for name in item.output_names:
            what = f"a quantity of the contact {item.name}"
            _check_double([name], "contacts", what, given, source)
            given[name] = what
    _check_form(outputs, "outputs", source)
    # An output may show a formula under its own name; states are outputs already.
    shown = {name: what for name, what in given.items() if what != "a formula"}
    _check_double(outputs, "outputs", "an output", shown, source)
    for name in parameters:
        if name in _TAKEN:
            raise source.error(
                ("parameters", name),
                f"a parameter cannot be called {name}, which is an attribute or argument in Python "
                f"already; call it e.g. {name}_0",
                key=True,
            )
    for name in states:
        if name == "phase" or name.startswith(_SYMBOLS):
            raise source.error(
                ("states", name),
                f"a state cannot be called {name}: phase and names that begin with "
                f"{', '.join(_SYMBOLS)} are used inside; call it e.g. q_{name}",
                key=True,
            )


def _check_form(names: Iterable[str], table: str, source: Source) -> None:
    for name in names:
        if _NAME.fullmatch(name) is None:
            raise source.error(
                (table, name),
                f"{name[:80]!r} cannot be a name in formulas; give at most 60 ASCII letters, "
                "digits and _, a letter first",
                key=True,
            )
        if name in FUNCTIONS or name in CONSTANTS or name == TIME:
            what = "a function" if name in FUNCTIONS else "a constant"
            meaning = "the time" if name == TIME else what
            raise source.error(
                (table, name), f"{name} is {meaning} in formulas; choose another name", key=True
            )


def _check_double(
    names: Iterable[str], table: str, what: str, given: dict[str, str], source: Source
) -> None:
    for name in names:
        if name in given:
            raise source.error(
                (table, name),
                f"{name} is {given[name]} and {what}; a name can be one of them only, rename one",
                key=True,
            )
