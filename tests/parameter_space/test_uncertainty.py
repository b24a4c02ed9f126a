"""Thresholds of uncertain parameters: by gradients and by samples; Sobol's indices."""

import numpy as np
import pytest
from matplotlib.figure import Figure

import slipfold as sf
from helpers.command_line import run
from slipfold import Distribution
from slipfold.parameter_space.distributions import parse_distribution
from slipfold.parameter_space.optimum import NoSolutionError, ParameterizedPoint
from slipfold.parameter_space.sampling import drawn, index_design, indices_of

SMALL = {"Vd": "normal 0.2%", "alpha": "uniform 0.2deg", "mu": "normal 0.002"}


@pytest.fixture(scope="module")
def sliding():
    return sf.response(sf.SlidingOscillator(), "Nd", (0, 0.98), f=12.5).special


@pytest.fixture(scope="module")
def doubling(sliding):
    return sliding[0].point


@pytest.fixture(scope="module")
def small(doubling):
    return sf.uncertainty(doubling, SMALL, samples=64, loads=(0.0435, "43.6mN"))


def test_bands_by_both_ways_agree_where_distributions_are_narrow(small):
    width = small.deviation("gradients")
    assert small.deviation() == pytest.approx(width, rel=0.01)
    by_samples, by_gradients = small.band(), small.band(by="gradients")
    assert by_samples == pytest.approx(by_gradients, abs=0.02 * width)
    assert small.probability_above(small.value) == pytest.approx(
        small.probability_above(small.value, "gradients"), abs=0.02
    )
    # Independent parameters: variances add up.
    sizes = [0.002 * 0.6, np.radians(0.2) / np.sqrt(3), 0.002]
    slopes = [-0.041609200963, -0.074329849432, -0.01021911064]
    assert width == pytest.approx(np.linalg.norm(np.multiply(sizes, slopes)), rel=1e-9)


def test_a_point_that_vanishes_is_lost(sliding):
    # The two NS points of the period-2 branch meet at alpha = 58.576197729 deg (beyond.md).
    placed = ParameterizedPoint.at(sliding[2].point, ("alpha",))
    # Beside a fold of the locus slopes go with the inverse root of the distance.
    angles = [58.577, 58.5763]
    found = [placed.moved_to({"alpha": np.radians(angle)}).gradient[0] ** 2 for angle in angles]
    meeting = np.dot(angles, np.array(found) * [-1, 1]) / (found[1] - found[0])
    assert meeting == pytest.approx(58.576197729, abs=2e-5)
    with pytest.raises(NoSolutionError):
        placed.moved_to({"alpha": np.radians(58.57)})
    found = sf.uncertainty(sliding[2], {"alpha": "normal 2deg"}, samples=4, seed=1)
    gone = found.samples[:, 0] < np.radians(58.5)
    assert 0 < found.lost == gone.sum() < 4
    assert np.isnan(found.thresholds[gone]).all()
    assert f"No threshold at {found.lost} of 4 samples" in found.summary()
    assert "which bands and probabilities leave out" in found.summary()
    assert found.probability_above(0.0) == 1.0
    # Samples without a threshold may be stable or unstable.
    low, high = found.probability_bounds(0.0)
    assert low < 1 - found.lost / 4
    assert high == 1.0
    assert found.to_json()["lost"] == found.lost
    labels = found.plot(ax=Figure().add_subplot()).get_legend_handles_labels()[1]
    assert f"by samples, {found.lost} left out" in labels


def indices(function, distributions, count):
    """Sobol's indices of a function of uncertain parameters."""
    return indices_of(
        function(index_design(distributions, count, 0)), [item.name for item in distributions], 0
    )


def test_indices_of_the_ishigami_function():
    # Ishigami and Homma (1990), a = 7, b = 0.1: variances in closed form.
    a, b = 7.0, 0.1
    alone = 0.5 * (1 + b * np.pi**4 / 5) ** 2, a**2 / 8, 0.0
    both = 8 * b**2 * np.pi**8 / 225
    whole = sum(alone) + both
    distributions = [Distribution(name, "uniform", 0.0, np.pi) for name in ("x", "y", "z")]

    def ishigami(at):
        x, y, z = at.T
        return np.sin(x) + a * np.sin(y) ** 2 + b * z**4 * np.sin(x)

    found = indices(ishigami, distributions, 2**13)
    assert found.first == pytest.approx(np.divide(alone, whole), abs=5e-3)
    expected = np.add(alone, (both, 0, both)) / whole
    assert found.total == pytest.approx(expected, abs=5e-3)


def test_one_parameter_has_all_of_the_variance():
    found = indices(lambda at: at[:, 0] ** 2, [Distribution("x", "uniform", 1.0, 1.0)], 2**10)
    assert found.first == pytest.approx([1.0], abs=1e-2)
    assert found.total == pytest.approx([1.0], abs=1e-2)


def test_indices_that_cannot_be_computed_say_why(sliding, tmp_path):
    found = sf.uncertainty(sliding[2], {"alpha": "normal 2deg"}, samples=4, seed=1, indices=True)
    assert found.indices is None
    assert " of 12 samples have no threshold; first: " in found.no_indices
    assert f"No indices: {found.no_indices}" in found.summary()
    assert found.to_json()["no_indices"] == found.no_indices
    found.save(tmp_path / "u.nc")
    assert sf.load(tmp_path / "u.nc").no_indices == found.no_indices


def test_an_interruption_of_the_indices_leaves_the_samples(doubling):
    def observer(progress):
        if progress.done == 6:
            raise KeyboardInterrupt

    distributions = {"Vd": "normal 0.5%"}
    found = sf.uncertainty(doubling, distributions, samples=4, indices=True, on_progress=observer)
    assert found.interrupted
    assert np.isfinite(found.thresholds).all()
    assert "samples are missing" not in found.summary()
    assert "No indices: interrupted before all of their samples were reached" in found.summary()


def test_equilibria_have_uncertain_hopf_points():
    model = sf.built_in_models()["lorenz"]()
    start = {"x": 7, "y": 7, "z": 19}
    diagram = sf.response(model, "rho", (20, 28), start=start)
    (point,) = (item.point for item in diagram.special if item.point.type == "HB")
    found = sf.uncertainty(point, {"sigma": "uniform 10%", "beta": "uniform 10%"}, samples=16)
    sigma, beta = found.samples.T
    expected = sigma * (sigma + beta + 3) / (sigma - beta - 1)
    assert found.thresholds == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("done", [0, 1, 3])
def test_interruption_keeps_what_is_known(doubling, done, recwarn):
    def observer(progress):
        if progress.done == done:
            raise KeyboardInterrupt

    found = sf.uncertainty(doubling, SMALL, samples=8, on_progress=observer)
    assert found.interrupted
    assert np.isfinite(found.thresholds).sum() == done
    assert np.isfinite(found.deviation()) == (done > 1)
    assert found.lost == 0
    assert f"Interrupted: {8 - done} samples are missing" in found.summary()
    assert not recwarn.list


@pytest.mark.parametrize(
    ("text", "kind", "size"),
    [
        ("normal 5%", "normal", 0.03),
        ("uniform:20mm/s", "uniform", 0.02),
        ("normal 0.1", "normal", 0.1),
        ("lognormal 2%", "lognormal", 0.02),
        ("uniform 550mm/s:0.65", "uniform", 0.05),
        ("uniform 95%:105%", "uniform", 0.03),
        ({"distribution": "normal", "deviation": "5%"}, "normal", 0.03),
        ({"distribution": "uniform", "half_width": "20mm/s"}, "uniform", 0.02),
        ({"distribution": "normal", "relative": 0.05, "mean": 0.6}, "normal", 0.03),
    ],
)
def test_distributions_are_read(text, kind, size):
    parameter = sf.SlidingOscillator().parameter("Vd")
    read = parse_distribution(text, parameter, 0.6)
    assert read == Distribution("Vd", kind, pytest.approx(0.6), pytest.approx(size))
    assert parse_distribution(read.record(), parameter, 1.0) == Distribution(
        "Vd", kind, pytest.approx(0.6), pytest.approx(size)
    )


def test_probabilities_have_intervals(small):
    load = small.value
    for way in ("samples", "gradients"):
        low, high = small.probability_bounds(load, way)
        assert low < small.probability_above(load, way) < high
    # Wilson's interval of k of n in closed form, with the normal quantile z.
    n, z, fraction = 64, 1.959963985, small.probability_above(load)
    middle = fraction + z**2 / (2 * n)
    half = z * np.sqrt(fraction * (1 - fraction) / n + (z / (2 * n)) ** 2)
    assert small.probability_bounds(load) == pytest.approx(
        [(middle - half) / (1 + z**2 / n), (middle + half) / (1 + z**2 / n)], rel=1e-6
    )
    assert f"({small.probability_bounds(0.0435)[0]:.1%} to " in small.summary()
    ends = small.to_json()["by_samples"]["probability_bounds"][0]
    assert ends == [0.0435, *small.probability_bounds(0.0435)]
    with pytest.raises(sf.InputError, match="the load Nd = nan is not finite"):
        small.probability_above(np.nan)


def test_correlated_parameters_are_drawn_so():
    distributions = [
        Distribution("a", "normal", 1.0, 0.1),
        Distribution("b", "lognormal", 2.0, 0.3),
    ]
    matrix = np.array([[1.0, -0.6], [-0.6, 1.0]])
    values = drawn("sobol", 2**12, 1, distributions, correlation=matrix)
    scores = np.column_stack([(values[:, 0] - 1) / 0.1, np.log(values[:, 1] / 2) / 0.3])
    assert np.cov(scores.T) == pytest.approx(matrix, abs=5e-3)


def test_deviations_of_correlated_parameters(doubling, tmp_path):
    # Of two that together always change, effects add up, or cancel.
    distributions = {"Vd": "normal 0.2%", "mu": "normal 0.002"}
    parts = np.multiply([-0.041609200963, -0.01021911064], [0.002 * 0.6, 0.002])
    for correlation in (0.5, "-0.5"):
        found = sf.uncertainty(
            doubling, distributions, samples=64, correlation={"mu, Vd": correlation}
        )
        width = np.sqrt(parts @ parts + 2 * float(correlation) * np.prod(parts))
        assert found.deviation("gradients") == pytest.approx(width, rel=1e-9)
        assert found.deviation() == pytest.approx(width, rel=0.03)
        assert found.fractions.sum() == pytest.approx(1.0)
    found.save(tmp_path / "u.nc")
    assert np.array_equal(sf.load(tmp_path / "u.nc").correlation, [[1, -0.5], [-0.5, 1]])


@pytest.mark.parametrize(
    ("correlation", "said"),
    [
        ({"mu,Vd": 0.9, "mu,alpha": 0.9, "Vd,alpha": -0.9}, "e.g. 0.55 times what they are"),
        ({"mu,Vd": 1}, "contradict each other"),
        ({"mu,L": 0.5}, "no uncertain parameter is named 'L'"),
        ({"mu": 0.5}, "does not name two different parameters"),
        ({"mu,Vd": 0.5, "Vd,mu": 0.4}, "is given twice"),
        ({"mu,Vd": "nan"}, "finite and symmetric"),
        (np.eye(2), "is not 3 by 3"),
        ("strong", "or pairs, e.g. "),
    ],
)
def test_correlations_that_cannot_be(doubling, correlation, said):
    distributions = {"mu": "normal 1%", "Vd": "normal 1%", "alpha": "normal 1deg"}
    with pytest.raises(sf.InputError, match=said):
        sf.uncertainty(doubling, distributions, samples=4, correlation=correlation)


@pytest.mark.parametrize(
    ("distributions", "options", "said"),
    [
        ({}, {}, "no parameter is uncertain"),
        ({"mu": "wide"}, {}, "give normal or uniform and a size"),
        ({"mu": "normal 5%:0.4"}, {}, "give normal or uniform and a size"),
        ({"mu": "uniform 0.6:0.4"}, {}, "of mu goes from 0.6 to 0.4; give from below to"),
        ({"mu": "normal 5%:0.6:0.4"}, {}, "of mu goes from 0.6 to 0.4; give from below to"),
        ({"mu": "normal 5%:0.6:0.7"}, {}, "cut off below 0.6, which leaves out its mean 0.5; give"),
        ({"mu": "uniform 5%:0.6"}, {}, "the ends 5% and 0.6, of which one is in percent"),
        ({"mu": "uniform 1%:3%"}, {}, "since percent are of mu = 0.5; give ends on both sides"),
        ({"mu": "uniform 0.4:"}, {}, "the distribution of mu has one end, the other is missing"),
        ({"mu": "uniform :0.4"}, {}, "the distribution of mu has one end, the other is missing"),
        ({"mu": "lognormal 2"}, {}, "the deviation 2 of its logarithm, more than 1, .* e.g. 5%"),
        ({"mu": 5}, {}, "the distribution of mu = 5 cannot be used"),
        ({"mu": {"distribution": "beta"}}, {}, "distribution = 'beta' is unknown"),
        ({"mu": "normal 0%"}, {}, "has the size 0 about mu = 0.5"),
        ({"Nd": "normal 5%"}, {}, "Nd cannot be uncertain, since the threshold is a value of Nd"),
        ({"m": "normal 5%"}, {}, "no parameter 'm'"),
        ({"mu": "normal nan"}, {}, "has the size nan|no finite size|not a finite"),
        ({"mu": "normal 5%"}, {"loads": ["nan"]}, "the load Nd = 'nan' is not finite"),
        (
            {"mu": "normal 5%", "Vd": "normal 1%"},
            {"indices": True, "correlation": {"mu,Vd": 0.1}},
            "independent parameters; leave out correlation or indices",
        ),
        ({"mu": "normal 5%"}, {"samples": 100}, "samples = 100 is not a power of 2"),
    ],
)
def test_bad_input(doubling, distributions, options, said):
    with pytest.raises(sf.InputError, match=said):
        sf.uncertainty(doubling, distributions, **options)


def test_gradients_that_are_not_those_of_the_mean_are_said_to_be(doubling, small):
    found = sf.uncertainty(doubling, {"mu": "uniform 0.5:0.6", "Vd": "normal 1%"}, samples=4)
    said = "Gradients are those of the case itself, at mu = 0.5 and not about 0.55: bands by them"
    assert said in found.summary()
    assert "the case itself" not in small.summary()


def test_command():
    result = run(
        "uncertainty", "sliding", "--vary", "Nd=0:0.05", "--set", "f=12.5",
        "--distribution", "mu=normal:5%", "--distribution", "Vd=normal:1%",
        "--correlation", "mu,Vd=0.5",
        "--samples", "8", "--load", "43mN",
    )  # fmt: skip
    assert result.exit_code == 0
    assert "distribution of PD of sliding at Nd = 0.0435789 N, 8 samples" in result.stdout
    assert "P(threshold > 0.043 N)" in result.stdout
    folds = run(
        "uncertainty", "duffing", "--vary", "W=0.5:2", "--type", "LP",
        "--distribution", "d=normal:1%", "--samples", "2",
    )  # fmt: skip
    # The fold at 1.1157 is nearer to the beginning of the span, and comes later.
    assert "distribution of LP of duffing at W = 1.2696" in folds.stdout
    wrong = run("uncertainty", "sliding", "--vary", "Nd=0:0.02", "--distribution", "mu=normal:5%")
    assert wrong.exit_code == 2
    assert (
        "the response has no special point with a locus; give another model or span" in wrong.stderr
    )
