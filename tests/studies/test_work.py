"""What a study computes of a case is what the computation gives for it alone."""

import numpy as np
import pytest

import slipfold as sf
from slipfold.continuation.locate import ZERO
from slipfold.studies.works import ResponseWork


def study(compute, cases, **parameters):
    return sf.study(
        {"model": "sliding", "parameters": parameters, "compute": compute, "cases": cases}
    )


def test_attractors_with_the_shares_of_their_basins():
    sides = {"x": 0.5, "y": 0.5, "vx": 20, "vy": 20}
    box = {name: [-side, side] for name, side in sides.items()}
    compute = {"what": "attractors", "box": box, "starts": 32, "seed": 0}
    found = study(compute, {"grid": {"Nd": [0.02, 0.1]}}, f=12.2)
    for case, force in enumerate((0.02, 0.1)):
        model = sf.SlidingOscillator(f=12.2, Nd=force)
        alone = sf.attractors(model, box, starts=32, seed=0)
        rows = found.listed["case"] == case
        assert found.listed["period"][rows].tolist() == [item.period for item in alone]
        fractions = [alone.fraction(item).value for item in alone]
        assert found.listed["fraction"][rows].tolist() == fractions
        assert found.values["attractors"][case] == len(fractions)
    assert found.values["fraction_period_1"][0] == 1
    one, two = (found.values[f"fraction_period_{period}"][1] for period in (1, 2))
    assert 0 < two < 1
    assert one + two == 1
    assert found.to_xarray().attractor_kind.values.tolist() == ["periodic"] * len(
        found.listed["case"]
    )


def test_loci_with_their_points_of_codimension_two(few_lines, tmp_path):
    compute = {"what": "locus", "window": {"f": [12.42, 12.46], "Nd": [0.035, "50mN"]}}
    found = study(compute, {"list": [{"Vd": 0.6}]})
    alone = sf.bifurcation_set(
        sf.SlidingOscillator(), ("f", "Nd"), {"f": (12.42, 12.46), "Nd": (0.035, 0.05)},
        types=["PD"], periods=[1], regions=False,
    )  # fmt: skip
    assert found.values["loci"][0] == len(alone.loci)
    assert found.values["min_Nd"][0] == min(locus.values[:, 1].min() for locus in alone.loci)
    special = [point for locus in alone.loci for point in locus.special]
    assert found.listed["type"].tolist() == [point.type for point in special]
    assert found.listed["Nd"].tolist() == [point.values[1] for point in special]
    found.save(tmp_path / "loci.nc")
    loaded = sf.load(tmp_path / "loci.nc")
    np.testing.assert_array_equal(loaded.listed["f"], found.listed["f"])


def test_a_parameter_may_have_the_name_of_a_dimension_and_its_replacement_that_of_a_list(tmp_path):
    model = sf.System(
        name="m",
        parameters={"special": 0.3, "w": 1.2},
        states={"x": "v", "v": "-0.1*v - x - 0.1*x^3 + special*cos(w*t)"},
        forcing={"period": "2*pi/w"},
    )
    compute = {"what": "response", "vary": "w", "span": [0.9, 1.3]}
    cases = {"grid": {"special": [0.1, 0.3]}}
    found = sf.study({"model": model, "compute": compute, "cases": cases})
    assert found.to_xarray().threshold.dims == ("special_value_value",)
    found.save(tmp_path / "x.nc")
    assert sf.load(tmp_path / "x.nc").summary() == found.summary()


def test_responses_of_many_cases_go_side_by_side():
    compute = {"what": "response", "vary": "Nd", "span": [0, 0.045], "largest_period": 1}
    speeds = np.linspace(0.5, 1.0, 16)
    assert len(speeds) == ResponseWork.together_from
    found = study(compute, {"grid": {"Vd": speeds.tolist()}}, f=12.5)
    assert set(found.values["outcome"]) == {"PD", "stable"}
    for case in (0, 15):
        model = sf.SlidingOscillator(f=12.5, Vd=speeds[case])
        (alone,) = sf.response(
            model, "Nd", (0, 0.045), settings=sf.Settings(largest_period=1)
        ).branches
        rows = np.flatnonzero(found.listed["case"] == case)
        assert len(rows) == len(alone.special)
        if found.values["outcome"][case] == "stable":
            assert alone.stopped.reason in found.values["reason"][case]
        for row, point in zip(rows, alone.special, strict=True):
            assert found.listed["type"][row] == point.type
            assert found.listed["criticality"][row] == point.criticality
            uncertain = (
                found.listed["uncertainty"][row] + point.uncertainty + 2 * ZERO.close * 0.045
            )
            assert abs(found.listed["value"][row] - point.value) <= uncertain


def extremum(found, name, case=0):
    return [found.values[f"{measure}_{name}"][case] for measure in ("min", "max")]


def test_motions_have_the_extrema_of_what_they_settle_on():
    found = study({"what": "simulation"}, {"grid": {"Nd": [0.02, 0.12]}}, f=12.2)
    for case, force in enumerate((0.02, 0.12)):
        period = found.values["period"][case]
        assert period == case + 1
        model = sf.SlidingOscillator(f=12.2, Nd=force)
        orbit = sf.periodic_orbit(model, period=int(period))
        for name in ("y", "vx", "Vrel"):
            known = np.ravel(orbit.extrema.of(name))
            assert extremum(found, name, case) == pytest.approx(known, rel=1e-7)


def test_extrema_of_cycles_of_stick_and_of_what_has_not_settled():
    cycle = sf.study({
        "model": "vanderpol-free", "compute": {"what": "simulation"},
        "cases": {"list": [{"mu": 1.0}]},
    })  # fmt: skip
    # The amplitude of van der Pol's cycle at mu = 1, as published.
    assert extremum(cycle, "x") == pytest.approx([-2.00861986087, 2.00861986087], rel=1e-9)
    law = sf.Coulomb(mu_s=0.6, mu_k=0.5)
    oscillator = sf.SlidingOscillator(friction=law, f=12.5, Vd=0.05)
    cases = {"list": [{"Nd": 0.3}]}
    stuck = sf.study(
        {"model": oscillator, "compute": {"what": "simulation", "periods": 400}, "cases": cases}
    )
    # As tests of the stand have it: between samples the least may be missed by 1e-6.
    assert extremum(stuck, "x")[1] == pytest.approx(0.1905840421, abs=2e-6)
    assert extremum(stuck, "y")[0] == pytest.approx(-0.0788106789, abs=2e-6)
    started = study({"what": "simulation", "periods": 3}, {"list": [{"Nd": 0.1}]}, f=12.5)
    seen = sf.simulate(sf.SlidingOscillator(f=12.5, Nd=0.1), 3).output("x", per_period=2000)[1]
    assert started.values["settled"][0] == 0
    assert extremum(started, "x") == pytest.approx([seen.min(), seen.max()], rel=1e-4)


def test_a_threshold_is_the_first_loss_of_stability_by_whatever_bifurcation():
    compute = {"what": "threshold", "vary": "Nd", "span": [0, 0.9]}
    found = study(compute, {"grid": {"f": [12.5, 13.3]}})
    for case, frequency in enumerate((12.5, 13.3)):
        model, alone = sf.SlidingOscillator(f=frequency), sf.Settings(largest_period=1)
        branch = sf.response(model, "Nd", (0, 0.9), settings=alone).branches[0]
        lost = np.argmin(branch.stable)
        outcome, threshold = (found.values[name][case] for name in ("outcome", "threshold"))
        if branch.stable.all():
            assert np.isnan(threshold)
        else:
            assert branch.parameter[lost - 1] <= threshold <= branch.parameter[lost]
            point = next(item for item in branch.special if item.type == outcome)
            assert abs(point.value - threshold) <= 1e-12 * 0.9 + point.uncertainty
