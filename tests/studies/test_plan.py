"""What a study can be asked for, and what is said of mistakes."""

import numpy as np
import pytest

from slipfold import InputError, SlidingOscillator
from slipfold.studies.plan import read_plan

THRESHOLD = {"what": "threshold", "vary": "Nd", "span": [0, 0.9]}
LOCUS = {"what": "locus", "window": {"f": [12.4, 12.5], "Nd": [0.03, 0.05]}}
GRID = {"grid": {"Vd": [0.5, 0.6]}}


def plan(compute=THRESHOLD, cases=GRID, **others):
    return read_plan({"model": "sliding", "compute": compute, "cases": cases, **others})


def test_a_grid_has_all_combinations_the_last_parameter_changing_first():
    cases = plan(cases={"grid": {"alpha": ["30deg", "60deg"], "Vd": [0.4, 0.5, 0.6]}}).cases
    assert cases.names == ("alpha", "Vd")
    assert cases.shape == (2, 3)
    rows = cases.values(np.arange(6))
    assert rows[:, 0].tolist() == [np.pi / 6] * 3 + [np.pi / 3] * 3
    assert rows[:, 1].tolist() == [0.4, 0.5, 0.6] * 2


def test_steps_of_a_grid():
    linear = {"from": "400mm/s", "to": 0.8, "count": 3}
    even = {"from": 0.01, "to": 1, "count": 3, "spacing": "logarithmic"}
    cases = plan(cases={"grid": {"Vd": linear, "mu": even}}).cases
    np.testing.assert_allclose(cases.axes["Vd"], [0.4, 0.6, 0.8])
    np.testing.assert_allclose(cases.axes["mu"], [0.01, 0.1, 1])


@pytest.mark.parametrize("method", ["latin hypercube", "sobol", "random"])
def test_samples_have_the_distribution_asked_for(method):
    distributions = {
        "mu": {"distribution": "normal", "relative": 0.1},
        "Vd": {"distribution": "uniform", "from": 0.5, "to": "800mm/s"},
        "k1": {"distribution": "lognormal", "deviation": 0.05},
    }
    sample = {"sample": method, "count": 1024, "seed": 3, "distributions": distributions}
    cases = plan(cases=sample).cases
    mu, speed, stiffness = cases.values(np.arange(1024)).T
    # Six standard errors of 1024 independent draws; the other two are more even than that.
    room = 6 / np.sqrt(1024)
    assert abs(mu.mean() - 0.5) < 0.05 * room
    assert abs(mu.std() / 0.05 - 1) < room
    assert 0.5 <= speed.min() <= 0.51
    assert 0.79 <= speed.max() <= 0.8
    assert abs(np.log(stiffness / SlidingOscillator().k1).std() / 0.05 - 1) < room
    again = plan(cases=sample).cases
    assert (again.rows == cases.rows).all()
    assert (plan(cases={**sample, "seed": 4}).cases.rows != cases.rows).any()


def test_distributions_are_written_in_words_as_well():
    words = {"mu": "normal 10%", "Vd": "uniform 0.5:800mm/s", "k1": "lognormal 0.05"}
    tables = {
        "mu": {"distribution": "normal", "relative": 0.1},
        "Vd": {"distribution": "uniform", "from": 0.5, "to": "800mm/s"},
        "k1": {"distribution": "lognormal", "deviation": 0.05},
    }
    one, two = (
        plan(cases={"sample": "sobol", "count": 8, "distributions": distributions}).cases
        for distributions in (words, tables)
    )
    assert one.record() == two.record()
    assert (one.rows == two.rows).all()


def test_distributions_may_be_correlated():
    distributions = {"mu": "normal 1%", "Vd": "normal 1%"}
    sample = {
        "sample": "sobol",
        "count": 1024,
        "distributions": distributions,
        "correlation": {"mu,Vd": 0.5},
    }
    cases = plan(cases=sample).cases
    assert np.corrcoef(cases.rows.T)[0, 1] == pytest.approx(0.5, abs=0.01)
    assert cases.record()["correlation"] == [[1.0, 0.5], [0.5, 1.0]]


def test_a_normal_distribution_may_be_cut_off():
    cut = {"distribution": "normal", "mean": 0.5, "deviation": 0.2, "from": 0.4}
    sample = {"sample": "random", "count": 500, "distributions": {"mu": cut}}
    mu = plan(cases=sample).cases.rows
    assert 0.4 <= mu.min() < 0.405


@pytest.mark.parametrize(
    ("compute", "cases", "words"),
    [
        ({**THRESHOLD, "what": "treshold"}, GRID,
         "the study: compute.what = 'treshold' is unknown; did you mean thr"),
        ({"vary": "Nd"}, GRID, "compute.what is missing; give it"),
        ({"what": "threshold", "vary": "Nd"}, GRID, "compute.span is missing; give it"),
        ({**THRESHOLD, "steps": 3}, GRID, "compute has no entry 'steps'; there are what"),
        ({**THRESHOLD, "span": [0]}, GRID, "compute.span[1] is missing; give it"),
        ({**THRESHOLD, "span": [0, [1]]}, GRID, "compute.span[1] = [1] cannot be used: "),
        ({**THRESHOLD, "span": [0, 0]}, GRID, "the span of Nd from 0 to 0 is empty"),
        ({**THRESHOLD, "span": [0, "1kg"]}, GRID, "Nd = '1kg' has the unit 'kg'"),
        ({**THRESHOLD, "vary": "nd"}, GRID, "did you mean Nd?"),
        ({**THRESHOLD, "vary": "Nd"}, {"grid": {"Vd": [0.5], "V": [1]}}, "has no parameter 'V'"),
        ({"what": "simulation", "periods": 0}, GRID, "compute.periods = 0 cannot be used: input"),
        ({"what": "lyapunov", "tolerance": 0}, GRID, "compute.tolerance = 0 is not > 0"),
        ({"what": "simulation", "start": {"z": 1}}, GRID, "sliding has no state 'z'"),
        (THRESHOLD, {}, "cases has none of grid, list and sample"),
        (THRESHOLD, {**GRID, "list": []}, "cases has grid and list; give one of"),
        ({**THRESHOLD, "vray": "Nd"}, GRID, "compute has no entry 'vray'; did you mean vary"),
        (THRESHOLD, {**GRID, "count": 3}, "cases.grid is not a sample; leave out distributions, "),
        (THRESHOLD, {**GRID, "correlation": {"mu,Vd": 0.5}}, "leave out distributions, correl"),
        (THRESHOLD,
         {"sample": "saltelli", "count": 4, "distributions": {"mu": "normal 1%", "Vd": "normal 1%"},
          "correlation": {"mu,Vd": 0.5}},
         "of independent parameters; leave out cases.correlation"),
        (THRESHOLD, {"gird": {}}, "cases has no entry 'gird'; did you mean grid?"),
        (THRESHOLD, {"grid": {}}, "cases.grid names no parameter"),
        (THRESHOLD, {"grid": {"Nd": [1]}}, "Nd is varied by each case itself"),
        (THRESHOLD, {"grid": {"Vd": 3}}, "cases.grid.Vd = 3 is not a list of values"),
        (THRESHOLD, {"grid": {"Vd": [0.5, 0.5]}}, "cases.grid.Vd has a value twice"),
        (THRESHOLD, {"grid": {"mu": [-1]}}, "mu = -1 is outside its bounds"),
        (THRESHOLD, {"grid": {"Vd": {"from": 1, "to": 2}}}, "cases.grid.Vd.count is missing"),
        (THRESHOLD, {"list": [{"Vd": 1}, {"mu": 1}]}, "cases.list.1 gives mu, the first case Vd"),
        (THRESHOLD, {"list": []}, "cases.list holds no cases"),
        (THRESHOLD, {"sample": "sobol"}, "cases.count is missing"),
        (THRESHOLD, {"sample": "halton"}, "cases.sample = 'halton' is unknown"),
        (THRESHOLD,
         {"sample": "sobol", "count": 3, "distributions": {"Vd": {"distribution": "cauchy"}}},
         "cases.distributions.Vd.distribution = 'cauchy' is unknown; give 'uniform', 'normal'"),
        (THRESHOLD,
         {"sample": "sobol", "count": 3,
          "distributions": {"Vd": {"distribution": "uniform", "from": 1, "to": 2}}},
         "cases.count = 3 is not a power of 2"),
        (THRESHOLD,
         {"sample": "random", "count": 3, "distributions": {"Vd": {"distribution": "normal"}}},
         "the distribution of Vd needs either its deviation, in m/s, or relative"),
        (THRESHOLD,
         {"sample": "random", "count": 3,
          "distributions": {"Vd": {"distribution": "normal", "relative": np.inf}}},
         "cases.distributions.Vd.relative = inf cannot be used: input should be a finite number"),
        (THRESHOLD,
         {"sample": "random", "count": 3,
          "distributions": {"Vd": {"distribution": "lognormal", "deviation": np.inf}}},
         "cases.distributions.Vd.deviation = inf cannot be used: input should be a finite number"),
        ({**LOCUS, "types": ["XX"]}, GRID, "there are no loci of type 'XX'; give LP, PD"),
        ({**LOCUS, "periods": [0]}, GRID, "period = 0 is neither 1 nor 2"),
        ({**LOCUS, "types": []}, GRID, "no type or no period of loci is given"),
    ],
)  # fmt: skip
def test_mistakes_are_one_sentence_with_the_name_of_the_entry(compute, cases, words):
    with pytest.raises(InputError) as caught:
        plan(compute, cases)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('model = "sliding"', "has no table [compute]"),
        ('model = "sliding"\ncompute = {}', "has no table [cases]"),
        ("compute = {}\ncases = {}", "a case file has no model; give e.g."),
        (
            'model = "sliding"\ncompute = {}\ncases = {}\nextra = 1',
            "a case file has no entry 'extra'",
        ),
        ("compute = {", "this is not TOML"),
    ],
)
def test_mistakes_in_a_file_name_the_file(text, words, tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_plan(path)
    assert str(path) in str(caught.value)
    assert words in str(caught.value)
