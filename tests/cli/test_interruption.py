"""Ctrl-C waits for the next point, but not for long."""

from __future__ import annotations

import os
import pkgutil
import signal
from collections.abc import Callable
from itertools import count
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import slipfold as sf
from slipfold.flow.flow import Flow
from slipfold.interface.cli import interruption
from slipfold.interface.cli.interruption import deferred_interrupts


def search_without_end(number: int = signal.SIGINT) -> None:
    os.kill(os.getpid(), number)
    for _ in count():
        pass


def interrupted(work: Callable[[Callable[[], None]], None]) -> bool:
    try:
        with deferred_interrupts() as check:
            work(check)
    except KeyboardInterrupt:
        return True
    return False


@pytest.mark.parametrize("number", interruption.SIGNALS)
def test_a_search_without_end_before_the_first_point_is_ended(
    number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(interruption, "GRACE", 0.01)
    before = signal.getsignal(number)
    assert interrupted(lambda check: search_without_end(number))
    assert signal.getsignal(number) == before


def test_signals_that_are_sent_together_are_one(monkeypatch: pytest.MonkeyPatch) -> None:
    def twice(check: Callable[[], None]) -> None:
        for _ in range(2):
            os.kill(os.getpid(), signal.SIGTERM)

    monkeypatch.setattr(interruption, "TOGETHER", 60.0)
    assert not interrupted(twice)
    monkeypatch.setattr(interruption, "TOGETHER", 0.0)
    assert interrupted(twice)


def test_a_point_that_takes_too_long_ends_the_branch_and_what_was_found_is_kept(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(interruption, "GRACE", 0.01)
    sound, seen = Flow.linearize, list[object]()

    def without_end(self: Flow, *arguments: object) -> object:
        if len(seen) == 4:
            seen.append("once")
            search_without_end()
        return sound(self, *arguments)

    monkeypatch.setattr(Flow, "linearize", without_end)
    with deferred_interrupts() as check:

        def observe(progress: object) -> None:
            seen.append(progress)
            check()

        diagram = sf.response(sf.SlidingOscillator(f=12.5), "Nd", (0, 0.3), on_progress=observe)
    (branch,) = diagram.branches
    assert branch.interrupted
    assert len(branch) == 5
    assert np.isfinite(branch.nodes).all()


def test_what_is_put_together_is_not_interrupted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interruption, "GRACE", 1e-3)
    done = list[int]()

    def work(check: Callable[[], None]) -> None:
        check()
        os.kill(os.getpid(), signal.SIGINT)
        done.append(sum(1 for _ in range(300_000)))  # takes longer than the grace
        check()
        done.append(0)

    assert interrupted(work)
    assert done == [300_000]


@pytest.mark.parametrize("name", sorted(interruption.INTERRUPTIBLE))
def test_what_keeps_what_is_finished_has_the_name_it_is_known_by(name: str) -> None:
    function = pkgutil.resolve_name(name)
    assert f"{function.__module__}.{function.__code__.co_qualname}" == name


def test_what_python_ignores_in_a_callback_of_a_weak_reference_waits() -> None:
    code = SimpleNamespace(co_qualname="first_finished")
    search: Any = SimpleNamespace(
        f_globals={"__name__": "slipfold.studies.run"}, f_code=code, f_back=None
    )
    callback: Any = SimpleNamespace(f_globals={"__name__": "weakref"}, f_code=code, f_back=search)
    assert interruption._keeps_results(search)
    assert not interruption._keeps_results(callback)
