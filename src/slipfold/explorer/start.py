"""Where a simulation starts, and in which intervals it is told."""

from __future__ import annotations

from slipfold.explorer.messages import MotionRequest
from slipfold.flow.pace import paced
from slipfold.flow.simulate import initial_state
from slipfold.models.model import Model


def start_of(model: Model, request: MotionRequest) -> dict[str, float]:
    """Return the states that a motion starts from, nudged."""
    begin = model.start if request.start == "rest" else initial_state(model, request.start)
    initial_state(model, request.nudge)  # refuses unknown states
    return {
        item.name: float(value) + request.nudge.get(item.name, 0.0)
        for item, value in zip(model.states, begin, strict=True)
    }


def timed(model: Model, request: MotionRequest) -> Model:
    """Return a model whose periods are forcing periods, or intervals that suit its motion."""
    if model.forced:
        return model
    return paced(model, initial_state(model, start_of(model, request)), None)[0]
