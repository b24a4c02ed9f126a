"""Concurrent calls give what serial ones give."""

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np

import slipfold as sf
from slipfold.flow.equations import build_equations
from slipfold.flow.flow import Flow, flow_of
from slipfold.flow.simulate import simulate
from slipfold.models.registry import model_named

THREADS = 16


def together(task, items):
    """Results of a task for each item, one thread an item, all started at once."""
    ready = Barrier(len(items))

    def run(item):
        ready.wait()
        return task(item)

    with ThreadPoolExecutor(len(items)) as pool:
        return list(pool.map(run, items))


def test_every_kind_of_integration():
    model = model_named("duffing")
    flow = flow_of(model)
    constants = flow.constants_of(model)
    along, vectors = constants.rates[:, :1], np.eye(2)

    def integrate(seed):
        rng = np.random.default_rng(seed)
        found = []
        for _ in range(8):
            states, start = rng.normal(size=(2, 2)), rng.uniform(size=2)
            path = states, start, start + 0.5, constants
            found += [
                flow.advance(*path),
                flow.sample(*path[:3], 5, constants),
                *flow.linearize(*path, along),
                *flow.curve(*path, along, vectors),
                flow.jet(states[0], 0.0, 0.5, constants, vectors),
                flow.trajectory(states[0], constants, np.linspace(0, 1, 5)),
                flow.rates(states, start, constants),
                flow.jacobians(states, start, constants),
                simulate(model, 2, states[0]).states,
            ]
        return np.concatenate([item.ravel() for item in found])

    serial = [integrate(seed) for seed in range(THREADS)]
    for one, other in zip(together(integrate, range(THREADS)), serial, strict=True):
        np.testing.assert_array_equal(one, other)


def test_flows_compiled_by_many_threads_at_once(monkeypatch, tmp_path):
    monkeypatch.setenv("SLIPFOLD_CACHE_DIR", str(tmp_path))
    model = model_named("duffing")
    flow = Flow(build_equations(model))
    constants = flow.constants_of(model)
    ends = together(
        lambda _: flow.advance(np.array([[0.1, 0.2]]), np.zeros(1), np.ones(1), constants),
        range(THREADS),
    )
    assert all(np.array_equal(end, ends[0]) for end in ends)


def test_diagrams_of_many_models():
    def points(f):
        model = sf.SlidingOscillator(f=f)
        diagram = sf.response(model, vary="Nd", span=(0, 0.12), settings=SINGLE)
        return [(point.type, point.value, *point.orbit.state) for _, point in diagram.special]

    frequencies = np.linspace(12.3, 12.7, THREADS)
    assert together(points, frequencies) == [points(f) for f in frequencies]


SINGLE = sf.Settings(largest_period=1)
