"""Parameters of computations, each declared once.

The signatures of the public functions use these types. Their docstrings, the options of the
commands and the schema of study files follow from them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Protocol

from slipfold.declarations import Option

if TYPE_CHECKING:
    from concurrent.futures import Executor
    from pathlib import Path

    from numpy.typing import ArrayLike

    from slipfold.bifurcations.branches.special_point import SpecialPoint
    from slipfold.models.model import Model
    from slipfold.orbits.periodic_orbit import PeriodicOrbit
    from slipfold.parameter_space.measurement import Measurement

Interval = tuple[float | str, float | str]
"""Two values of a quantity: numbers in SI units, or text with a unit."""

Number = float | str
"""A number in the SI unit, or text with a unit."""


class HasPoint(Protocol):
    """An item that holds a special point, such as those of `Diagram.special`."""

    @property
    def point(self) -> SpecialPoint:
        """The special point."""


# -- where solutions start ---------------------------------------------------------------------

Box = Annotated[
    Mapping[str, Interval] | None,
    Option(
        "Lowest and highest starting value of some states at phase zero, by name; other states are "
        "at the model's start. By default all states, 1.5 times their scales about the start.",
        "intervals",
        "NAME=LOWER:UPPER",
    ),
]
State = Annotated[
    "ArrayLike | Mapping[str, float | str] | None",
    Option(
        "Starting state at phase zero, shape (n_states,), or some states by name; by default the "
        "model's own. A state on an unstable equilibrium of an autonomous model is moved by 1e-6.",
        "values",
        flags=("--start", "--state"),
        command_help="Starting state at phase zero, by default the model's own.",
    ),
]
Start = Annotated[
    Mapping[str, float | str] | None,
    Option(
        "States by name, near an orbit, cycle or equilibrium that is followed instead of the "
        "response; with `settled` the initial state of the transient. With a value of the varied "
        "parameter the branch begins there, in both directions.",
        "entries",
    ),
]
Starts = Annotated[int, Option("Number of starts in the box, at each value if a parameter varies.")]
SweepStarts = Annotated[int, Option("Starts from the box at each value; 0 for none.", minimum=0)]
Seed = Annotated[int, Option("Seed of random starts, samples or noise.", minimum=0)]

# -- how long solutions are followed -----------------------------------------------------------

Periods = Annotated[
    int | None,
    Option(
        "Forcing periods to integrate, 1000 by default; of an autonomous model intervals of its "
        "``duration``, by default until the solution is steady, 131,072 at most."
    ),
]
ExponentPeriods = Annotated[
    int | None,
    Option(
        "Forcing periods to follow, of an autonomous model intervals of its ``duration``; by "
        "default as many as needed: 32,000 at most, or 128,000 if the kind of solution is still "
        "unknown, no contact sticks and there are six states at most."
    ),
]
SearchPeriods = Annotated[
    int | None,
    Option(
        "Forcing periods after which a solution near no known attractor is classified by its "
        "exponents, 1024 by default; of an autonomous model characteristic times."
    ),
]
SweepPeriods = Annotated[int, Option("Forcing periods stored at each value.", minimum=2)]
SweepTransient = Annotated[int, Option("Forcing periods left out first at each value.", minimum=0)]
RegimeTransient = Annotated[
    int, Option("Forcing periods before the test whether a solution repeats.")
]
SteadyTolerance = Annotated[
    float,
    Option(
        "Distance from a periodic response, cycle or equilibrium that counts as steady, in scaled "
        "states."
    ),
]
ExponentTolerance = Annotated[
    float,
    Option(
        "Error of all exponents, per forcing period or interval, at which the computation ends "
        "unless periods are given; of those below -36 no digits may be left."
    ),
]

# -- what varies -------------------------------------------------------------------------------

Vary = Annotated[str, Option("Name of the parameter that varies.")]
Span = Annotated[
    Interval,
    Option(
        "Its first and last value: numbers in SI units, or text with a unit. A descending span is "
        "fine."
    ),
]
Points = Annotated[int, Option("Number of equidistant values of the parameter.", minimum=2)]
BasinPoints = Annotated[
    int | tuple[int, int],
    Option("Starts along both axes, or along each, e.g. 300x200.", "grid", "N|NxM", minimum=2),
]
RegimePoints = Annotated[tuple[int, int], Option("Values of each parameter.", "grid", minimum=2)]
Plane = Annotated[
    Mapping[str, Interval],
    Option(
        "Two states and their values at phase zero, by name; the first is the horizontal axis. One "
        "may be ``phase``, in forcing periods from 0 to 1, at which starts are released.",
        "intervals",
        "NAME=LOWER:UPPER",
    ),
]
ParameterPlane = Annotated[
    Mapping[str, Interval],
    Option(
        "Names of two parameters with their first and last values: numbers in SI units, or text "
        "with a unit. Sweeps go along the second."
    ),
]
Runs = Annotated[
    Sequence[str],
    Option(
        "Sweeps up, down, both or none, in which each value continues from the last state of the "
        "one before.",
        metavar="both|up|down|none",
        choices={"both": ("up", "down"), "up": ("up",), "down": ("down",), "none": ()},
    ),
]
Window = Annotated[
    "Sequence[Interval] | Mapping[str, Interval] | None",
    Option(
        "Two values of each, always to be given: a pair of pairs in the order of the names, or "
        'pairs by name; numbers in SI units, or text with a unit such as ``"20deg"``.'
    ),
]
PlaneNames = Annotated[tuple[str, str], Option("Names of the two parameters.")]

# -- branches and loci --------------------------------------------------------------------------

ModelOrOrbit = Annotated[
    "Model | PeriodicOrbit",
    Option(
        "The model, e.g. ``SlidingOscillator()``. Or a periodic orbit of it, at a value in the "
        "span: its branch is followed from there in both directions."
    ),
]
Settled = Annotated[
    bool,
    Option(
        "Integrate from the start of the span until the solution is steady, and follow the branch "
        "of that attractor instead of the response; with `tori` a torus, too."
    ),
]
Gradients = Annotated[
    bool,
    Option("Compute the derivatives of every special point with respect to every other parameter."),
]
Also = Annotated[
    "Sequence[PeriodicOrbit | Mapping[str, float | str]]",
    Option(
        "Further starts: orbits, whose branches are followed as well; or mappings as `start`, from "
        "which a solution is integrated until it is steady; with an entry ``period`` or, of a "
        "cycle, ``duration``, the orbit near the states is followed if there is one. A start on a "
        "known branch adds none.",
        "starts",
        command_help="A further start, e.g. Vd=0.5,x=1: a value of the varied parameter, and "
        "states, from which a solution is integrated until it is steady to follow its branch, too; "
        "with period=1, or duration=2.5 of a cycle, the branch of the orbit near them.",
    ),
]
Gaps = Annotated[
    bool,
    Option(
        "Also integrate solutions from the model's start until they are steady, in parts of the "
        "span that no branch reaches or where all equilibria are unstable, and follow their "
        "branches; there first at the model's own value of the parameter."
    ),
]
Search = Annotated[
    "bool | Mapping[str, Interval]",
    Option(
        "Also start solutions at four values of the span, from 32 states each, and follow the "
        "attractors that no branch leads to; of an autonomous model all equilibria that Newton's "
        "method finds from there, too. The states lie in a box three times as large as the "
        "branches, or in a given one, as for `slipfold.attractors`.",
        "flag",
        command_help="Also start solutions at four values of the span and follow the attractors "
        "that no branch leads to; of an autonomous system all equilibria, too. From --box if "
        "given.",
    ),
]
Tori = Annotated[
    bool,
    Option(
        "Also follow the quasi-periodic tori that emanate from Neimark-Sacker points; with "
        "`settled` the torus that the solution converges to."
    ),
]
Cases = Annotated[
    "Mapping[str, Any] | Sequence[Mapping[str, float | str]]",
    Option(
        "The cases: of each parameter that differs one value a case, by name, such as columns of a "
        "table or an `xarray.Dataset`; or one mapping a case. Numbers in SI units, or text with a "
        "unit."
    ),
]
LocusStart = Annotated[
    Any,
    Option(
        "A special point of a branch, of type LP, PD, NS, BP, HB, GRAZE, STICK, LIFT, MAX or "
        "MIN, or several of one model; items of `Diagram.special` will do. Or a model, whose "
        "loci in the window are searched, see `bifurcation_set`."
    ),
]
LocusType = Annotated[
    str | None,
    Option('With a model, the one type of bifurcation to follow, e.g. ``"HB"``; all if None.'),
]
Switch = Annotated[
    bool, Option("Whether loci that start at points of codimension two are followed as well.")
]
Types = Annotated[
    "str | Iterable[str] | None",
    Option(
        "Types of bifurcation to follow: LP, PD, NS, BP, HB of an autonomous model, and GRAZE, "
        "STICK and LIFT, where contacts begin to graze, stick or lift off; all by default, these "
        "three of orbits that stick already only if given.",
        "texts",
        "LP|PD|NS|BP|HB|GRAZE|LIFT|STICK|MAX|MIN",
        flags=("--type",),
        command_help="Type of bifurcation to follow: fold, period doubling, Neimark-Sacker, branch "
        "point, Hopf of an autonomous model, where contacts begin to stick or to lift off; all by "
        "default, changes of contacts of orbits that stick already only if given. With "
        "RESPONSE.nc, type of its points to start from, MAX and MIN among them.",
    ),
]
OrbitPeriods = Annotated[
    "int | Iterable[int]",
    Option("Periods of the orbits whose bifurcations are followed: 1, 2 or both."),
]
Regions = Annotated[
    bool | None,
    Option(
        "Find the regions between the loci and the stable responses in each, checked by "
        "simulations; takes a forced model, all types and both periods.",
        "flag",
    ),
]
Regimes = Annotated[
    tuple[int, int] | None,
    Option(
        "With `regions`, simulate on a grid of so many points what happens where no response of "
        "period 1 or 2 is stable: higher periods, tori, chaos, stick-slip; about a millisecond to "
        "a second each.",
        "grid",
    ),
]
Point = Annotated[
    "SpecialPoint | HasPoint",
    Option("The threshold: a special point of a branch, LP, PD, NS, HB, GRAZE or LIFT."),
]

AmplitudeOf = Annotated[
    str, Option("State or output whose maximum is the amplitude.", metavar="NAME")
]
UpTo = Annotated[
    float | str,
    Option(
        "Amplitude at which it ends: a number in SI units, or text with a unit.", metavar="VALUE"
    ),
]
ModeNumber = Annotated[
    int, Option("Number of the linear mode, the lowest natural frequency first.", minimum=1)
]

# -- thresholds --------------------------------------------------------------------------------

Threshold = Annotated[
    str, Option('Name of the parameter that is raised until stability is lost, e.g. ``"Nd"``.')
]
ThresholdType = Annotated[str, Option('Bifurcation by which stability is lost: ``"PD"``.')]
Over = Annotated[
    "Mapping[str, ArrayLike | Sequence[float | str]]",
    Option(
        "Distinct values of two other parameters by name, each of shape (n,): numbers in SI units, "
        "or text with a unit."
    ),
]
Distributions = Annotated[
    "Mapping[str, str | Mapping[str, Any]]",
    Option(
        'Distributions of parameters about their values at the point, by name: ``"normal 5%"`` '
        '(standard deviation), ``"uniform 2deg"`` (half the width), ``"uniform 0.4:0.6"``, '
        '``"lognormal 5%"`` or ``"normal 5%:0.4:0.6"`` (truncated); sizes in percent of the value, '
        "with a unit, or in the SI unit. Or a table as studies have it.",
        "entries",
        "NAME=normal:SIZE",
        flags=("--distribution",),
        command_help="Distribution of a parameter: normal (standard deviation), uniform (half the "
        "width, or FROM:TO) or lognormal, e.g. mu=normal:5% or alpha=uniform:58deg:62deg.",
    ),
]
Correlation = Annotated[
    "Mapping[Any, float | str] | ArrayLike | None",
    Option(
        'Correlations of pairs of parameters, e.g. ``{"mu,Vd": 0.5}``, or their matrix in the '
        "order of the distributions; of normal scores (a Gaussian copula), equal to those of the "
        "parameters where these are normal. Independent by default.",
        "values",
        "NAME,NAME=R",
        command_help="Correlation of two uncertain parameters, e.g. mu,Vd=0.5.",
    ),
]
Samples = Annotated[int, Option("Number of samples (Sobol's, scrambled), a power of 2.")]
Loads = Annotated[
    Sequence[float | str],
    Option(
        "Values of the followed parameter at which the probability is computed that the "
        "threshold is above them.",
        "texts",
        "VALUE",
        flags=("--load",),
    ),
]
Indices = Annotated[
    bool,
    Option(
        "Compute Sobol's indices as well, from ``samples * (d + 2)`` more thresholds of d "
        "parameters."
    ),
]
Choose = Annotated[
    "Mapping[str, tuple[Number, Number]]",
    Option(
        "Parameters to choose, by name, each with its lowest and highest value.",
        "intervals",
        "NAME=LOWER:UPPER",
    ),
]
Load = Annotated[
    float | str,
    Option(
        "Value of the followed parameter, below the threshold, at which the vibration is measured.",
        metavar="VALUE",
    ),
]
Above = Annotated[
    "Number | Sequence[Number] | None",
    Option(
        "Lower bound of the threshold. Of several bounds one design each: a Pareto curve of "
        "vibration and threshold.",
        "texts",
        "VALUE",
    ),
]
Outside = Annotated[
    "tuple[Number, Number] | None",
    Option("A window that the threshold is to leave, on whichever side vibrates less.", "pair"),
]
Keep = Annotated[
    "Mapping[str, tuple[SpecialPoint | HasPoint, Number]] | None",
    Option(
        "Further thresholds by names of your own, each with its lower bound.",
        "entries",
        "TYPE:PERIOD=VALUE",
        command_help="A further threshold and its lower bound, e.g. PD:1=40mN.",
    ),
]
DesignState = Annotated[
    str | None, Option("State whose vibration is minimized; by default the first.", metavar="NAME")
]

# -- measurements ------------------------------------------------------------------------------

MeasuredValues = Annotated[
    "ArrayLike | Sequence[float | str]",
    Option("Its values: numbers in SI units or text with units, in any order."),
]
Quantities = Annotated[
    Sequence[str],
    Option(
        'Measured quantities, e.g. ``"max y"``: max, min, peak_to_peak or modulus of an output; of '
        "a solution that does not become steady over its last 256 periods.",
        "texts",
        '"MEASURE OUTPUT"',
        flags=("--quantity",),
    ),
]
Sweeping = Annotated[
    str, Option("Direction: up, down, or both, that is up and then down.", metavar="up|down|both")
]
Errors = Annotated[
    float | Sequence[float],
    Option(
        "Standard deviation of the measurements, one for all quantities or one for each, in their "
        "units.",
        "numbers",
        flags=("--error",),
    ),
]
Measured = Annotated[
    "Measurement",
    Option(
        "The measurement, e.g. from `slipfold.read_measurement`. Standard deviations weight the "
        "residuals and give the errors of the parameters; without them all have the same fraction "
        "of the range of their quantity, estimated from the residuals."
    ),
]
Bounds = Annotated[
    "Mapping[str, tuple[float | str, float | str]]",
    Option(
        "Lower and upper bound of each fitted parameter, by name: numbers in SI units or text with "
        "a unit.",
        "intervals",
        "NAME=LOWER:UPPER",
        flags=("--fit",),
        command_help="A parameter to be fitted, and its bounds, e.g. mu=0.3:0.7.",
    ),
]
Fitted = Annotated[
    Sequence[str],
    Option("Names of the parameters to be fitted.", "texts", "NAME", flags=("--fit",)),
]

# -- studies -----------------------------------------------------------------------------------

StudyGiven = Annotated[
    "str | Path | Mapping[str, Any]",
    Option(
        "The study: the name of a TOML file, or the same as a mapping. In addition to a case file "
        "(``model``, ``parameters``, ``friction``) it has ``compute``, what is computed, and "
        "``cases``. The page on studies lists what there is. In a mapping ``model`` may be a "
        "`slipfold.Model`."
    ),
]
StoreFolder = Annotated[
    "str | Path | None",
    Option(
        "Folder in which finished cases are stored, made if there is none. Without it they are "
        "deleted when the process ends."
    ),
]
StudyExecutor = Annotated[
    "Executor | int | str | None",
    Option(
        "Where cases are computed: None for this process, a number of processes, the address of a "
        'Dask scheduler such as ``"tcp://127.0.0.1:8786"``, or any executor of '
        "`concurrent.futures`. A script that asks for processes needs ``if __name__ == "
        '"__main__":``.'
    ),
]
Resume = Annotated[
    bool,
    Option("Continue with the cases in the store; a store that has some is refused otherwise."),
]
RetryFailed = Annotated[bool, Option("Compute failed cases again, too; implies `resume`.")]
