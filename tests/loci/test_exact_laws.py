"""Exact laws: loci in one plane map onto those in another, or onto their own mirror image."""

import numpy as np
import pytest

from helpers.bifurcation_sets import PLANES, crossings, same_orbit, whole_set
from slipfold import SlidingOscillator


def rows(locus, inside):
    """Values, nodes and multipliers of every fourth point of a locus inside a window."""
    for index, values in list(enumerate(locus.values))[::4]:
        pairs = zip(values, inside, strict=True)  # the image of a point on the edge may be outside
        if all(low + 1e-9 < value < high - 1e-9 for value, (low, high) in pairs):
            yield values, locus.nodes[index], locus.multipliers[index]


def check_image(loci, source, values, nodes, multipliers, scales):
    """A point of one locus is mapped onto one of the same kind."""
    alike = [c for c in loci if (c.type, c.period) == (source.type, source.period)]
    near = [
        c for c in crossings(alike, 0, values[0])
        if abs(c.values[1] - values[1]) < 1e-9
        and same_orbit(c.nodes, nodes, scales, source.period) < 1e-7
    ]  # fmt: skip
    assert near, f"{source.type} of period {source.period} has no image at {values}"
    gap = np.abs(multipliers[:, None] - near[0].multipliers[None, :]).min(axis=1)
    assert gap.max() < 1e-6


# -- friction and load -------------------------------------------------------------------------


@pytest.mark.long
def test_friction_and_load_count_as_a_product():
    # The force on the tip is mu (Ns + Nd cos): with Ns = 1 N a point (mu, Nd) is that of mu = 0.5
    # at Ns = 2 mu, Nd = 2 mu Nd.
    friction, load = whole_set(("mu", "Nd")), whole_set(("Ns", "Nd"))
    assert sorted({(c.type, c.period) for c in friction.loci}) == sorted(
        {(c.type, c.period) for c in load.loci}
    )
    scales = SlidingOscillator().state_scales()
    (low, high), (_, top) = PLANES["Ns", "Nd"]
    count = 0
    for locus in friction.loci:
        for (mu, Nd), nodes, multipliers in rows(locus, ((low / 2, high / 2), (0, 1))):
            if 2 * mu * Nd < top:
                image = np.array([2 * mu, 2 * mu * Nd])
                check_image(load.loci, locus, image, nodes, multipliers, scales)
                count += 1
    assert count > 5
    # And the other way: what the plane of the load has lies in that of friction.
    for locus in load.loci:
        for (Ns, Nd), nodes, multipliers in rows(locus, ((low, high), (0, top))):
            if Ns / 2 < 0.9:
                image = np.array([Ns / 2, Nd / Ns])
                check_image(friction.loci, locus, image, nodes, multipliers, scales)


# -- mirror ------------------------------------------------------------------------------------

MIRROR = np.array([-1.0, 1.0, -1.0, 1.0])


@pytest.mark.long
def test_directions_to_either_side_are_mirror_images():
    loci = whole_set(("alpha", "Nd")).loci
    scales = SlidingOscillator().state_scales()
    for locus in loci:
        for (alpha, Nd), nodes, multipliers in rows(locus, PLANES["alpha", "Nd"]):
            image = np.array([np.pi - alpha, Nd])
            check_image(loci, locus, image, nodes * MIRROR, multipliers, scales)
