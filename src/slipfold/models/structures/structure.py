"""A structure of mass, damping and stiffness matrices, with elements, contacts and forcing."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, Self

import numpy as np

from slipfold.arrays import Array, Indices, as_numbers
from slipfold.errors import InputError, unknown
from slipfold.models.definitions.source import Source, source_of_file, source_of_text
from slipfold.models.friction.contact import Contact
from slipfold.models.modal_form import ModalForm
from slipfold.models.quantities import Expression, Output, Symbols
from slipfold.models.structures.assembly import LEVEL, Assembly, assemble
from slipfold.models.structures.component import brief, is_whole
from slipfold.models.structures.cyclic import Sectors
from slipfold.models.structures.damping import Damping
from slipfold.models.structures.definition import COMPONENTS, Definition, define
from slipfold.models.structures.matrices import frequencies_of, lowest_modes
from slipfold.models.structures.mesh import Mesh, MeshShapes, turns_about
from slipfold.models.structures.modal import modal_form_of
from slipfold.models.structures.outputs import outputs_of
from slipfold.models.structures.reduction import ReductionReport
from slipfold.models.unforced import MechanicalModel, Modes
from slipfold.writing import as_path

_PARTS = tuple(item.name for item in fields(Definition))
"""Arguments of the constructor that are not parameter values, and attributes of a definition."""

_READING = ("triangles", "units")
"""Arguments that say how matrices are read."""


class Structure(MechanicalModel):
    r"""A structure from matrices, with elements, friction contacts and periodic forcing.

    .. math::

        M \ddot q + C \dot q + K q = f_{elements}(q, \dot q) + f_{contacts}(q, \dot q, t)
        + f_{forcing}(t)

    The states are the displacements by their names, then their rates with a ``v`` before, then the
    memories of friction laws that have one: ``x y vx vy``. The numbers of elements, contacts and
    forcing are parameters, so that each may be varied: the amplitude ``F``, the static normal force
    ``Ns``, the cubic stiffness ``k3_tip`` of an element with the name ``"tip"``. What is periodic
    in time repeats with the frequency ``f`` or a multiple of it; with several such parts the
    parameter ``level`` scales them all. A structure without any of them is autonomous, and has the
    parameter ``duration`` instead of ``f``. Outputs are the measures of components, `watch`, and
    the energy and powers ``energy power_damping power_forcing power_contacts``.

    Parameters
    ----------
    M, K
        Mass and stiffness matrix in kg and N/m: array of shape (n, n), SciPy sparse array, or path
        of a ``.npz``, ``.npy``, ``.mat``, Matrix Market, Harwell-Boeing or Nastran (``.op2``,
        ``.op4``) file. Displacements whose row of M is empty are condensed statically.
    C
        Damping matrix in N s/m; or `ProportionalDamping` or `ModalDamping`; None for none.
    G, H
        Gyroscopic matrix in N s/m, skew-symmetric, and circulatory matrix in N/m: :math:`G \dot q`
        and :math:`H q` are added to the left side. None for none.
    variables
        `Parameter` objects that describe parameters in formulas of matrices: each matrix may be a
        mapping such as ``{1: K, "omega^2": K_spin}``, whose matrices the formulas multiply. A name
        in a formula that is no parameter becomes one, without unit and with the value 1.
    names
        Names of the n degrees of freedom, a sequence, one text with blanks between, or the path of
        a ``.csv`` file with the columns ``node`` and ``direction``, or ``name``; ``q1 q2 ...`` if
        None.
    reduction
        `FreeInterface`, `CraigBampton` or `ModalReduction`: few modal coordinates ``mode1 mode2
        ...`` stay, and `reduction_report` says how good they are. None keeps all degrees of
        freedom.
    cyclic
        `CyclicSymmetry`: the matrices and components are those of one of several equal sectors,
        under what travels around them. None for a whole structure.
    elements
        Springs: `LinearSpring`, `CubicSpring`, `PolynomialSpring`, `GapSpring`, `TabulatedSpring`,
        `GeometricSpring`.
    contacts
        `FrictionContact` objects.
    forcing
        `HarmonicForce`, `MultiHarmonicForce`, `TabulatedForce`, `BaseMotion`, `BaseAcceleration`.
    length_scale
        Displacements are in units of this length in m, rates in this length a second. Give about
        the amplitude: orbits are accepted at a residual of 1e-10 of it. Without it characteristic
        scales are computed.
    triangles
        What a matrix is that has at most one entry of each mirrored pair: ``"symmetric"`` for one
        triangle of a symmetric matrix, which is completed; ``"whole"`` for matrices that are taken
        as they are, a K that is not symmetric, too. None completes the triangle in a file, which
        `notes` says, and refuses an array and a K that is not symmetric.
    units
        What the matrices are in: ``"SI"``, ``"mm-t-s"`` (mm, t, N), ``"mm-kg-s"`` (mm, kg, mN) or
        ``"in-lbf-s"``. They are converted; ``rx``, ``ry17`` or ``rotz_pad`` name rotations in rad.
        All other values are in SI units or have theirs.
    watch
        Displacements in m that are outputs, as directions by name, such as ``{"u_tip": "tip"}``:
        with a reduction they show displacements that are not states.
    name, title
        Short name, and one line that says what it is, for results and figures.
    **values
        Parameter values; they go before those that the components hold. Numbers in SI units, or
        text with a unit.

    Examples
    --------
    A chain of two masses with a cubic spring and a force at its end:

    >>> from slipfold import CubicSpring, HarmonicForce, ProportionalDamping
    >>> model = Structure(
    ...     M=[[1, 0], [0, 1]],
    ...     C=ProportionalDamping(beta_K=0.01),
    ...     K=[[200, -100], [-100, 100]],
    ...     names="root tip",
    ...     elements=CubicSpring("tip", k3=1e4),
    ...     forcing=HarmonicForce("tip", F=0.5),
    ...     length_scale="10mm",
    ... )
    >>> model.replace(f=1.2)
    Structure(root tip, f=1.2, beta_K=0.01, k3=10000, F=0.5)
    >>> [round(float(f), 4) for f in model.natural_frequencies]
    [0.9836, 2.5752]
    """

    _assembly: Assembly

    def __init__(
        self,
        M: Any,
        C: Any = None,
        K: Any = None,
        *,
        G: Any = None,
        H: Any = None,
        variables: Any = (),
        names: Any = None,
        reduction: Any = None,
        cyclic: Any = None,
        elements: Any = (),
        contacts: Any = (),
        forcing: Any = (),
        length_scale: float | str = 1.0,
        triangles: str | None = None,
        units: str | None = None,
        watch: Any = None,
        name: str = "structure",
        title: str = "structure from matrices",
        **values: float | str,
    ) -> None:
        arguments = locals()
        parts = {key: arguments[key] for key in (*_PARTS, *_READING)}
        definition, given = define(parts)
        assembly = assemble(definition)
        known = {parameter.name for parameter in assembly.parameters}
        for key, value in values.items():
            if key not in known and not isinstance(value, float | int | str):
                raise unknown("a structure has no argument", key, parts)
        notes = (*definition.notes, *assembly.notes)
        self._become(assembly, {**given, **values}, notes)

    def _become(
        self, assembly: Assembly, values: Mapping[str, float | str], notes: tuple[str, ...]
    ) -> None:
        """Adopt states, parameters and limits of an assembly."""
        first = next(iter(assembly.amplitudes), None)
        self._take(
            _assembly=assembly,
            name=assembly.definition.name,
            title=assembly.definition.title,
            notes=notes,
            states=assembly.states,
            parameters=assembly.parameters,
            limits=assembly.limits,
            forcing_amplitude=LEVEL.name if assembly.scaled else first,
        )
        super().__init__(**values)

    @classmethod
    def from_toml(cls, source: str | Path) -> Self:
        """Read a structure from a TOML file or text.

        The tables are ``[structure]`` with ``M K C G H triangles units names length_scale``,
        ``[variables]`` with parameters in formulas of matrices, ``[damping]`` and ``[reduction]``
        with their class as ``type`` and its arguments, ``[cyclic]`` with those of a
        `CyclicSymmetry`, one ``[[elements]]``, ``[[contacts]]`` or ``[[forcing]]`` a component,
        ``[watch]``, and ``[parameters]`` with values. A matrix is written as rows, as ``{ diagonal
        = [...] }``, as matrices by formulas, or is the name of a file in the folder of the TOML
        file. A contact has the friction law as ``friction``.

        Parameters
        ----------
        source
            Path of a file, or the text itself if it has several lines.

        Raises
        ------
        InputError
            If a file cannot be read, or something in it cannot be used: with line and column.

        Examples
        --------
        >>> text = '''
        ... [structure]
        ... M = [[1]]
        ... K = [[100]]
        ... names = "tip"
        ... [[contacts]]
        ... along = "tip"
        ... friction = { law = "Stribeck", mu_s = 0.4, vs = "20 cm/s" }
        ... load = 2.0
        ... Vd = "0.5 m/s"
        ... '''
        >>> Structure.from_toml(text)
        Structure(tip, Ns=2, Vd=0.5, mu_s=0.4, vs=0.2)
        """
        if isinstance(source, str) and "\n" in source:
            return cls._read(source_of_text(source), None, "structure")
        path = as_path(source, "model.toml")
        return cls._read(source_of_file(path), path.parent, path.stem)

    @classmethod
    def from_tables(cls, tables: Mapping[str, Any]) -> Self:
        """Make a structure of the tables of a file, as `to_tables` returns them.

        Parameters
        ----------
        tables
            Numbers, texts, lists and mappings.
        """
        return cls._read(Source(tables), None, "structure")

    @classmethod
    def _read(cls, source: Source, folder: Path | None, name: str) -> Self:
        # Only structures of files need pydantic, which takes a while to load.
        from slipfold.models.structures.files import read_structure

        arguments, values = read_structure(source, folder, name)
        return source.read(lambda parts: cls(**parts, **values), arguments)

    def to_tables(self) -> dict[str, Any]:
        """Return the structure as tables of plain data, from which `from_tables` makes it again."""
        from slipfold.models.structures.files import structure_tables

        return {**structure_tables(self._assembly.given), "parameters": dict(self._values)}

    def to_toml(self) -> str:
        """Return the structure as a TOML text with all matrices; `from_toml` makes it again.

        Raises
        ------
        InputError
            For a friction law of a user's own, which cannot be found again by its name.
        """
        from slipfold.models.structures.files import structure_text

        return structure_text(self._assembly.given, self._values)

    # -- what a model gives --------------------------------------------------------------------

    @property
    def structure(self) -> Mapping[str, Hashable]:
        """Matrices and components with default values: parameter values are apart from them."""
        return {name: getattr(self._assembly.given, name) for name in _PARTS}

    @property
    def forced(self) -> bool:
        """Whether anything is periodic in time."""
        return self._assembly.forced

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse parameter values that contradict each other."""
        for item in self._assembly.placed:
            item.component.check(self._assembly.own_values(item, values))
        self._assembly.inertia.check(self._assembly.factors_at(values))

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Return the coefficients of the components."""
        return self._assembly.coefficients(p)

    def rates(self, q: Symbols, c: Symbols, phase: Expression) -> dict[str, Expression]:
        """Return the time derivatives of the states, per second."""
        return self._assembly.rates(q, c, phase)

    def contacts(self, q: Symbols, c: Symbols, phase: Expression) -> tuple[Contact, ...]:
        """Return the contacts whose laws stick."""
        return self._assembly.contacts(q, c, phase)

    def modal_form(self, c: Symbols, phase: Expression) -> ModalForm | None:
        """Return its modes, which contacts, elements and forces excite."""
        return modal_form_of(self._assembly, c, phase)

    @property
    def advice(self) -> str:
        """What its matrices have that may hide a motion."""
        return self._assembly.advice

    @property
    def shown(self) -> tuple[str, ...]:
        """Displacements; of a reduced structure those that are outputs, as its modes say little."""
        physical = tuple(name for name, _ in self._assembly.watched)
        return physical if physical and self._assembly.reduced else super().shown

    def period(self, p: Symbols) -> Expression:
        """Return the forcing period 1/f in seconds; without forcing the ``duration``."""
        return 1.0 / p["f"] if self.forced else p["duration"]

    def outputs(self) -> tuple[Output, ...]:
        """Return watched displacements, measures of components, energy and powers."""
        return outputs_of(self._assembly)

    @property
    def start(self) -> Array:
        """Zero, with the memories that contacts have after a long slip on their surfaces."""
        memories = [
            value
            for _, contact in self._assembly.friction_contacts
            for value in contact._steady_memory(contact._own(self._values))
        ]
        return np.array([0.0] * (2 * self._assembly.size) + memories)

    def declared_scales(self) -> Array:
        """Displacements in the length scale, rates by the circular frequency, memories by the laws.

        Without a length scale those of displacements and rates are NaN: they are computed.
        """
        return self._scales(self._values["f"]) if self.forced else self.unforced_scales()

    def unforced_scales(self) -> Array:
        """Return `declared_scales` with the lowest natural frequency for that of the forcing."""
        moving = self._assembly.frequencies[self._assembly.frequencies > 0]
        return self._scales(float(moving[0]) if len(moving) else 0.5 / math.pi)

    def _scales(self, frequency: float) -> Array:
        assembly = self._assembly
        length = 1.0 if assembly.definition.length_scale != 1 else math.nan
        scales = [length] * assembly.size + [2 * math.pi * frequency * length] * assembly.size
        for _, contact in assembly.friction_contacts:
            if states := contact.memory():
                law = contact._law_with(contact._own(self._values))
                scales += [law.memory_scale] * len(states)
        return np.array(scales)

    def replace(self, **changes: Any) -> Self:
        """Return a new structure with some parameters or parts changed.

        Parameters
        ----------
        **changes
            New values by name, numbers in SI units or text with a unit; or new parts such as
            ``elements=...``, which come with their values.
        """
        parts = {name: changes.pop(name) for name in (*_PARTS, *_READING) if name in changes}
        if not parts:
            # Continuation does this at every point: what is put together already is shared.
            changed = object.__new__(type(self))
            changed._become(self._assembly, {**self._values, **changes}, self.notes)
            return changed.with_scales(self.estimated_scales)
        other = type(self)(**{**self.structure, **parts})
        kept = {item.name for item in other.parameters}
        for name in (*COMPONENTS, "C"):  # the values of a part that is replaced go with it
            part = getattr(self._assembly.given, name) if name in parts else ()
            if isinstance(part, Damping):
                kept -= part.values.keys()
            elif isinstance(part, tuple):
                kept -= {one.name for item in part for one in item.named_parameters}
        values = {name: value for name, value in self._values.items() if name in kept}
        return other.replace(**{**values, **changes})

    def __repr__(self) -> str:
        """Names of the displacements and the parameters that differ from the defaults."""
        names = self._assembly.names
        shown = " ".join(names) if len(names) <= 6 else f"{len(names)} displacements"
        return self._call(shown)

    # -- what it is without elements and contacts -------------------------------------------------

    @property
    def surface_speeds(self) -> Mapping[str, bool]:
        """Names of the speeds of moving surfaces, and whether contacts stick to them."""
        contacts = self._assembly.definition.contacts
        return {item._parameter_name("Vd"): item.law.sticks for item in contacts}

    @property
    def mass_matrix(self) -> Array:
        """Mass matrix of the retained coordinates in kg, shape (r, r)."""
        return self._assembly.mass + self._assembly.added(
            self._assembly.inertia.parts, self._values
        )

    @property
    def stiffness_matrix(self) -> Array:
        """Stiffness matrix of the retained coordinates without elements in N/m."""
        assembly = self._assembly
        return assembly.stiffness + assembly.added(assembly.stiffening, self._values)

    @property
    def damping_matrix(self) -> Array:
        """Damping matrix of the retained coordinates without elements in N s/m."""
        return self._assembly.added(self._assembly.damping, self._values)

    @property
    def natural_frequencies(self) -> Array:
        """Undamped natural frequencies of the matrices without elements in Hz, ascending."""
        if self._assembly.stiffening or self._assembly.inertia.parts:
            squares = lowest_modes(self.stiffness_matrix, self.mass_matrix)[0]
            return frequencies_of(squares)
        return self._assembly.frequencies.copy()

    def modes(self) -> Modes:
        """Return the linear modes about the static point, all forces included.

        Shapes of a reduced structure are the displacements that are outputs, if there are any.
        """
        modes, assembly = super().modes(), self._assembly
        if not assembly.reduced or not assembly.watched:
            return modes
        rows = np.array([row for _, row in assembly.watched])
        moved = modes.shapes @ rows.T
        largest = np.take_along_axis(moved, np.abs(moved).argmax(axis=1)[:, None], axis=1)
        moved = moved / np.where(largest == 0, 1.0, largest)
        return replace(modes, shapes=moved, names=tuple(name for name, _ in assembly.watched))

    def shapes(
        self, mesh: Mesh, states: Any = None, modes: int = 6, axis: str | None = None
    ) -> MeshShapes:
        """Return shapes of the structure on a mesh.

        A reduced structure shows all of its degrees of freedom.

        Parameters
        ----------
        mesh
            Nodes and elements.
        states
            States of a motion, shape (k, n_states), such as ``orbit.sample(8)[1]``; None for the
            undamped modes of the matrices without elements.
        modes
            How many modes, lowest first.
        axis
            Of a cyclic structure, whose mesh is that of the given sector: the axis x, y or z of
            all sectors, which are shown then. Directions turn with them.

        Returns
        -------
        MeshShapes
            Displacements in m; the largest one of a mode along an axis is 1.

        Raises
        ------
        InputError
            If no degree of freedom is that of a node, or the states have another number.
        """
        assembly = self._assembly
        if not isinstance(mesh, Mesh):
            raise InputError(f"mesh = {brief(mesh)}; give a Mesh, such as Mesh.read of a file")
        rows = mesh.rows(assembly.given.names)
        if states is None:
            if not is_whole(modes, 1):
                raise InputError(f"modes = {brief(modes)}; give a whole number of at least 1")
            squares, few = lowest_modes(self.stiffness_matrix, self.mass_matrix, modes)
            moved = (assembly.basis @ few).T
            frequencies = frequencies_of(squares)
            labels = [f"mode {number}, {f:.4g} Hz" for number, f in enumerate(frequencies, 1)]
        else:
            given = np.atleast_2d(as_numbers(states))
            if given.ndim != 2 or given.shape[1] != len(self.states):
                raise InputError(
                    f"the states have the shape {given.shape}, and the structure has "
                    f"{len(self.states)} states; give those of a motion of it, a row a time"
                )
            if not np.isfinite(given).all():
                raise InputError("the states are not finite; give those of a motion")
            moved = given[:, : assembly.size] @ assembly.basis.T * assembly.length
            labels = [f"state {number} of {len(moved)}" for number in range(1, len(moved) + 1)]
        padded = np.hstack([moved, np.zeros((len(moved), 1))])  # -1 is a node held in place
        mesh, found = self._on_sectors(mesh, padded, rows, axis)
        if states is None:
            largest = np.abs(found).max(axis=(1, 2), keepdims=True)
            found = found / np.where(largest > 0, largest, 1.0)
        return MeshShapes(mesh, found, tuple(labels))

    def _on_sectors(
        self, mesh: Mesh, moved: Array, rows: Indices, axis: str | None
    ) -> tuple[Mesh, Array]:
        """Return a mesh, of all sectors about an axis, and its displacements, (k, m, 3).

        Shapes: moved (k, n + 1), the last column zero; rows (m, 3), see `Mesh.rows`.
        """
        given = self._assembly.given
        if given.cyclic is None:
            if axis is not None:
                raise InputError(f"axis = {axis!r} is that of sectors, and the structure has none")
            return mesh, moved[:, rows]
        sectors = Sectors(given.cyclic, given.names)
        several = [
            moved[:, np.where(rows < 0, -1, sectors.places(number)[rows])]
            for number in range(sectors.count)
        ]
        if axis is None:
            return mesh, several[0]
        count = given.cyclic.sectors
        turns = turns_about(axis, count)
        ahead = np.any((rows >= 0) & (sectors.ahead[rows] == 1), axis=1)[:, None]
        turned = [
            np.where(ahead, part @ turns[(number + 1) % count].T, part @ turns[number].T)
            for number, part in enumerate(several * (count // sectors.count))
        ]
        return mesh.around(count, axis), np.concatenate(turned, axis=1)

    def diameter_frequencies(self, modes: int = 3) -> Array:
        """Return the natural frequencies of a cyclic structure by nodal diameter.

        They are those of the constant matrices without elements, computed with one sector.

        Parameters
        ----------
        modes
            How many for each nodal diameter, lowest first.

        Returns
        -------
        Array
            Frequencies in Hz, shape (N // 2 + 1, modes): row d has those of the nodal diameter d.
            Between 0 and N/2, each is that of two waves, one in either direction.

        Raises
        ------
        InputError
            If the structure has no cyclic symmetry, or fewer modes.
        """
        given = self._assembly.given
        if given.cyclic is None:
            raise InputError(
                "the structure has no cyclic symmetry, so it has no nodal diameters; give "
                "cyclic=CyclicSymmetry(sectors, engine_order, low, high)"
            )
        sectors = Sectors(given.cyclic, given.names)
        most = len(sectors.kept) - len(self._assembly.definition.massless) // sectors.count
        if not 0 < modes <= most:
            raise InputError(f"modes = {modes}; give a number from 1 to {most}, all of a sector")
        return sectors.frequencies(given.M, given.K, modes)

    @property
    def reduction_report(self) -> ReductionReport | None:
        """Errors of natural frequencies and receptances by the reduction; None without one."""
        return self._assembly.report(self._values)

    @property
    def basis(self) -> Array:
        """Displacements of all n degrees of freedom by retained coordinate, shape (n, r)."""
        return self._assembly.basis.copy()
