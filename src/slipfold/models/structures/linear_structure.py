"""What a structure is without its elements and contacts: matrices, frequencies, reduction, size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slipfold.arrays import Array
from slipfold.models.model import Model
from slipfold.models.parameter import Parameter
from slipfold.models.structures.assembly import Assembly
from slipfold.models.structures.cost import Cost, estimate_cost
from slipfold.models.structures.matrices.reduction import ReductionReport


class LinearStructure(Model):
    """A model that is put together of matrices, and what they are."""

    _assembly: Assembly

    @property
    def varied_first(self) -> str | None:
        """What switches the forcing off; where nothing does, the speed of a counter-body."""
        return self.quiet or next(iter(self._assembly.speeds), None)

    @property
    def variable_parameters(self) -> tuple[Parameter, ...]:
        """Those that may be varied; what slides stays in slip, so above a speed of zero."""
        sliding = self._assembly.sliding_speeds
        return tuple(
            replace(item, lower_open=True) if item.name in sliding else item
            for item in super().variable_parameters
        )

    @property
    def mass_matrix(self) -> Array:
        """Mass matrix of the kept coordinates in kg, shape (n_kept, n_kept)."""
        return self._assembly.mass.copy()

    @property
    def stiffness_matrix(self) -> Array:
        """Stiffness matrix of the kept coordinates without elements in N/m."""
        return self._assembly.stiffness.copy()

    @property
    def damping_matrix(self) -> Array:
        """Damping matrix of the kept coordinates without elements in N s/m."""
        result = np.zeros_like(self._assembly.mass)
        for key, matrix in self._assembly.damping:
            result += matrix if key is None else self._values[key] * matrix
        return result

    @property
    def natural_frequencies(self) -> Array:
        """Undamped natural frequencies of the matrices without elements in Hz, ascending."""
        return self._assembly.frequencies.copy()

    @property
    def reduction_report(self) -> ReductionReport | None:
        """How well the reduction keeps the natural frequencies; None without one."""
        reduced = self._assembly.reduced
        return None if reduced is None else reduced.report

    @property
    def basis(self) -> Array:
        """Displacements of all n degrees of freedom by kept coordinate, shape (n, n_kept)."""
        reduced = self._assembly.reduced
        return np.eye(self._assembly.size) if reduced is None else reduced.basis.copy()

    def cost(self) -> Cost:
        """Estimate what the flow of the structure will cost, before it is compiled.

        Returns
        -------
        Cost
            Times to compile and to run; it prints as a sentence.
        """
        assembly = self._assembly
        period = 1 / self._values["f"] if self.forced else self._values["duration"]
        return estimate_cost(
            states=len(self.states),
            linear=assembly.nonzeros,
            coupled=sum(int(np.count_nonzero(item.rows)) for item in assembly.placed),
            directions=sum(len(item.rows) for item in assembly.placed),
            cycles=float(assembly.frequencies[-1]) * period,
        )
