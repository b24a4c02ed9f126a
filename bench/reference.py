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

LOCUS = {
    12.0: 0.253080732602,
    12.2: 0.139837022602,
    12.4: 0.050094221089,
    12.5: 0.043578911491,
    12.6: 0.072876939239,
    12.8: 0.143478082574,
}
"""f in Hz: Nd in N of the period doubling of period 1.

By Fourier collocation (bench/by_hand/loci.py); 61 and 71 instants agree to 1e-13.
"""

NAMED = {
    "generalized period doubling": (12.436208469546, 0.042015324815),
    "smallest Nd": (12.462906976920, 0.040083977292),
}
"""(f, Nd) of points on that locus, by Fourier collocation (tests/reference/loci.json)."""


def special_errors(found: dict[str, list[tuple[str, float]]]) -> list[float] | None:
    """Distances from the reference in N, period 1 first; None if a point is missing or invented."""
    errors = []
    for task, expected in SPECIALS.items():
        points = found[task]
        if [kind for kind, _ in points] != [kind for kind, _ in expected]:
            return None
        errors += [abs(p[1] - e[1]) for p, e in zip(points, expected, strict=True)]
    return errors


def locus_error(landed: list[tuple[float, float]]) -> float | None:
    """Largest distance from the reference in N; None if a frequency is missing."""
    errors = []
    for frequency, exact in LOCUS.items():
        here = [Nd for f, Nd in landed if abs(f - frequency) < 1e-6]
        if not here:
            return None
        errors.append(min(abs(Nd - exact) for Nd in here))
    return max(errors)


def named_errors(name: str, f: float, Nd: float) -> tuple[float, float] | None:
    """Distances of a named point from the reference in Hz and N; None for one not in it."""
    if name not in NAMED:
        return None
    exact_f, exact_Nd = NAMED[name]
    return abs(f - exact_f), abs(Nd - exact_Nd)


def displacement_error(state: list[float]) -> float:
    """Largest distance of (x/L, y/L) from the reference."""
    return max(abs(value - exact) for value, exact in zip(state, DISPLACEMENTS, strict=False))
