"""Normal form coefficients of equilibria at points of codimension two.

Formulas of Kuznetsov, Elements of Applied Bifurcation Theory, 3rd edition, section 8.7, with the
derivatives ``B(u, v)`` and ``C(u, v, w)`` of the vector field in scaled states. Eigenvectors have
unit length.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from slipfold.normal_forms.codimension_two import cusp_form, double_form, eigenvectors
from slipfold.normal_forms.field_map import FieldMap
from slipfold.normal_forms.normal_form import critical_vectors


def equilibrium_coefficients(field: FieldMap, kind: str) -> dict[str, float]:
    r"""Return the coefficients that decide what happens near a point of codimension two."""
    form = _FORMS.get(kind)
    return {} if form is None else form(field)


def _bogdanov_takens(field: FieldMap) -> dict[str, float]:
    found = double_form(field, field.jacobian)
    sign = -1.0 if found["a"] < 0 else 1.0
    return {name: sign * value for name, value in found.items()}


def _zero_hopf(field: FieldMap) -> dict[str, float]:
    matrix = field.jacobian
    q0, p0 = eigenvectors(matrix, 0.0)
    q1, p1, _ = critical_vectors(
        matrix, lambda values: np.where(values.imag > 0, np.abs(values.real), np.inf)
    )
    b00, b11, b01 = field.second([(q0, q0), (q1, q1.conj()), (q0, q1)])
    return {
        "a": float(np.vdot(p0, b00).real / 2),
        "b": float(np.vdot(p0, b11).real),
        "e": float(np.vdot(p1, b01).real),
    }


_FORMS: dict[str, Callable[[FieldMap], dict[str, float]]] = {
    "CP": lambda field: cusp_form(field, field.jacobian),
    "BT": _bogdanov_takens,
    "ZH": _zero_hopf,
}
