"""All that the equations of a structure depend on, checked for form."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from slipfold.errors import InputError, about
from slipfold.models.quantities import Parameter, check_state_name
from slipfold.models.structures.component import NAME, Component, Direction, as_direction, brief
from slipfold.models.structures.contacts import FrictionContact, NormalLoad
from slipfold.models.structures.cyclic import CyclicSymmetry, Sectors
from slipfold.models.structures.damping import Damping
from slipfold.models.structures.forcing import (
    BaseAcceleration,
    BaseMotion,
    HarmonicForce,
    MultiHarmonicForce,
    TabulatedForce,
)
from slipfold.models.structures.matrices import (
    UNITS,
    Matrix,
    as_matrix,
    check_mass,
    lengths_of,
    require_skew,
    require_symmetric,
)
from slipfold.models.structures.matrix_files import read_names
from slipfold.models.structures.reduction import Reduction
from slipfold.models.structures.springs import (
    CubicSpring,
    GapSpring,
    GeometricSpring,
    LinearSpring,
    PolynomialSpring,
    TabulatedSpring,
)
from slipfold.models.units import parse_quantity
from slipfold.text import listed

COMPONENTS: dict[str, tuple[type[Component], ...]] = {
    "elements": (
        LinearSpring,
        CubicSpring,
        PolynomialSpring,
        GapSpring,
        TabulatedSpring,
        GeometricSpring,
    ),
    "contacts": (FrictionContact,),
    "forcing": (HarmonicForce, MultiHarmonicForce, TabulatedForce, BaseMotion, BaseAcceleration),
}
"""Classes of components by the argument that takes them."""

MAX_CONTACTS = 32
"""Most friction contacts that are given: each has equations to compile and outputs to evaluate."""


@dataclass(frozen=True)
class Definition:
    """A structure without its parameter values."""

    # Mass and stiffness matrix, shape (n, n), in kg and N/m
    M: Matrix
    C: Matrix | Damping | None  # damping matrix in N s/m, shape (n, n); a rule; None for no damping
    K: Matrix
    # Gyroscopic matrix in N s/m, skew-symmetric, and circulatory one in N/m, shape (n, n); or None
    G: Matrix | None
    H: Matrix | None
    variables: tuple[Parameter, ...]  # parameters in the formulas that multiply matrices
    names: tuple[str, ...]  # names of the n degrees of freedom
    reduction: Reduction | None  # how it is reduced; None if not
    cyclic: CyclicSymmetry | None  # what the matrices are a sector of; None for a whole structure
    # What acts on it, with default values
    elements: tuple[Component, ...]
    contacts: tuple[FrictionContact, ...]
    forcing: tuple[Component, ...]
    length_scale: float  # displacements of the model are in units of it, in m
    watch: tuple[tuple[str, Direction], ...]  # name and direction of displacements that are outputs
    # Short name, and a line that says what it is
    name: str
    title: str

    @property
    def components(self) -> tuple[Component, ...]:
        """Elements, contacts and forcing."""
        return (*self.elements, *self.contacts, *self.forcing)

    @cached_property
    def repeated(self) -> Definition:
        """The structure of all sectors that repeat; itself without cyclic symmetry."""
        if self.cyclic is None:
            return self
        sectors = Sectors(self.cyclic, self.names)
        matrices = {key: getattr(self, key) for key in ("M", "C", "K", "G", "H")}
        changes: dict[str, Any] = {
            key: sectors.matrix(matrix)
            for key, matrix in matrices.items()
            if isinstance(matrix, Matrix)
        }
        for key in COMPONENTS:
            with about(key):
                changes[key] = sectors.components(getattr(self, key))
        reduction: Any = self.reduction
        if reduction is not None and reduction.boundary:
            with about("reduction", "boundary"):
                held = (sectors.name(name, sector) for sector in range(sectors.count)
                        for name in reduction.boundary)  # fmt: skip
                changes["reduction"] = replace(reduction, boundary=tuple(held))
        watch = tuple((name, sectors.direction(one, 0)) for name, one in self.watch)
        return replace(self, **changes, names=sectors.names, watch=watch, cyclic=None)

    @cached_property
    def massless(self) -> tuple[str, ...]:
        """Names of the degrees of freedom without mass, which are condensed statically."""
        return tuple(self.names[place] for place in self.M.empty)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was done to the input, one sentence each."""
        matrices = {name: getattr(self, name) for name in ("M", "C", "K", "G")}
        notes = [
            f"{name} was given by its {matrix.completed} triangle and is completed"
            for name, matrix in matrices.items()
            if isinstance(matrix, Matrix) and matrix.completed
        ]
        if units := self.K.units:
            turned = [name for name in self.names if lengths_of(units, [name]) == 1]
            which = f"; rotations are {listed(turned)}" if turned else ", all along lengths"
            notes.append(f"matrices were given in {units} and are converted to SI units{which}")
        if self.cyclic is not None:
            notes.append(self.cyclic.note)
        for along, count in Counter(one.along for one in self.contacts).items():
            if count > 1:
                both = listed([one.key for one in self.contacts if one.along == along])
                notes.append(f"contacts along one direction, whose forces add up: {both}")
        if massless := self.repeated.massless:
            count, named = len(massless), listed(massless)
            notes.append(f"without mass, condensed statically: {count} ({named})")
        return tuple(notes)


def define(given: Mapping[str, Any]) -> tuple[Definition, dict[str, float]]:
    """Check the arguments of a structure, and part them from the values of their parameters."""
    matrices = _matrices(given)
    with about("structure", "names"):
        names = _checked_names(given["names"], matrices["M"].size)
    matrices = _in_si(matrices, given, names)
    mass, damping = matrices["M"], matrices["C"]
    if not isinstance(given["M"], Matrix):  # a matrix that is frozen already was checked before
        with about("structure", "M"):
            check_mass(mass, names)
    reduction = given["reduction"]
    with about("reduction"):
        if reduction is not None and not isinstance(reduction, Reduction):
            raise InputError(
                f"reduction = {brief(reduction)} is none; give one such as "
                'FreeInterface(up_to="1 kHz", accuracy=1e-3)'
            )
    cyclic = given["cyclic"]
    known = names
    with about("cyclic"):
        if cyclic is not None:
            if not isinstance(cyclic, CyclicSymmetry):
                raise InputError(
                    f"cyclic = {brief(cyclic)} is none; give one such as "
                    'CyclicSymmetry(sectors=24, engine_order=5, low="a", high="b")'
                )
            known = (*Sectors(cyclic, names).names, *cyclic.high)
    components = {key: _checked_components(key, given[key], known) for key in COMPONENTS}
    values: dict[str, float] = dict(damping.values) if isinstance(damping, Damping) else {}
    kinds: dict[str, Any] = {}
    for key, items in _named_apart(components).items():
        kinds[key] = tuple(item.kind for item in items)
        for item in items:
            values |= _values_beside(item, values)
    definition = Definition(
        **{**matrices, "C": damping.kind if isinstance(damping, Damping) else damping},
        variables=_checked_variables(given["variables"]),
        names=names,
        reduction=reduction,
        cyclic=cyclic,
        **kinds,
        length_scale=_checked_length(given["length_scale"]),
        watch=_checked_watch(given["watch"], known),
        name=_checked_line(given, "name") or "structure",
        title=_checked_line(given, "title"),
    )
    if mass.terms and (base := next((one for one in kinds["forcing"] if one.inertial), None)):
        with about("forcing"):
            raise InputError(
                f"a {base.title} acts with the masses, and M depends on parameters; give forces "
                "that depend on them, or a constant M"
            )
    whole = definition.repeated
    if whole.reduction is not None:
        with about("reduction"):
            whole.reduction._fits(whole.M, whole.K, whole.names)
    if whole.massless:
        _check_massless(whole)
    return definition, values


def _in_si(
    matrices: Mapping[str, Any], given: Mapping[str, Any], names: tuple[str, ...]
) -> dict[str, Any]:
    """Return the matrices in SI units; those of another structure are already."""
    units = "SI" if given["units"] is None else given["units"]
    if not isinstance(units, str) or units not in UNITS:
        with about("structure", "units"):
            raise InputError(f"units = {brief(units)} is not known; give {', '.join(UNITS)}")
    if units == "SI":
        return dict(matrices)
    lengths = lengths_of(units, names)
    return {
        key: matrix.converted(units, lengths)
        if isinstance(matrix, Matrix) and not isinstance(given[key], Matrix)
        else matrix
        for key, matrix in matrices.items()
    }


def _check_massless(item: Definition) -> None:
    """Refuse what needs the motion of degrees of freedom without mass, which forces alone give."""
    empty = item.M.empty
    first = item.names[empty[0]]
    with about("structure", "K"):
        why = f"the static condensation of {first}, which has no mass, needs a symmetric one"
        require_symmetric(item.K, "K", why)
        loose = np.intersect1d(empty, item.K.empty)
        if len(loose):
            raise InputError(
                f"{item.names[loose[0]]} has neither mass nor stiffness; give it one of them, or "
                "leave it out of the matrices"
            )
    for key in ("M", "C", "G", "H", "K"):
        matrix = getattr(item, key)
        if not isinstance(matrix, Matrix):
            continue
        acting = matrix.parts[key in "MK" :]
        reached = [place for place in empty if any(place in part.rows for part in acting)]
        if reached:
            with about("structure", key):
                raise InputError(
                    f"{key} acts on {item.names[reached[0]]}, which has no mass; give it a mass, "
                    f"or leave it out of {key}"
                )
    loaded = _massless_in(item.forcing, item)
    for key, parts in (("elements", item.elements), ("contacts", item.contacts)):
        if held := _massless_in(parts, item):
            with about(key):
                raise InputError(
                    f"{key} act at {held}, which has no mass; give it a mass, or let them act at "
                    "one that has"
                )
    watched = (name for _, direction in item.watch for name, _ in direction.weights)
    shown = next((name for name in watched if name in item.massless), "")
    if loaded and shown:
        with about("watch"):
            raise InputError(
                f"{shown} has no mass and moves statically with the force at {loaded}, which has "
                f"none either; watch a degree of freedom with mass, or give {loaded} a mass"
            )


def _massless_in(parts: Iterable[Component], item: Definition) -> str:
    """Return the first degree of freedom without mass on which components act."""
    held = set(item.massless)
    directions = (one for part in parts if not part.inertial for one in part._directions if one)
    return next((name for one in directions for name, _ in one.weights if name in held), "")


_PARTED = (
    "put its antisymmetric part, (K - K^T)/2, into H, or give "
    'triangles = "whole" to take K as it is'
)


def _matrices(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the matrices by name, which fit each other."""
    if given["K"] is None:
        raise InputError("the structure has no stiffness matrix; give K, of zeros if it has none")
    half = given["triangles"]
    if half is not None and not (isinstance(half, str) and half in ("symmetric", "whole")):
        with about("structure", "triangles"):
            raise InputError(f'triangles = {brief(half)} is not known; give "symmetric" or "whole"')
    matrices: dict[str, Any] = {}
    for key in ("M", "K", "C", "G", "H"):
        value = given[key]
        with about("structure", key):
            if key not in "MK" and (value is None or isinstance(value, Damping)):
                matrices[key] = value
                continue
            matrices[key] = as_matrix(value, key, half)
            if matrices[key].size != matrices["M"].size:
                raise InputError(
                    f"{key} has {matrices[key].size} rows and M has {matrices['M'].size}; give "
                    "matrices of one size"
                )
            if key == "G":
                require_skew(matrices[key], key)
            if key == "K" and half != "whole" and not isinstance(value, Matrix):
                require_symmetric(matrices[key], key, _PARTED)
    damping = given["C"]
    if isinstance(damping, Damping):
        with about("structure", "K"):
            why = f"{damping.title} needs a symmetric one, so give C as a matrix instead"
            require_symmetric(matrices["K"], "K", why)
    return matrices


def _checked_variables(given: Any) -> tuple[Parameter, ...]:
    """Return the described parameters in the formulas that multiply matrices."""
    variables = tuple(_iterated(given))
    for item in variables:
        if not isinstance(item, Parameter):
            with about("variables"):
                raise InputError(
                    f"variables has {brief(item)}, which is no parameter; give e.g. "
                    'Parameter("omega", 100.0, "rad/s", "rotor speed")'
                )
    return variables


def _checked_line(given: Mapping[str, Any], key: str) -> str:
    value = given[key]
    if not isinstance(value, str) or not value.isprintable():
        raise InputError(f"{key} = {brief(value)} is not a line of text; give one")
    return value


def _checked_names(names: Any, size: int) -> tuple[str, ...]:
    """Return the names of the degrees of freedom."""
    if names is None:
        return tuple(f"q{position}" for position in range(1, size + 1))
    if isinstance(names, Path) or (isinstance(names, str) and names.endswith(".csv")):
        names = read_names(Path(names))
    given = tuple(_iterated(names.split() if isinstance(names, str) else names))
    if len(given) != size:
        raise InputError(
            f"{len(given)} names are given for {size} degrees of freedom; give one a row of M"
        )
    for name in given:
        if not isinstance(name, str) or not NAME.fullmatch(name):
            raise InputError(
                f"{brief(name)} cannot name a degree of freedom; give at most 60 letters, "
                "digits and _, a letter first"
            )
        check_state_name(name, "a degree of freedom")
    if len(set(given)) < size:
        name = next(name for name, count in Counter(given).items() if count > 1)
        raise InputError(f"two degrees of freedom are called {name}; rename one")
    return given


def _checked_components(key: str, items: Any, names: tuple[str, ...]) -> tuple[Component, ...]:
    """Return elements, contacts or forces, whose directions are in the structure."""
    given = (items,) if isinstance(items, Component) else tuple(_iterated(items))
    if key == "contacts" and len(given) > MAX_CONTACTS:
        with about(key):
            raise InputError(
                f"{len(given)} friction contacts are more than {MAX_CONTACTS}; join "
                "neighbors, along the mean of their displacements, or give one of equal sectors"
            )
    for number, item in enumerate(given):
        if not isinstance(item, COMPONENTS[key]):
            known = ", ".join(cls.__name__ for cls in COMPONENTS[key])
            raise InputError(f"{brief(item)} is not known among {key}; give {known}")
        with about(key, str(number)):
            _check_directions(item, names)
    return given


def _check_directions(part: Any, names: tuple[str, ...]) -> None:
    """Refuse directions along degrees of freedom that the structure does not have."""
    for item in fields(part):
        value = getattr(part, item.name)
        for direction in value if isinstance(value, tuple) else (value,):
            with about(item.name):
                if isinstance(direction, Direction):
                    direction.vector(names)
                elif isinstance(direction, NormalLoad):
                    _check_directions(direction, names)


def _named_apart(
    components: Mapping[str, tuple[Component, ...]],
) -> dict[str, tuple[Component, ...]]:
    """Name components by where they act, where two without a name would share a parameter."""
    everything = [item for items in components.values() for item in items]
    counts = Counter(name for item in everything for name in item.public_names)

    def apart(item: Component) -> Component:
        shared = not item.name and any(counts[name] > 1 for name in item.public_names)
        return replace(item, name=item.location) if shared else item

    return {key: tuple(map(apart, items)) for key, items in components.items()}


def _values_beside(item: Component, others: Mapping[str, float]) -> dict[str, float]:
    """Return the values of a component by the structure's names, beside those of its group."""
    values = item.named_values
    for parameter in item.named_parameters:
        name, value = parameter.name, values[parameter.name]
        if others.get(name, value) in (value, parameter.default):
            continue
        if value != parameter.default:
            raise InputError(
                f"{name} is {others[name]:g} in one component of a group and {value:g} in "
                "another; give each a name of its own, or one value to all"
            )
        values[name] = others[name]
    return values


def _iterated(items: Any) -> Iterable[Any]:
    return items if isinstance(items, Iterable) and not isinstance(items, str) else (items,)


def _checked_length(value: Any) -> float:
    """Return the unit of displacements in m."""
    with about("structure", "length_scale"):
        length = parse_quantity(value, "m", "length_scale")
        if not 0 < length < float("inf"):
            raise InputError(
                f"length_scale = {length:g} m; give a finite length > 0, about the amplitude"
            )
        return length


def _checked_watch(watch: Any, names: tuple[str, ...]) -> tuple[tuple[str, Direction], ...]:
    """Return the displacements that are outputs."""
    given = {} if watch is None else watch
    if isinstance(watch, tuple) and all(
        isinstance(part, tuple) and len(part) == 2 for part in watch
    ):
        given = dict(watch)  # those of another structure
    if not isinstance(given, Mapping):
        raise InputError(
            f"watch = {brief(watch)} is not a mapping; give directions by the name of the output, "
            'such as {"u_tip": "tip"}'
        )
    result = []
    for name, item in given.items():
        with about("watch", str(name)):
            if not isinstance(name, str) or not NAME.fullmatch(name):
                raise InputError(
                    f"{brief(name)} cannot name an output; give letters, digits and _, a letter "
                    "first"
                )
            direction = as_direction(item, f"displacement {name}")
            direction.vector(names)
            result.append((name, direction))
    return tuple(result)
