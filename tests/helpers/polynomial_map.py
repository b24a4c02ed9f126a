"""A polynomial map in disguise: a normal form seen through random coordinates.

It offers what the formulas of normal forms ask of a stroboscopic map, from power series in one
variable cut off after the fifth order.
"""

import numpy as np

ORDER = 5


def times(a, b):
    """Product of two series, the coefficients along the first axis."""
    result = np.zeros(np.broadcast_shapes(a.shape, b.shape), dtype=np.result_type(a, b))
    for k in range(ORDER + 1):
        for j in range(k + 1):
            result[k] = result[k] + a[j] * b[k - j]
    return result


class DisguisedMap:
    """T o phi o N o phi^-1 o T^-1 with phi near the identity, quadratic and cubic at random.

    Parameters
    ----------
    form
        The normal form N: takes and gives a list of series, one a coordinate.
    linear
        Its matrix.
    rng
        Source of the coordinates.
    """

    def __init__(self, form, linear, rng):
        n = len(linear)
        self.form = form
        turn = np.linalg.qr(rng.normal(size=(n, n)))[0]
        self.basis = turn * np.exp(rng.uniform(-0.7, 0.7, n))
        self.basis = self.basis @ (np.eye(n) + 0.3 * rng.normal(size=(n, n)) / n)
        self.inverse = np.linalg.inv(self.basis)
        self.matrix = self.basis @ linear @ self.inverse
        self.quadratic = rng.normal(size=(n, n, n)) / n
        self.cubic = rng.normal(size=(n, n, n, n)) / n

    def _bent(self, series):
        """The quadratic and cubic part of phi."""
        squares = times(series[:, :, None], series[:, None, :])
        cubes = times(squares[..., None], series[:, None, None, :])
        bent = np.einsum("aij,kij->ka", self.quadratic, squares)
        return bent + np.einsum("aijl,kijl->ka", self.cubic, cubes)

    def _image(self, *curve):
        series = np.zeros((ORDER + 1, len(self.matrix)))
        series[1 : len(curve) + 1] = curve @ self.inverse.T
        straight = series
        for _ in range(ORDER):  # the inverse of phi, one more order each time
            straight = series - self._bent(straight)
        image = np.stack(self.form(list(straight.T)), axis=1)
        return (image + self._bent(image)) @ self.basis.T

    def powers(self, directions):
        """B(v, v) and C(v, v, v)."""
        images = [self._image(direction) for direction in directions]
        return np.array([2 * image[2] for image in images]), np.array(
            [6 * image[3] for image in images]
        )

    def second(self, pairs):
        """B(u, v) for complex vectors."""

        def real(u, v):
            plus, minus = self.powers(np.array([u + v, u - v]))[0]
            return (plus - minus) / 4

        return [
            real(u.real, v.real) - real(u.imag, v.imag)
            + 1j * (real(u.real, v.imag) + real(u.imag, v.real))
            for u, v in pairs
        ]  # fmt: skip

    def along_curve(self, curve):
        """Taylor coefficient of the order after the last of a curve v1 s + v2 s^2 + ...

        The normal form of a generalized period doubling asks for it.
        """
        return self._image(*curve)[len(curve) + 1]
