"""Where a simulation starts."""

from __future__ import annotations

from slipfold.explorer.messages import SimulationRequest
from slipfold.flow.simulate import initial_state
from slipfold.models.model import Model

__all__ = ["start_of"]


def start_of(model: Model, request: SimulationRequest) -> dict[str, float]:
    """Return the states that a simulation starts from, nudged.

    Parameters
    ----------
    model
        The model.
    request
        The request; rest is where the model starts by itself.

    Raises
    ------
    InputError
        For an unknown state.
    """
    begin = model.start if request.start == "rest" else initial_state(model, request.start)
    moved = begin + initial_state(model, request.nudge)
    return {item.name: float(value) for item, value in zip(model.states, moved, strict=True)}
