"""Whether orbits of a model can be followed at its parameter values."""

from __future__ import annotations

from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.models.system import System


def check_followed(model: Model) -> None:
    """Refuse values at which there is motion but no orbit in slip: no counter-body moves on.

    >>> from slipfold.models import SlidingOscillator
    >>> check_followed(SlidingOscillator(Vd=0))
    Traceback (most recent call last):
    ...
    slipfold.errors.InputError: Vd = 0 is outside its bounds; Vd must be > 0 m/s but to simulate
    """
    for item in model.variable_parameters:
        try:
            item.check(model.values[item.name])
        except InputError as error:
            raise InputError(f"{error} but to simulate") from None
    for name in model.resting if isinstance(model, System) else ():
        raise InputError(
            f"the counter-body of the contact {name} is at rest or swings, so nothing slides on it "
            "steadily; let it move at a constant speed, or simulate"
        )
