"""Steps of many motions with their derivatives, beside Taylor's method in the flow."""

import numpy as np
import pytest
from scipy.linalg import expm

import slipfold as sf
from slipfold.flow import flow_of
from slipfold.flow.explicit_steps import TOLERANCE, linearised_steps_of

LENGTH = 1 / 8


@pytest.fixture(scope="module")
def motions():
    """Motions over an eighth of a period from states and with forces of all sizes."""
    rng = np.random.default_rng(0)
    models = [
        sf.SlidingOscillator(f=12.5, Nd=force, Vd=speed)
        for force, speed in zip(rng.uniform(0, 0.3, 40), rng.uniform(0.4, 0.9, 40), strict=True)
    ]
    flow, scales = flow_of(models[0]), np.array([model.state_scales() for model in models])
    constants = flow.constants(np.array([model.vector for model in models]), scales)
    states = np.array([model.start for model in models]) + rng.normal(0, 0.1, (40, 4)) * scales
    return models[0], states, rng.uniform(0, 1, 40), constants, scales


def carry(motions, some=slice(None)):
    model, states, start, constants, scales = motions
    change = constants.rates[:, :, model.parameter_index("Nd")]
    return linearised_steps_of(model).carry(
        states[some], start[some], LENGTH, constants.values[some], scales[some], change[some]
    )


def test_states_and_derivatives_are_those_of_the_flow(motions):
    model, states, start, constants, scales = motions
    change = constants.rates[:, :, [model.parameter_index("Nd")]]
    ends, matrices, vectors = flow_of(model).linearise(
        states, start, start + LENGTH, constants, change
    )
    found = carry(motions)
    growth = np.linalg.norm(matrices * scales[:, None] / scales[:, :, None], axis=(1, 2))
    close = 30 * TOLERANCE * growth[:, None]  # so many steps at most, each with such an error
    assert (np.abs(found.ends - ends) / scales <= close).all()
    apart = np.abs(found.matrices - matrices) * scales[:, None] / scales[:, :, None]
    assert (apart <= 10 * close[..., None]).all()
    assert (np.abs(found.vectors - vectors[..., 0]) / scales <= 10 * close).all()


def test_derivatives_about_rest_where_states_do_not_move_at_all():
    # The steps must be short for the sake of the derivatives alone.
    model = sf.System(
        name="rest",
        parameters={"k": 200.0},
        states={"x": "v", "v": "-k*x - 0.1*v - x^3"},
        forcing={"period": 2 * np.pi},
    )
    constants = flow_of(model).constants(model.vector[None], np.ones((1, 2)))
    change = constants.rates[:, :, model.parameter_index("k")]
    found = linearised_steps_of(model).carry(
        np.zeros((1, 2)), np.zeros(1), 1.0, constants.values, np.ones((1, 2)), change
    )
    exact = expm(2 * np.pi * np.array([[0.0, 1.0], [-200.0, -0.1]]))
    # Over fourteen turns, at some thirty steps each, each with such an error of its frequency.
    assert np.abs(found.matrices[0] - exact).max() < 14 * 30 * 200 * TOLERANCE
    assert np.abs(found.ends).max() == 0.0


def test_each_is_the_same_by_itself(motions):
    together, some = carry(motions), slice(5, 24)
    few = carry(motions, some)
    for name in ("ends", "matrices", "vectors", "lowest", "above"):
        np.testing.assert_array_equal(getattr(few, name), getattr(together, name)[some])


def test_what_limits_watch_is_bounded_from_below(motions):
    model, states, start, constants, _ = motions
    samples = flow_of(model).sample(states, start, start + LENGTH, 400, constants)
    phases = start[:, None] + LENGTH * np.arange(400) / 400
    outputs = flow_of(model).outputs(
        samples.reshape(-1, 4), phases.ravel(), constants.repeated(400)
    )
    columns = [flow_of(model).output_index(limit.output) for limit in model.limits]
    least = outputs[:, columns].reshape(len(states), 400, -1).min(axis=1)
    found = carry(motions)
    assert (found.above <= least + 1e-9).all()
    assert (least <= found.lowest + 1e-3).all()  # as near as samples are


def test_motions_that_end_at_a_singularity_are_not_numbers(motions):
    model, states, start, constants, scales = motions
    change = constants.rates[:, :, model.parameter_index("Nd")]
    lost = states.copy()
    lost[3] = np.nan
    found = linearised_steps_of(model).carry(lost, start, LENGTH, constants.values, scales, change)
    assert np.isnan(found.ends[3]).all()
    assert np.isfinite(np.delete(found.ends, 3, axis=0)).all()
