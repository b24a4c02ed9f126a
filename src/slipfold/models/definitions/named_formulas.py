"""The formulas of a system as trees: names looked up, named formulas in an order that works."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from slipfold.errors import InputError
from slipfold.models.definitions.definition import Definition
from slipfold.models.definitions.names import TIME
from slipfold.models.definitions.source import Source
from slipfold.models.definitions.toml_places import Path
from slipfold.models.formulas.functions import CONSTANTS
from slipfold.models.formulas.grammar import parse_formula
from slipfold.models.formulas.tokens import FormulaError
from slipfold.models.formulas.tree import Tree, names_in
from slipfold.models.suggestion import suggest

SHOWN = 20
"""Names of each kind that a message lists."""


@dataclass(frozen=True)
class Formulas:
    """All formulas of a system, parsed."""

    rates: Mapping[str, Tree]  # by state
    named: Mapping[str, Tree]  # the table of formulas, each after those that it uses
    outputs: Mapping[str, Tree]  # by name
    contacts: Mapping[Path, Tree]  # of slips, normal forces and laws, by the entry
    period: Tree | None  # of the forcing; None for an autonomous system
    constant: frozenset[str]  # names of those in `named` that depend on parameters alone
    # By table and name: the entry that holds the text, and the text
    texts: Mapping[Path, tuple[Path, str]]


def parse_formulas(definition: Definition, source: Source) -> Formulas:
    """Parse the formulas of a system and look up the names in them."""
    texts: dict[Path, str] = {("formulas", name): text for name, text in definition.formulas}
    for item in definition.states:
        texts[("states", item.state.name)] = item.rate
    for output in definition.outputs:
        texts[("outputs", output.name)] = output.formula
    for contact in definition.contacts:
        texts |= contact.texts
    if definition.period is not None:
        texts[("forcing", "period")] = definition.period
    paths = {path: _path_of_text(path, source) for path in texts}
    trees: dict[Path, Tree] = {}
    for path, text in texts.items():
        try:
            trees[path] = parse_formula(text)
            _look_up(definition, path, trees[path])
        except FormulaError as error:
            raise source.formula_error(paths[path], text, error) from None
    named = _ordered({name: trees[("formulas", name)] for name, _ in definition.formulas}, source)
    constant = _constant(named, {item.name for item in definition.parameters})
    if definition.period is not None:
        what, path = "the forcing period", ("forcing", "period")
        _check_constant(definition, what, path, trees[path], texts[path], constant, source)
    contacts = {path: tree for path, tree in trees.items() if path[0] == "contacts"}
    _check_contacts(definition, contacts, texts, named, constant, source)
    return Formulas(
        rates={item.state.name: trees[("states", item.state.name)] for item in definition.states},
        named=named,
        outputs={item.name: trees[("outputs", item.name)] for item in definition.outputs},
        contacts=contacts,
        period=trees.get(("forcing", "period")),
        constant=constant,
        texts={path: (paths[path], text) for path, text in texts.items()},
    )


def _path_of_text(path: Path, source: Source) -> Path:
    """The entry that holds the text itself, which may be inside a table."""
    inner = (*path, "rate" if path[0] == "states" else "formula")
    return inner if source.places and inner in source.places else path


def _look_up(definition: Definition, path: Path, tree: Tree) -> None:
    states = [item.state.name for item in definition.states]
    parameters = [item.name for item in definition.parameters]
    formulas = [name for name, _ in definition.formulas]
    # Whether the period depends on states is checked later, through the named formulas as well.
    contacts = [name for item in definition.contacts for name in item.force_names]
    known = [*states, *parameters, *formulas, *contacts, *CONSTANTS]
    forced = definition.period is not None
    for name, place in names_in(tree).items():
        if name in known:
            continue
        if name == TIME and forced:
            if path != ("forcing", "period"):
                continue
            message = "the forcing period cannot depend on the time t; give it in parameters"
        elif name == TIME:
            message = (
                "t, the time, occurs in a system without forcing; add the table [forcing] with the "
                'period in seconds, e.g. period = "2*pi/W"'
            )
        else:
            message = _unknown(name, states, parameters, formulas, contacts, forced)
        raise FormulaError(message, place, len(name))


def _unknown(
    name: str,
    states: list[str],
    parameters: list[str],
    formulas: list[str],
    contacts: list[str],
    forced: bool,
) -> str:
    hint = {"e": "write exp(1) for Euler's number; ", "i": "there are no complex numbers; "}
    groups = {
        "the states": states,
        "the parameters": parameters,
        "the formulas": formulas,
        "the forces in contacts": contacts,
        "and": [*([TIME] if forced else []), *CONSTANTS],
    }
    known = ", ".join(f"{what} {_some(names)}" for what, names in groups.items() if names)
    near = suggest(name, [*states, *parameters, *formulas, *contacts])
    return f"there is no name {name[:80]!r}; {hint.get(name, '') or near}known are {known}"


def _some(names: list[str]) -> str:
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return ", ".join(names[:SHOWN]) + more


def _ordered(trees: Mapping[str, Tree], source: Source) -> dict[str, Tree]:
    """Sort named formulas so that each follows those that it uses."""
    uses = {name: [n for n in names_in(tree) if n in trees] for name, tree in trees.items()}
    done: dict[str, Tree] = {}
    for first in trees:
        # Depth first, with a stack of its own: a chain may be as long as the table.
        chain = [] if first in done else [first]
        while chain:
            missing = next((name for name in uses[chain[-1]] if name not in done), None)
            if missing is None:
                name = chain.pop()
                done[name] = trees[name]
            elif missing in chain:
                raise _circle([*chain[chain.index(missing) :], missing], source)
            else:
                chain.append(missing)
    return done


def _circle(names: list[str], source: Source) -> InputError:
    first = names[0]
    if len(names) == 2:
        message = f"the formula {first} uses itself; write it in states and parameters"
    else:
        message = (
            f"the formulas {' -> '.join(names)} use each other in a circle; write one of them in "
            "states and parameters"
        )
    return source.error(("formulas", first), message, key=True)


def _constant(named: Mapping[str, Tree], parameters: set[str]) -> frozenset[str]:
    found: set[str] = set()
    for name, tree in named.items():
        if names_in(tree).keys() <= parameters | found | CONSTANTS.keys():
            found.add(name)
    return frozenset(found)


def _check_constant(
    definition: Definition,
    what: str,
    path: Path,
    tree: Tree,
    text: str,
    constant: frozenset[str],
    source: Source,
) -> None:
    """Refuse a formula that is not of parameters alone."""
    fixed = {item.name for item in definition.parameters} | constant | CONSTANTS.keys()
    states = {item.state.name for item in definition.states}
    for name, place in names_in(tree).items():
        if name not in fixed:
            kind = "the state" if name in states else "the time" if name == TIME else "the formula"
            message = (
                f"{what} depends on {kind} {name}, but must be known before the motion is; give it "
                "in parameters"
            )
            raise source.formula_error(path, text, FormulaError(message, place, len(name)))


def _check_contacts(
    definition: Definition,
    trees: Mapping[Path, Tree],
    texts: Mapping[Path, str],
    named: Mapping[str, Tree],
    constant: frozenset[str],
    source: Source,
) -> None:
    """Refuse laws whose parameters vary, slips and normal forces that depend on friction."""
    forces = {name for item in definition.contacts for name in item.force_names}
    for name, tree in named.items():
        if names_in(tree).keys() & forces:
            forces.add(name)
    for path, tree in trees.items():
        if path[2] == "friction":
            what = f"{path[3]} of the contact {path[1]}"
            _check_constant(definition, what, path, tree, texts[path], constant, source)
            continue
        for name, place in names_in(tree).items():
            if name in forces:
                message = (
                    f"the {path[2]} of {path[1]} depends on {name}, a force in a contact; write it "
                    "in states and parameters"
                )
                raise source.formula_error(
                    path, texts[path], FormulaError(message, place, len(name))
                )
