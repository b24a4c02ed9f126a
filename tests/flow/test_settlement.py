"""Settled or not, said honestly: sequences whose fate is known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipfold import System
from slipfold.flow.hybrid_trajectory import ModeChange
from slipfold.flow.settlement import judge_changes, judge_settlement


def judge(sequence, tolerance=1e-9):
    states = np.asarray(sequence, dtype=float)
    return judge_settlement(states.reshape(len(states), -1), np.ones(1), tolerance)


def noise(count):
    return 2e-16 * np.random.default_rng(20260105).normal(size=count)


@given(st.integers(1, 8), st.floats(0.1, 0.95), st.integers(0, 1000))
def test_decay_to_a_cycle_is_settled_with_its_period(period, rate, seed):
    cycle = np.random.default_rng(seed).normal(size=period)
    steps = np.arange(1001)
    found = judge(cycle[steps % period] + rate**steps + noise(1001))
    assert (found.settled, found.period) == (True, period)
    assert found.drift < 1e-9
    assert f"response of {period} forcing period" in found.message


@given(st.sampled_from([1, 2, 4]), st.floats(0.99, 0.999))
def test_slow_decay_is_not_settled_and_says_how_long_it_takes(period, rate):
    cycle = np.array([0.0, 1.0, 0.3, 0.7])[:period]
    steps = np.arange(1001)
    found = judge(cycle[steps % period] + rate**steps + noise(1001))
    assert (found.settled, found.period) == (False, None)
    assert found.rate == pytest.approx(rate, abs=1e-6)
    more = found.more
    assert f"about {more:.0f} more periods" in found.message
    # After so many periods the distance is the tolerance, or a little less.
    assert rate ** (1000 + more) == pytest.approx(1e-9, rel=0.1)
    steps = np.arange(1001 + int(more) + 5)
    assert judge(cycle[steps % period] + rate**steps + noise(len(steps))).settled


@pytest.mark.parametrize("size", [1.0, 1e-3, 1e-7])
def test_torus_is_not_settled(size):
    steps = np.arange(2001)
    found = judge(1 + size * np.cos(2 * np.pi * steps / 1.6180339887))
    assert not found.settled
    assert "does not shrink; a torus, chaos" in found.message
    assert "simulate 20000" in found.message


def test_chaos_is_not_settled():
    x = [0.3]
    for _ in range(1000):
        x.append(3.9 * x[-1] * (1 - x[-1]))
    assert not judge(x).settled


def test_doubled_cycle_of_small_amplitude_is_not_taken_for_its_parent():
    steps = np.arange(1001)
    found = judge(0.5 + 1e-6 * (-1.0) ** steps + 0.9**steps)
    assert (found.settled, found.period) == (True, 2)


@pytest.mark.parametrize("growth", [1.1, 1.2, -1.1])
def test_leaving_an_unstable_orbit_is_not_settled(growth):
    steps = np.arange(101)
    found = judge(0.3 + 1e-15 * growth**steps + noise(101))
    assert not found.settled
    assert "leaving an unstable response" in found.message


@pytest.mark.parametrize("multiplier", [-0.5, -0.9, -0.99, -0.999, -0.9999])
def test_an_alternation_that_fades_is_no_period_2(multiplier):
    steps = np.arange(200001)
    assert judge(1 + 0.1 * multiplier**steps).period == 1
    once = int(np.log(4e-9) / np.log(-multiplier)) + 12  # 4e-10 is left
    assert judge((1 + 0.1 * multiplier**steps)[: max(once, 40)]).period == 1
    assert judge(1 + 1e-7 * (-1.0) ** steps).period == 2
    model = System(parameters={"a": 1.0}, states={"x": {"rate": "-x", "scale": 1.0}})
    rounds = [ModeChange(n, np.array([1 + 0.1 * multiplier**n]), ()) for n in range(once + 40)]
    found = [judge_changes(model, rounds[: once + n], 1e-9, 0) for n in range(-20, 40)]
    assert {item.duration for item in found} - {None} == {model.values["duration"]}


def test_scales_and_tolerance_count():
    steps = np.arange(201)
    states = 1000 * 0.9 ** steps[:, None]
    assert not judge_settlement(states, np.ones(1), 1e-9).settled
    assert judge_settlement(states, np.array([1e4]), 1e-9).settled
    assert judge_settlement(states, np.ones(1), 1e-5).settled
