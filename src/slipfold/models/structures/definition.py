"""All that the equations of a structure depend on, checked for form."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from slipfold.errors import InputError
from slipfold.models.quantity import parse_quantity
from slipfold.models.structures.component import NAME, Component, Direction, as_direction, shown
from slipfold.models.structures.contacts import FrictionContact
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

ELEMENTS = (LinearSpring, CubicSpring, PolynomialSpring, GapSpring, GeometricSpring)
"""Classes of what may be among the elements."""

CONTACTS = (FrictionContact,)
"""Classes of what may be among the contacts."""

FORCING = (HarmonicForce, MultiHarmonicForce, TabulatedForce, BaseMotion)
"""Classes of what may be among the forcing."""

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
    half = checked_triangles(triangles)
    mass, stiffness = as_matrix(M, "M", half), as_matrix(K, "K", half)
    damping = C if C is None or isinstance(C, Damping) else as_matrix(C, "C", half)
    checked_sizes(mass, C=damping, K=stiffness)
    if isinstance(damping, Damping):
        require_symmetric(
            stiffness, "K", f"{damping.title} needs a symmetric one, so give C as a matrix instead"
        )
    if reduction is not None and not isinstance(reduction, Reduction):
        raise InputError(
            f"reduction = {shown(reduction)} is none; give ModalReduction(modes=5) or "
            'CraigBampton(["tip"], modes=5)'
        )
    given_names = checked_names(names, mass.size)
    if not isinstance(M, Matrix):  # a matrix that is frozen already was checked before
        check_mass(mass, given_names)
    several = [
        _checked(items, classes, what)
        for items, classes, what in zip(
            components,
            (ELEMENTS, CONTACTS, FORCING),
            ("elements", "contacts", "forcing"),
            strict=True,
        )
    ]
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
        checked_length(length_scale),
        checked_watch(watch),
        _checked_line(title[0], "name") or "structure",
        _checked_line(title[1], "title"),
    )
    return definition, values


def checked_sizes(mass: Matrix, **others: Any) -> None:
    """Raise unless matrices are of one size."""
    for name, matrix in others.items():
        if isinstance(matrix, Matrix) and matrix.size != mass.size:
            raise InputError(
                f"{name} has {matrix.size} rows and M has {mass.size}; give matrices of one size"
            )


def checked_triangles(triangles: Any) -> str | None:
    """Return what a matrix stands for that has one entry of each mirrored pair."""
    if triangles is None or (isinstance(triangles, str) and triangles in TRIANGLES):
        return triangles
    known = " or ".join(f'"{item}"' for item in TRIANGLES)
    raise InputError(f"triangles = {shown(triangles)} is not known; give {known}")


def _checked_line(value: Any, what: str) -> str:
    if not isinstance(value, str) or not value.isprintable():
        raise InputError(f"{what} = {shown(value)} is not a line of text; give one")
    return value


def checked_names(names: Any, size: int) -> tuple[str, ...]:
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
            replace(item, name=item.place)
            if not item.name and any(counts[name] > 1 for name in item.public_names)
            else item
            for item in items
        )
        for items in several
    ]


def _iterated(items: Any) -> Iterable[Any]:
    return items if isinstance(items, Iterable) and not isinstance(items, str) else (items,)


def checked_length(value: Any) -> float:
    """Return the unit of displacements in m."""
    length = parse_quantity(value, "m", "length_scale")
    if not 0 < length < float("inf"):
        raise InputError(
            f"length_scale = {length:g} m; give a finite length > 0, about that of the motion"
        )
    return length


def checked_watch(watch: Any) -> tuple[tuple[str, Direction], ...]:
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
    for name in watch:
        if not isinstance(name, str) or not NAME.fullmatch(name):
            raise InputError(
                f"{shown(name)} cannot name an output; give letters, digits and _, a letter first"
            )
    return tuple((name, as_direction(item, f"displacement {name}")) for name, item in watch.items())
