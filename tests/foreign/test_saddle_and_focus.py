"""A Hopf point beside a saddle: what is neutral all along hides nothing.

The eigenvalues 1 and -1 of the saddle cancel for every a, so that the determinant of the
bialternate product is zero everywhere (Kuznetsov, Elements of Applied Bifurcation Theory, section
10.2); u, w have their Hopf point at a = 0 and the cycle of radius sqrt(a) beyond.
"""

import pytest

import slipfold as sf

EQUATIONS = """
[parameters]
a = -1
[states]
x = "x - x^3"
y = "-y"
u = "a*u - {rate}*w - u*(u^2 + w^2)"
w = "{rate}*u + a*w - w*(u^2 + w^2)"
"""


@pytest.mark.parametrize(("rate", "span"), [(3.0, (-1, 1)), (0.3, (0.7, -0.9))])
def test_a_hopf_point_beside_a_saddle_is_found(rate, span):
    model = sf.System(EQUATIONS.format(rate=rate))
    equilibria, cycles = sf.response(model, vary="a", span=span).branches
    (hopf,) = equilibria.special
    assert (hopf.type, hopf.criticality) == ("HB", "supercritical")
    assert hopf.value == pytest.approx(0, abs=1e-12)
    radius = cycles.extrema_of("u").maximum[:, 0]
    assert radius**2 == pytest.approx(cycles.parameter, abs=1e-9)
