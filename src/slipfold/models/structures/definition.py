"""All that the equations of a structure depend on, checked for form."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

from slipfold.errors import InputError, about
from slipfold.models.structures.component import NAME, Component, Direction, as_direction, shown
from slipfold.models.structures.contacts import FrictionContact, NormalLoad
from slipfold.models.structures.damping import Damping
from slipfold.models.structures.forcing import (
    BaseMotion,
    HarmonicForce,
    MultiHarmonicForce,
    TabulatedForce,
)
from slipfold.models.structures.matrices import (
    TRIANGLES,
    Matrix,
    as_matrix,
    check_mass,
    require_symmetric,
)
from slipfold.models.structures.reduction import Reduction
from slipfold.models.structures.springs import (
    CubicSpring,
    GapSpring,
    GeometricSpring,
    LinearSpring,
    PolynomialSpring,
)
from slipfold.models.units import parse_quantity

ELEMENTS = (LinearSpring, CubicSpring, PolynomialSpring, GapSpring, GeometricSpring)
"""Classes of elements."""

CONTACTS = (FrictionContact,)
"""Classes of contacts."""

FORCING = (HarmonicForce, MultiHarmonicForce, TabulatedForce, BaseMotion)
"""Classes of forcing."""

_SYMBOLS = ("c_", "p_", "carried_")
"""How the compiled equations begin the names of coefficients, parameters and variations."""


@dataclass(frozen=True)
class Definition:
    """A structure without its parameter values."""

    # Mass and stiffness matrix, shape (n, n), in kg and N/m
    M: Matrix
    C: Matrix | Damping | None  # damping matrix in N s/m, shape (n, n); a rule; None for no damping
    K: Matrix
    names: tuple[str, ...]  # names of the n degrees of freedom
    reduction: Reduction | None  # how it is reduced; None if not
    # What acts on it, with default values
    elements: tuple[Component, ...]
    contacts: tuple[FrictionContact, ...]
    forcing: tuple[Component, ...]
    length_scale: float  # displacements of the model are in units of it, in m
    watch: tuple[tuple[str, Direction], ...]  # name and direction of displacements that are outputs
    # Short name, and a line that says what it is
    name: str = "structure"
    title: str = ""

    @property
    def components(self) -> tuple[Component, ...]:
        """Elements, contacts and forcing."""
        return (*self.elements, *self.contacts, *self.forcing)


def define(
    M: Any,
    C: Any,
    K: Any,
    names: Any,
    reduction: Any,
    components: tuple[Any, Any, Any],
    length_scale: Any,
    watch: Any,
    title: tuple[Any, Any] = ("structure", ""),
    triangles: Any = None,
) -> tuple[Definition, dict[str, float]]:
    """Check the arguments of a structure, and part them from the values of their parameters."""
    if K is None:
        raise InputError("the structure has no stiffness matrix; give K, of zeros if it has none")
    mass, stiffness, damping = _matrices(M, C, K, triangles)
    if reduction is not None and not isinstance(reduction, Reduction):
        raise InputError(
            f"reduction = {shown(reduction)} is none; give ModalReduction(modes=5) or "
            'CraigBampton(["tip"], modes=5)'
        )
    with about("structure", "names"):
        given_names = _checked_names(names, mass.size)
    if not isinstance(M, Matrix):  # a matrix that is frozen already was checked before
        with about("structure", "M"):
            check_mass(mass, given_names)
    if reduction is not None:
        with about("reduction"):
            reduction.fits(mass, stiffness, given_names)
    several = []
    for what, classes, items in zip(
        ("elements", "contacts", "forcing"), (ELEMENTS, CONTACTS, FORCING), components, strict=True
    ):
        several.append(_checked(items, classes, what))
        for number, item in enumerate(several[-1]):
            with about(what, str(number)):
                _check_directions(item, given_names)
    watched = _checked_watch(watch)
    for name, direction in watched:
        with about("watch", name):
            direction.vector(given_names)
    several = _named_apart(several)
    values: dict[str, float] = dict(damping.values) if isinstance(damping, Damping) else {}
    for component in (item for items in several for item in items):
        values |= component.named_values
    kinds: list[Any] = [tuple(item.kind for item in items) for items in several]
    definition = Definition(
        mass,
        damping.kind if isinstance(damping, Damping) else damping,
        stiffness,
        given_names,
        reduction,
        kinds[0],
        kinds[1],
        kinds[2],
        _checked_length(length_scale),
        watched,
        _checked_line(title[0], "name") or "structure",
        _checked_line(title[1], "title"),
    )
    return definition, values


def _matrices(M: Any, C: Any, K: Any, triangles: Any) -> tuple[Matrix, Matrix, Any]:
    """Return mass, stiffness and damping, which fit each other."""
    with about("structure", "triangles"):
        half = _checked_triangles(triangles)
    matrices: dict[str, Any] = {}
    for key, value in (("M", M), ("K", K), ("C", C)):
        with about("structure", key):
            no_matrix = key == "C" and (value is None or isinstance(value, Damping))
            matrices[key] = value if no_matrix else as_matrix(value, key, half)
            _check_size(key, matrices[key], matrices["M"].size)
    mass, stiffness, damping = (matrices[key] for key in ("M", "K", "C"))
    if isinstance(damping, Damping):
        with about("structure", "K"):
            require_symmetric(
                stiffness,
                "K",
                f"{damping.title} needs a symmetric one, so give C as a matrix instead",
            )
    return mass, stiffness, damping


def _check_size(name: str, matrix: Any, size: int) -> None:
    if isinstance(matrix, Matrix) and matrix.size != size:
        raise InputError(
            f"{name} has {matrix.size} rows and M has {size}; give matrices of one size"
        )


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


def _checked_triangles(triangles: Any) -> str | None:
    """Return what a matrix stands for that has one entry of each mirrored pair."""
    if triangles is None or (isinstance(triangles, str) and triangles in TRIANGLES):
        return triangles
    known = " or ".join(f'"{item}"' for item in TRIANGLES)
    raise InputError(f"triangles = {shown(triangles)} is not known; give {known}")


def _checked_line(value: Any, what: str) -> str:
    if not isinstance(value, str) or not value.isprintable():
        raise InputError(f"{what} = {shown(value)} is not a line of text; give one")
    return value


def _checked_names(names: Any, size: int) -> tuple[str, ...]:
    """Return the names of the degrees of freedom."""
    if names is None:
        return tuple(f"q{place}" for place in range(1, size + 1))
    if isinstance(names, str):
        names = names.split()
    given = tuple(_iterated(names))
    if len(given) != size:
        raise InputError(
            f"{len(given)} names are given for {size} degrees of freedom; give one a row of M"
        )
    for name in given:
        if not isinstance(name, str) or not NAME.fullmatch(name):
            raise InputError(
                f"{shown(name)} cannot name a degree of freedom; give at most 60 letters, "
                "digits and _, a letter first"
            )
        if name == "phase" or name.startswith(_SYMBOLS):
            raise InputError(
                f"a degree of freedom cannot be called {name}: phase and names that begin with "
                f"{', '.join(_SYMBOLS)} are used inside; call it e.g. q_{name}"
            )
        if given.count(name) > 1:
            raise InputError(f"two degrees of freedom are called {name}; rename one")
    return given


def _checked(items: Any, classes: tuple[type, ...], what: str) -> tuple[Component, ...]:
    given: Sequence[Any] = (items,) if isinstance(items, Component) else tuple(_iterated(items))
    for item in given:
        if not isinstance(item, classes):
            known = ", ".join(cls.__name__ for cls in classes)
            raise InputError(f"{shown(item)} is not known among {what}; give {known}")
    return tuple(given)


def _named_apart(several: list[tuple[Component, ...]]) -> list[tuple[Component, ...]]:
    """Name components by where they act, where two without a name would share a parameter."""
    counts = Counter(name for items in several for item in items for name in item.public_names)
    return [
        tuple(
            replace(item, name=item.location)
            if not item.name and any(counts[name] > 1 for name in item.public_names)
            else item
            for item in items
        )
        for items in several
    ]


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


def _checked_watch(watch: Any) -> tuple[tuple[str, Direction], ...]:
    """Return the displacements that are outputs."""
    if isinstance(watch, tuple):
        return watch
    if watch is None:
        return ()
    if not isinstance(watch, Mapping):
        raise InputError(
            f"watch = {shown(watch)} is not a mapping; give directions by the name of the output, "
            'such as {"u_tip": "tip"}'
        )
    result = []
    for name, item in watch.items():
        with about("watch", str(name)):
            if not isinstance(name, str) or not NAME.fullmatch(name):
                raise InputError(
                    f"{shown(name)} cannot name an output; give letters, digits and _, a letter "
                    "first"
                )
            result.append((name, as_direction(item, f"displacement {name}")))
    return tuple(result)
