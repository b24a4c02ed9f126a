"""Models from equations as text: in Python, or from a TOML file."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.models.definitions.source import Source, source_of_file, source_of_text
from slipfold.models.formulas.values import as_symbol
from slipfold.models.friction.contact import Contact
from slipfold.models.model import Model
from slipfold.models.quantities import Expression, Output, Symbols
from slipfold.writing import as_path

if TYPE_CHECKING:
    from slipfold.models.definitions.equations import SystemEquations
    from slipfold.models.definitions.system_file import WatchedValue


_TABLES = (
    *("name", "title", "sizes", "parameters", "formulas", "states", "contacts", "forcing"),
    *("outputs", "limits", "events"),
)
"""Arguments of the constructor that are tables or entries of the definition."""


class System(Model):
    """A model made from equations that are written as text.

    The tables are those of a TOML file, see `from_toml`. A formula has numbers, names,
    ``+ - * / ^``, parentheses, ``pi``, the time ``t`` in seconds, and the functions ``sin cos tan
    asin acos atan atan2 sinh cosh tanh asinh acosh atanh exp log sqrt erf sigmoid exprel``; here
    ``exprel(x)`` is ``(exp(x) - 1)/x``, and 1 at zero, so that ``x/(1 - exp(-x))`` is
    ``1/exprel(-x)``. It is parsed by a grammar of its own and never run as Python.

    Parameters
    ----------
    definition
        The system as one TOML text or one mapping of tables, instead of the tables below.
    name, title
        Short name, and one line that says what it is.
    sizes
        Whole numbers by name, for ranges of indices.
    parameters
        Value by name, or a table ``{"value": 0.9, "unit": "rad/s", "min": 0, "max": 5, "doc":
        "..."}``; ``above`` and ``below`` are bounds that are excluded, ``symbol`` is for figures.
    formulas
        Named formulas that others may use.
    states
        Formula of the rate per second by name, or a table ``{"rate": "...", "unit", "doc",
        "label", "start": 0, "scale": 1}``; the scale, a typical size, is estimated if not given.
        With ``"angle": True`` it is an angle in rad: orbits close up to revolutions of it.
    contacts
        Table by name: ``{"slip": "Vd - v", "normal": "N", "friction": "Coulomb"}``, dry friction
        that may stick. Its force stands under the name in formulas; it acts along the slip, which
        is linear in the states, and in a plane has two formulas and forces with x and y behind the
        name. The law is a `FrictionLaw` or a table, ``{"law": "Coulomb", "mu_s": 0.5, "mu_k":
        "mu"}``, of numbers and formulas in parameters. The name with ``_normal`` is the normal
        force, which vanishes where the contact opens.
    forcing
        ``{"period": "2*pi/W"}`` in seconds; ``"amplitude"`` names the parameter that switches the
        forcing off. None for an autonomous system, which gets a parameter ``duration``.
    outputs
        Formula by name, or a table ``{"formula": "...", "unit", "doc", "label"}``.
    limits
        Table by name: the model holds while ``output`` stays above ``bound``; ``reason`` is the
        sentence to show, with ``{value}`` for the minimum of the output.
    events
        Table by name: ``{"output": "q", "value": 1, "measure": "max", "stop": false}``.
    **values
        Parameter values that differ from the defaults: numbers in SI units, or text with a unit.

    Examples
    --------
    >>> duffing = System(
    ...     name="Duffing",
    ...     parameters={"W": 0.9, "F": 0.18},
    ...     states={"q": "v", "v": "F*cos(W*t) - 0.05*v - q - 0.1*q^3"},
    ...     forcing={"period": "2*pi/W"},
    ... )
    >>> duffing.replace(W=1.1)
    System('Duffing', W=1.1)

    A chain of fifty masses between two walls; elements are called x1, x2, ...:

    >>> chain = System(
    ...     name="chain",
    ...     sizes={"n": 50},
    ...     parameters={"k": 1.0, "F": 0.1, "W": 0.5},
    ...     formulas={"x[0]": "0", "x[n+1]": "0"},
    ...     states={
    ...         "x[i=1:n]": "v[i]",
    ...         "v[1]": "k*(x[0] - 2*x[1] + x[2]) + F*cos(W*t)",
    ...         "v[i=2:n]": "k*(x[i-1] - 2*x[i] + x[i+1]) - 0.1*v[i]",
    ...     },
    ...     forcing={"period": "2*pi/W"},
    ...     outputs={"energy": "sum(i=1:n, v[i]^2 + k*(x[i] - x[i-1])^2)/2"},
    ... )
    >>> len(chain.states), chain.states[49].name
    (100, 'x50')
    """

    def __init__(
        self,
        definition: str | Mapping[str, Any] | None = None,
        *,
        name: str | None = None,
        title: str | None = None,
        sizes: Mapping[str, int] | None = None,
        parameters: Mapping[str, Any] | None = None,
        formulas: Mapping[str, Any] | None = None,
        states: Mapping[str, Any] | None = None,
        contacts: Mapping[str, Any] | None = None,
        forcing: Mapping[str, Any] | None = None,
        outputs: Mapping[str, Any] | None = None,
        limits: Mapping[str, Any] | None = None,
        events: Mapping[str, Any] | None = None,
        **values: float | str,
    ) -> None:
        arguments = locals()
        given = {key: arguments[key] for key in _TABLES if arguments[key] is not None}
        equations = _equations_of(definition, given)
        system = equations.definition
        self._take(
            _equations=equations,
            name=system.name,
            title=system.title,
            states=equations.states,
            parameters=equations.parameters,
            limits=equations.limits,
            forcing_amplitude=system.forcing.amplitude if system.forcing else None,
        )
        super().__init__(**values)

    @classmethod
    def from_toml(cls, source: str | Path) -> System:
        """Read a system from a TOML file or text.

        Parameters
        ----------
        source
            Path of a file, or the text itself if it has an equals sign or several lines.

        Raises
        ------
        InputError
            If the file cannot be read, or something in it cannot be used: with line and column.

        Examples
        --------
        >>> text = '''
        ... name = "decay"
        ... [parameters]
        ... k = { value = 2.0, unit = "1/s", min = 0 }
        ... [states]
        ... q = "-k*q"
        ... '''
        >>> System.from_toml(text).forced
        False
        """
        if isinstance(source, str) and ("\n" in source or "=" in source):
            return cls._read(source_of_text(source), "system")
        path = as_path(source, "model.toml")
        return cls._read(source_of_file(path), path.stem)

    @classmethod
    def _read(cls, source: Source, name: str) -> System:
        # Only systems of equations need pydantic, which takes a while to load.
        from slipfold.models.definitions.checked_system import build_system

        return cls(build_system(source, name).text)

    def to_toml(self) -> str:
        """Return the definition as a TOML text; `from_toml` makes the same system of it.

        Parameter values are the defaults of the definition, not those of this model.
        """
        return self._equations.text

    @property
    def structure(self) -> Mapping[str, Hashable]:
        """The definition as a TOML text."""
        return {"definition": self._equations.text}

    @property
    def forced(self) -> bool:
        """Whether there is a forcing; if not, there is a parameter ``duration`` in seconds."""
        return self._equations.cycle is not None

    @property
    def start(self) -> Array:
        """State from which trajectories and searches start, shape (n_states,)."""
        return np.array([item.start for item in self._equations.definition.states.values()])

    @property
    def events(self) -> tuple[WatchedValue, ...]:
        """Values that the definition wants located on every branch."""
        return self._equations.definition.watched_values

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse parameter values with which the equations have no meaning."""
        from slipfold.models.definitions.checked_system import check_values

        check_values(self._equations, values)

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Return the largest parts of the formulas that depend on parameters alone."""
        return self._equations.coefficients(p)

    def rates(self, q: Symbols, c: Symbols, phase: Expression) -> dict[str, Expression]:
        """Return the time derivatives of the states, per second."""
        trees = self._equations.rates.items()
        return {name: as_symbol(self._equations.value(tree, q, c, phase)) for name, tree in trees}

    def contacts(self, q: Symbols, c: Symbols, phase: Expression) -> tuple[Contact, ...]:
        """Return the contacts of the definition."""
        return tuple(item.contact(q, c, phase) for item in self._equations.contacts)

    @property
    def resting(self) -> tuple[str, ...]:
        """Names of the contacts whose moving surfaces are at rest or swing."""
        c = self._equations.coefficients(self._values)
        return tuple(
            item.name
            for item in self._equations.contacts
            if not item.moves or not any(item.at_rest(c, 0.0))
        )

    def period(self, p: Symbols) -> Expression:
        """Return the forcing period in seconds; of an autonomous system the ``duration``."""
        return self._equations.period(p)

    def outputs(self) -> tuple[Output, ...]:
        """Return the outputs of the definition."""
        return self._equations.outputs

    def declared_scales(self) -> Array:
        """Scales of the states, shape (n_states,); NaN where the definition gives none."""
        return np.array(
            [
                # An angle is measured in radians, not in revolutions
                item.scale or (1.0 if item.angle else np.nan)
                for item in self._equations.definition.states.values()
            ]
        )

    def __repr__(self) -> str:
        """Name and the parameters that differ from the defaults."""
        return self._call(repr(self.name))

    _equations: SystemEquations


def _equations_of(definition: object, given: dict[str, Any]) -> SystemEquations:
    from slipfold.models.definitions.checked_system import build_system, build_system_of_text

    if definition is None:
        return build_system(Source(given))
    if given:
        raise InputError(
            f"both a definition and {', '.join(given)} are given; give the one or the other"
        )
    if isinstance(definition, Mapping):
        return build_system(Source(definition))
    if isinstance(definition, str):
        return build_system_of_text(definition)
    raise InputError(
        f"the definition is a {type(definition).__name__}; give a TOML text or a mapping of tables"
    )
