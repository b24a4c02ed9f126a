"""The modal form of an assembled structure."""

from __future__ import annotations

import heyoka as hy
import numpy as np

from slipfold.arrays import Array
from slipfold.models.formulas.values import as_symbol
from slipfold.models.modal_form import ModalForm
from slipfold.models.quantities import Expression, Symbols
from slipfold.models.structures.assembly import Assembly, Placed
from slipfold.models.structures.component import LocalState, total
from slipfold.models.structures.matrices import MATRICES


def modal_form_of(assembly: Assembly, c: Symbols, phase: Expression) -> ModalForm | None:
    """Return the modal form, None of a structure whose modes are coupled at many places.

    What else couples them, as disks of a rotor and dampers do, is a force. Laws with memory have
    states that are no modes.
    """
    remembers = any(item.component.memory() for item in assembly.placed)
    if assembly.inertia.parts or remembers or not assembly.symmetric:
        return None
    squares, shapes, into = assembly.modes()
    dampings, coupling = [], [(part, True) for part in assembly.gyroscopic]
    coupling += [(part, False) for part in (*assembly.stiffening, *assembly.circulatory)]
    for key, matrix in assembly.damping:
        found = _modal_damping(assembly, matrix, squares, shapes, into)
        if found is None:
            coupling.append(((key, matrix), True))
        else:
            dampings.append((key, found))
    forces = _Forces(assembly, shapes, into)
    if not all(forces.couple(*part, c, moving) for part, moving in coupling):
        return None
    for item in assembly.placed:
        forces.add(item, c, phase)
    symmetry = _symmetry(assembly, shapes, into)
    return ModalForm(squares, tuple(dampings), shapes, into, *forces.found(), symmetry)


def _symmetry(assembly: Assembly, shapes: Array, into: Array) -> tuple[int, Array] | None:
    """Return the spatio-temporal symmetry of the modes of a cyclic structure.

    In a traveling wave each sector moves as the one before did k/N periods earlier. None if a
    reduction has kept one wave of a pair.
    """
    cyclic, basis, mass = assembly.given.cyclic, assembly.basis, assembly.definition.M
    if cyclic is None or cyclic.repeating == 1:
        return None
    count = cyclic.repeating
    lag = cyclic.engine_order * count // cyclic.sectors % count
    ahead = pow(lag, -1, count)  # sectors after which the motion is that of a part later
    sectors = basis.reshape(count, -1, basis.shape[1])
    turned = np.roll(sectors, ahead, axis=0).reshape(basis.shape)
    found = np.linalg.solve(assembly.mass, basis.T @ np.asarray(mass.array() @ turned))
    if np.abs(basis @ found - turned).max() > MATRICES.coupled * np.abs(basis).max():
        return None
    return count, into @ found @ shapes


def _modal_damping(
    assembly: Assembly, matrix: Array, squares: Array, shapes: Array, into: Array
) -> Array | None:
    """Return the diagonal of a damping matrix in modes, None if it couples them."""
    if matrix is assembly.stiffness:
        return squares
    if matrix is assembly.mass:
        return np.ones(len(squares))
    modal = shapes.T @ matrix @ shapes / np.sum((shapes.T @ assembly.mass) * shapes.T, axis=1)
    own = np.diag(modal)
    beside = np.abs(modal - np.diag(own))
    bound = MATRICES.coupled * np.sqrt(np.abs(own[:, None] * own))
    return own if (beside <= bound).all() else None


class _Forces:
    """Forces and motions of components; those along one direction are joined."""

    def __init__(self, assembly: Assembly, shapes: Array, into: Array) -> None:
        self._assembly, self._shapes, self._into = assembly, shapes, into
        self._motions: dict[bytes, tuple[Expression, Array]] = {}
        self._forces: dict[bytes, tuple[list[Expression], Array]] = {}

    def add(self, item: Placed, c: Symbols, phase: Expression) -> None:
        """Add what a component does."""
        zero = np.zeros(self._assembly.size)
        rows = item.rows * self._assembly.length @ self._shapes
        local = LocalState(
            {},
            item.own(c),
            item.component._later(phase),
            tuple(self._motion(np.concatenate([row, zero])) for row in rows),
            tuple(self._motion(np.concatenate([zero, row])) for row in rows),
        )
        inputs = self._into @ self._assembly.inertia.over(item.rows.T) / self._assembly.length
        for force, column in zip(item.component._forces(local), inputs.T, strict=True):
            self._forces.setdefault(column.tobytes(), ([], column))[0].append(force)

    def couple(self, key: str | None, matrix: Array, c: Symbols, moving: bool) -> bool:
        """Add a matrix times displacements, or rates; return whether it acts at few places."""
        units = np.sqrt(np.diag(self._assembly.mass))  # else N s/m would be held against N m s
        left, sizes, right = np.linalg.svd(matrix / units[:, None] / units)
        rank = int(np.count_nonzero(sizes > MATRICES.rank * sizes[0]))
        if rank > MATRICES.joined:
            return False
        right = right[:rank] * units
        tops = np.take_along_axis(right, np.abs(right).argmax(axis=1)[:, None], axis=1)
        inputs = -left[:, :rank] * units[:, None] * sizes[:rank] * tops[:, 0]
        inputs = self._into @ self._assembly.inertia.over(inputs)
        for column, row in zip(inputs.T, right / tops @ self._shapes, strict=True):
            parts = (np.zeros(len(row)), row) if moving else (row, np.zeros(len(row)))
            motion = self._motion(np.concatenate(parts))
            force = motion if key is None else c[key] * motion
            self._forces.setdefault(column.tobytes(), ([], column))[0].append(force)
        return True

    def _motion(self, row: Array) -> Expression:
        key = row.tobytes()
        if key not in self._motions:
            self._motions[key] = hy.expression(f"motion {len(self._motions)}"), row
        return self._motions[key][0]

    def found(self) -> tuple[tuple[Expression, ...], Array, tuple[Expression, ...], Array]:
        """Return motions on which forces depend, their rows, forces, and what they excite."""
        forces = tuple(as_symbol(total(parts)) for parts, _ in self._forces.values())
        size = self._assembly.size
        inputs = np.array([column for _, column in self._forces.values()]).reshape(-1, size).T
        seen = set(hy.get_variables(list(forces))) if forces else set()
        used = [pair for pair in self._motions.values() if str(pair[0]) in seen]
        rows = np.array([row for _, row in used]).reshape(-1, 2 * size)
        return tuple(symbol for symbol, _ in used), rows, forces, inputs
