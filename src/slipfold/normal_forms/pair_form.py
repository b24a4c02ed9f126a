"""The cubic coefficient of a pair of eigenvalues, of maps and of vector fields.

Kuznetsov, Elements of Applied Bifurcation Theory, 3rd edition, section 5.4, with the derivatives
``B(u, v)`` and ``C(u, v, w)`` in scaled states. Eigenvectors have unit length.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.normal_forms.normal_form import MapDerivatives

Vector = NDArray[Any]


def pair_cubic(map_: MapDerivatives, q: Vector, p: Vector, h11: Vector, h20: Vector) -> complex:
    """Return the cubic coefficient of a pair. Shapes: h11, h20 (n,)."""
    with_h11, with_h20 = map_.second([(q, h11), (q.conj(), h20)])
    inner = third_form(map_, q, q, q.conj()) + 2 * with_h11 + with_h20
    return complex(np.vdot(p, inner) / 2)


def third_form(map_: MapDerivatives, u: Vector, v: Vector, w: Vector) -> Vector:
    """Return C(u, v, w) for complex vectors, by polarisation of the cubic form."""
    result = np.zeros(len(u), dtype=complex)
    parts = [
        (factor_u * factor_v * factor_w, a, b, c)
        for factor_u, a in ((1, u.real), (1j, u.imag))
        for factor_v, b in ((1, v.real), (1j, v.imag))
        for factor_w, c in ((1, w.real), (1j, w.imag))
        if a.any() and b.any() and c.any()
    ]
    sums = [a + s * b + t * c for _, a, b, c in parts for s in (1, -1) for t in (1, -1)]
    cubes = map_.powers(np.array(sums))[1]
    for i, (factor, *_) in enumerate(parts):
        plus_plus, plus_minus, minus_plus, minus_minus = cubes[4 * i : 4 * i + 4]
        result += factor / 24 * (plus_plus - plus_minus - minus_plus + minus_minus)
    return result
