"""Curves that are followed at the same time are those that each is alone."""

from types import SimpleNamespace

import numpy as np
import pytest

from slipfold.continuation.settings import Stepping
from slipfold.continuation.walk import Front, FrontEquations

BOUNDS = [(0, -9.0, 0.6), (1, -9.0, 9.0)]
"""The circles end where the first coordinate is 0.6."""


class Circles(FrontEquations):
    """Circles of different radii, followed from their lowest point."""

    def __init__(self, radii):
        self.radii = np.array(radii)

    def correct(self, rows, guesses, normals, arclengths):
        radii, along = self.radii[rows, None], np.column_stack([-normals[:, 1], normals[:, 0]])
        middle = (guesses * normals).sum(axis=1)[:, None]  # of the chord through the guess
        half = np.sqrt(radii**2 - middle**2) * np.sign((guesses * along).sum(axis=1))[:, None]
        z = middle * normals + half * along
        tangents = np.column_stack([-z[:, 1], z[:, 0]]) / radii
        moved, found = np.zeros(len(rows)), np.isfinite(z).all(axis=1)
        return SimpleNamespace(
            z=z, tangents=tangents, tests=tangents[:, 1:], moved=moved, found=found
        )


def followed(radii):
    """The points of each circle up to its end."""
    k = len(radii)
    z = np.column_stack([np.zeros(k), -np.array(radii)])[:, None]
    tangents = np.tile([1.0, 0.0], (k, 1))[:, None]
    start = z, tangents, tangents[..., 1:], np.zeros((k, 1))
    front = Front(Circles(radii), *start, np.full(k, 0.02), BOUNDS, Stepping())
    points, active = [[item] for item in z[:, 0]], np.arange(k)
    while len(active):
        trial = front.take(active)
        front.accept(trial, np.flatnonzero(trial.fits))
        for row in active[trial.fits]:
            points[row].append(front.z[row, -1].copy())
        active = active[[points[row][-1][0] != 0.6 for row in active]]
    return [np.array(item) for item in points]


def test_each_curve_is_as_alone_and_ends_on_its_bound():
    radii = (1.0, 0.7, 3.0)
    together = followed(radii)
    for radius, points in zip(radii, together, strict=True):
        np.testing.assert_array_equal(points, followed([radius])[0])
        assert np.linalg.norm(points, axis=1) == pytest.approx(np.full(len(points), radius))
        assert points[-1, 1] == pytest.approx(-np.sqrt(radius**2 - 0.36))
