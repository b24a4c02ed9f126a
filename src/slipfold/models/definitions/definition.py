"""What defines a system of equations, as frozen data: names, formulas as text, meanings."""

from __future__ import annotations

from dataclasses import dataclass

from slipfold.models.definitions.contact_formulas import ContactFormulas
from slipfold.models.output import Limit
from slipfold.models.parameter import Parameter, State


@dataclass(frozen=True)
class StateFormula:
    """A state with the formula of its rate."""

    state: State  # name, unit and meaning
    rate: str  # formula of its time derivative, per second
    scale: float | None = None  # typical size, in the unit of the state; None if it is to be found
    start: float = 0.0  # value from which motions and searches start, in the unit of the state


@dataclass(frozen=True)
class OutputFormula:
    """A quantity of interest with its formula."""

    name: str  # name in results
    formula: str  # in states, parameters, named formulas and the time
    unit: str = ""  # unit as text
    doc: str = ""  # one line that says what it is
    label: str = ""  # axis label in mathtext; the name itself if empty


@dataclass(frozen=True)
class WatchedValue:
    """An event: a value of an output, or of a parameter, to be located on every branch."""

    name: str  # name of the event
    output: str  # a state, an output or, with the measure ``"parameter"``, a parameter
    value: float  # the value, in its unit
    measure: str = "max"  # ``"max"``, ``"min"``, ``"peak_to_peak"`` or ``"parameter"``
    stop: bool = False  # whether the branch ends there


@dataclass(frozen=True)
class Definition:
    """A system of first-order equations."""

    # Short name, and a line that says what it is
    name: str
    title: str = ""
    parameters: tuple[Parameter, ...] = ()  # parameters with defaults and bounds
    # Named intermediate formulas: pairs of a name and a text
    formulas: tuple[tuple[str, str], ...] = ()
    states: tuple[StateFormula, ...] = ()  # states with the formulas of their rates
    contacts: tuple[ContactFormulas, ...] = ()  # where friction acts that may stick
    # Formula of the forcing period in seconds; None for an autonomous system
    period: str | None = None
    # Name of the parameter that switches the forcing off; None if there is none
    quiet: str | None = None
    outputs: tuple[OutputFormula, ...] = ()  # quantities of interest
    limits: tuple[Limit, ...] = ()  # where the system is valid
    events: tuple[WatchedValue, ...] = ()  # values to be located on branches
