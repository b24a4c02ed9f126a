"""What is zero to its uncertainty is printed as 0; the number itself is kept."""

import math
from dataclasses import replace

import pytest

import slipfold as sf
from helpers.diagrams import STATES, made_diagram, response_branch, special_point
from slipfold.interface.explorer.curves import diagram_view

FOR_EACH_POINT = ("parameter", "nodes", "multipliers", "residual", "arclength")


@pytest.mark.parametrize(
    ("value", "uncertainty", "shown"),
    [
        (3.5e-14, 6.6e-14, "0"),
        (3.5e-9, 6.6e-9, "0"),
        (3.5e-9, 6.6e-11, "3.5e-09"),
        (0.25, math.inf, "0.25"),
    ],
)
def test_special_points(value, uncertainty, shown):
    point = special_point("PD", value=value, uncertainty=uncertainty)
    diagram = made_diagram(branches=(response_branch(special=(point,)),))
    line = next(line for line in diagram.summary().splitlines() if " PD " in line)
    assert line.split()[5] == shown
    assert f"PD at Nd = {shown} N" in repr(point)
    drawn = diagram_view(diagram, "x", "max")["branches"][0]["special"][0]
    assert drawn["value"] == float(shown)
    assert f"at Nd = {shown} N" in drawn["sentence"]
    assert point.value == value


def test_a_special_point_of_a_branch_that_has_one_point_alone():
    branch = response_branch()
    parts = {name: getattr(branch, name)[:1] for name in FOR_EACH_POINT}
    point = special_point(value=0.05, nodes=STATES[1:2], arclength=0.0)
    alone = replace(branch, special=(point,), **parts)
    view = diagram_view(made_diagram(branches=(alone,)), "x", "max_and_min")
    highest, lowest = (line["special"][0]["y"] for line in view["branches"])
    assert [line["x"] for line in view["branches"]] == [[], []]
    _, states = point.orbit.sample(1000)
    assert (highest, lowest) == pytest.approx((states[:, 0].max(), states[:, 0].min()), rel=1e-4)


def test_a_hopf_point_at_zero_and_the_cycles_born_there():
    """In r' = r (mu - r^2) it is at mu = 0; what is computed is some 1e-14."""
    model = sf.built_in_models()["stuart-landau"]()
    summary = sf.response(model, "r", (-1, 1), settings=sf.Settings(largest_period=1)).summary()
    rows = [line.split() for line in summary.splitlines()[3:8]]
    assert [row[5] for row in rows] == ["-1", "0", "1", "0", "1"]
    assert "e-1" not in summary.partition("checked")[0]
