import numpy as np

from helpers.hand_drawn_loci_plots import drawn_locus, drawn_locus_point, valley
from slipfold.lines import locus_segments


def kinds(locus):
    return [stretch.kind for stretch in locus_segments(locus)]


def line(locus):
    stretches = [stretch.points for stretch in locus_segments(locus)]
    return np.concatenate([stretches[0], *(points[1:] for points in stretches[1:])])


def test_the_criticality_changes_exactly_at_the_located_point():
    before, after = locus_segments(valley())
    assert (before.kind, after.kind) == ("subcritical", "supercritical")
    np.testing.assert_array_equal(before.points[-1], [12.4, 0.06])
    np.testing.assert_array_equal(after.points[0], [12.4, 0.06])


def test_a_cusp_is_sharp():
    # The semicubical parabola, which stands still in both parameters at s = 0.
    s = np.array([-1.0, -0.6, -0.25, 0.2, 0.5, 1.0])
    point = drawn_locus_point("CPC", (12.5, 0.2), 0.0)
    values = np.column_stack([12.5 + 0.1 * s**2, 0.2 + 0.1 * s**3])
    points = line(drawn_locus("LP", values, [point], arclength=s))
    u, v = (points - [12.5, 0.2]).T / 0.1
    assert u.min() == 0.0
    np.testing.assert_allclose(v**2, u**3, atol=2e-3)
    tip = int(np.abs(points - point.values).sum(axis=1).argmin())
    into, out = points[tip] - points[tip - 1], points[tip + 1] - points[tip]
    cosine = into @ out / np.linalg.norm(into) / np.linalg.norm(out)
    assert cosine < -0.95  # the line turns back


def test_a_closed_locus_closes_smoothly():
    angle = np.linspace(0, 2 * np.pi, 15)[:-1]
    values = np.column_stack([12.5 + 0.3 * np.cos(angle), 0.2 + 0.1 * np.sin(angle)])
    for given in (values, np.vstack([values, values[:1]])):
        points = line(drawn_locus("NS", given, arclength=np.arange(len(given)), stopped="closed"))
        np.testing.assert_allclose(points[-1], points[0], atol=1e-12)
        radius = np.hypot((points[:, 0] - 12.5) / 0.3, (points[:, 1] - 0.2) / 0.1)
        np.testing.assert_allclose(radius, 1.0, atol=1e-3)


def test_points_of_one_step_follow_from_their_types():
    s = np.array([0.0, 0.5, 1.0])
    special = [drawn_locus_point("GPD", (12 + v, 0.1), v) for v in (0.6, 0.7)]
    locus = drawn_locus("PD", [(12 + v, 0.1) for v in s], special, arclength=s)
    assert kinds(locus) == ["supercritical", "subcritical", "supercritical"]
