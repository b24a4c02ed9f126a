"""Reference values that errors are measured against."""

SPECIALS = {
    "period1": [("PD", 0.043578911491)],
    "period2": [("NS", 0.056690677223), ("NS", 0.166438167073)],
}
"""Nd in N at f = 12.5 Hz, each found by at least two independent methods to the digits given."""

PRECISION = 1e-12
"""The last digit of these values, in N: smaller errors are not known."""

DISPLACEMENTS = (0.1031181765668, -0.0678563350151)
"""(x/L, y/L) after 1000 forcing periods from rest at f = 12.5 Hz and Nd = 0.1 N.

Integrated in 80-bit arithmetic; tolerances of 1e-18 and 1e-19 agree to the digits given.
"""


def special_errors(found: dict[str, list[tuple[str, float]]]) -> list[float] | None:
    """Distances from the reference in N, period 1 first; None if a point is missing or invented."""
    errors = []
    for task, expected in SPECIALS.items():
        points = found[task]
        if [kind for kind, _ in points] != [kind for kind, _ in expected]:
            return None
        errors += [abs(p[1] - e[1]) for p, e in zip(points, expected, strict=True)]
    return errors


def displacement_error(state: list[float]) -> float:
    """Largest distance of (x/L, y/L) from the reference."""
    return max(abs(value - exact) for value, exact in zip(state, DISPLACEMENTS, strict=False))
