"""A special point that is less certain than it should be says so."""

import math

import pytest

from helpers.diagrams import made_diagram, response_branch, special_point
from helpers.locus_diagrams import doubling_locus, locus_point, made_locus_diagram


@pytest.mark.parametrize(
    ("uncertainty", "said"),
    [
        (1e-9, None),
        (8e-3, "PD of branch 1 at Nd = 0.0436 N is uncertain by 8e-03 N."),
        (math.inf, "PD of branch 1 at Nd = 0.0436 N: its uncertainty could not be computed."),
    ],
)
def test_on_branches(uncertainty, said):
    point = special_point("PD", value=0.0436, uncertainty=uncertainty)
    diagram = made_diagram(branches=(response_branch(special=(point,)),))
    assert ("uncertain" in diagram.summary()) == (said is not None)
    if said:
        assert said in diagram.summary().splitlines()
        assert said in diagram._repr_html_()


def test_on_loci():
    point = locus_point(uncertainty=(1e-3, 2e-9))
    diagram = made_locus_diagram(loci=(doubling_locus(special=(point,)),))
    said = (
        "GPD of locus 1 at f = 12.4362 Hz, Nd = 0.0420153 N is uncertain by 1e-03 Hz and 2e-09 N."
    )
    assert said in diagram.summary().splitlines()
    assert said in diagram._repr_html_()
    assert "uncertain" not in made_locus_diagram().summary()
