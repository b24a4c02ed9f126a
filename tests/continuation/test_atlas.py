"""Many curves: each once, in their order, and what leads where."""

import numpy as np

from slipfold.continuation import AlgebraicCurve, Atlas, Start, Zeros, follow


class Circle(AlgebraicCurve):
    """A circle in the plane about a point of the axis; it crosses the axis twice."""

    def __init__(self, centre):
        self.centre = centre

    def defect(self, z):
        return np.array([(z[0] - self.centre) ** 2 + z[1] ** 2 - 1])

    def jacobian(self, z):
        return np.array([[2 * (z[0] - self.centre), 2 * z[1]]])

    def tests(self, z, tangent):
        return {"axis": z[1]}


class Chain(Atlas):
    """Where a circle crosses the axis, its neighbours on both sides begin."""

    def __init__(self, largest):
        super().__init__()
        self.largest = largest

    def trail(self, start, point):
        bounds = [(1, -0.9, 0.9)]
        return follow(start.curve, point, bounds, [Zeros(start.curve)], departs=start.departs)

    def births(self, chart):
        centre = chart.trail.curve.centre
        neighbours = [centre - 2, centre + 2]
        return [
            self.start(other, chart.number, found)
            for found in chart.trail.found
            for other in neighbours
            if abs(other) <= self.largest
        ]

    def start(self, centre, parent=None, found=None):
        curve = Circle(centre)
        point = curve.begin([centre + 0.8, 0.6], row=[0, 1])
        # The farther out, the later.
        points = (point, curve.turned(point))
        return Start(curve, points, (abs(centre),), parent=parent, found=found)

    def known(self, start):
        same = (c.number for c in self.charts if c.trail.curve.centre == start.curve.centre)
        return next(same, None)


def test_each_curve_is_followed_once_and_in_its_turn():
    chain = Chain(largest=4)
    chain.explore(chain.start(0))
    centres = [chart.trail.curve.centre for chart in chain.charts]
    assert centres == [0, -2, 2, -4, 4]
    parents = [chart.start.parent for chart in chain.charts]
    assert parents == [None, 1, 1, 2, 3]
    (crossing,) = chain.charts[1].trail.found
    assert sorted(chain.leads[crossing]) == [1, 4]


def test_both_directions_are_one_curve_with_two_ends():
    chain = Chain(largest=0)
    chain.explore(chain.start(0))
    (chart,) = chain.charts
    z = np.array([point.z for point in chart.trail.points])
    assert (z[0, 1], z[-1, 1]) == (-0.9, 0.9)
    assert np.all(np.diff([point.arclength for point in chart.trail.points]) > 0)
    assert (chart.begun.kind, chart.trail.end.kind) == ("window", "window")


def test_an_interruption_ends_all():
    class Stopped(Chain):
        def trail(self, start, point):
            def watch(trail):
                raise KeyboardInterrupt

            return follow(start.curve, point, [(1, -0.9, 0.9)], watch=watch)

    chain = Stopped(largest=4)
    chain.explore(chain.start(0))
    assert chain.interrupted
    assert len(chain.charts) == 1
