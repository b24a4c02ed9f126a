"""Requests of a client: every field is named, typed and bounded; others are refused."""

from __future__ import annotations

import json
import re
from typing import Annotated, Any, ClassVar, Literal, Self, get_args

from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    TypeAdapter,
    ValidationError,
    model_validator,
)

from slipfold.interface.explorer.settings import PAGE

UNNAMED = r"/\\\x00-\x1f\x7f-\x9f"
"""Characters, as in a class of a regular expression, that no model's name in a request has."""

_Text = Annotated[str, Field(min_length=1, max_length=PAGE.name_length)]

Name = Annotated[_Text, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$")]
"""A parameter, state or output."""

ModelName = Annotated[_Text, Field(pattern=f"^[^{UNNAMED}]+$")]
"""A model of the catalogue, called as its file says; it is looked up there and nowhere else."""

FileName = Annotated[str, Field(min_length=1, max_length=255, pattern=r"^[^\x00-\x1f\x7f-\x9f]+$")]
"""A file of the reader's; it is called so in sentences and scripts, and opened nowhere."""

Number = Annotated[float, Field(ge=-PAGE.number, le=PAGE.number, allow_inf_nan=False, strict=True)]

SLOT = r"^(live|pin:[0-9]{1,3})$"

Slot = Annotated[str, Field(pattern=SLOT)]
"""Where the page shows an answer; the newest request of each kind and slot wins."""

ModelText = Annotated[str, Field(min_length=1, max_length=PAGE.text)]
"""A model as TOML; it is parsed and never run."""

Values = Annotated[dict[Name, Number], Field(max_length=PAGE.names)]


class _Message(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    rank: ClassVar[int] = 2  # of a request: the lowest is answered first
    seconds: ClassVar[float] = 120.0  # that a worker may take over it
    slow: ClassVar[bool] = False  # whether it takes so long that it must not take all workers
    remedy: ClassVar[str] = "ask for less, e.g. a narrower span"  # what helps if it takes too long


class _Slow(_Message):
    rank: ClassVar[int] = 3
    seconds: ClassVar[float] = 600.0
    slow: ClassVar[bool] = True


class Quick(_Message):
    """A request that needs a model and no computation."""

    rank: ClassVar[int] = 0
    seconds: ClassVar[float] = 20.0


class _OfModel(_Message):
    model: ModelName
    text: ModelText | None = None  # the text of the model, if the page has it and no catalogue


class _Request(_Message):
    kind: str
    id: Annotated[int, Field(ge=0, le=2**53, strict=True)]  # answers carry it
    slot: Slot = "live"  # of a request to cancel, that of the request to stop

    @property
    def head(self) -> dict[str, Any]:
        """What every answer carries of its request."""
        return {"kind": self.kind, "id": self.id, "slot": self.slot}


_SUBJECT = {"vary", "span", "also", "x", "y", "start", "perturbation", "periods", "interval"}
"""Fields on which a result depends; others say what is shown of it."""


class _ModelRequest(_OfModel, _Request):
    parameters: Values = {}  # those that differ from the defaults, SI units

    @property
    def varied(self) -> tuple[str, ...]:
        """The parameters that the request varies."""
        return ()

    def subject(self, *more: str) -> str:
        """Return what is computed of a model, whatever is shown of it; with more fields."""
        return self.model_dump_json(include={*_SUBJECT, *more})


class FurtherStart(_Message):
    """Where a further branch begins: an orbit, or what a solution settles on.

    States that are not given are those of the model's start.
    """

    value: Number  # value of the parameter that is varied
    state: Values = {}  # states at phase zero by name
    # Period of an orbit in forcing periods; None for what a solution from the state settles on
    period: Annotated[int, Field(ge=1, le=64, strict=True)] | None = None
    # Duration of a cycle of an autonomous model in seconds, about
    duration: Annotated[Number, Field(gt=0)] | None = None

    def along(self, vary: str) -> dict[str, float]:
        """Return it as `slipfold.response` takes it."""
        lasts = {"period": self.period, "duration": self.duration}
        known = {name: value for name, value in lasts.items() if value is not None}
        return {vary: self.value, **self.state, **known}


class _VaryRequest(_ModelRequest):
    vary: Name

    @property
    def varied(self) -> tuple[str, ...]:
        """The parameter that is varied."""
        return (self.vary,)


class _ResponseRequest(_VaryRequest):
    """The response that a view is about: what is varied, from where to where."""

    span: tuple[Number, Number]
    # Orbits and solutions whose branches are followed besides those of the response
    also: Annotated[tuple[FurtherStart, ...], Field(max_length=PAGE.starts)] = ()


class _ShownRequest(_ResponseRequest):
    show: Name
    statistic: Literal["max", "min", "max_and_min", "peak_to_peak", "modulus"] = "max"


class DiagramRequest(_ShownRequest):
    """The response over a parameter, with its bifurcations."""

    rank: ClassVar[int] = 1
    seconds: ClassVar[float] = 60.0

    kind: Literal["diagram"]
    rests: bool = True  # if not, a slider moves: a diagram that can be moved is not followed yet


class ScreenRequest(_VaryRequest):
    """A search for a parameter over which the response has a bifurcation."""

    seconds: ClassVar[float] = 20.0

    kind: Literal["screen"]


class OnBranch(_Message):
    """A point on a branch of a diagram."""

    branch: Annotated[int, Field(ge=1, le=10_000, strict=True)]  # id of the branch
    arclength: Number  # position on it
    # Value of the varied parameter that the orbit is to have, near that position; that of the
    # position itself if None
    value: Number | None = None


class OrbitThrough(FurtherStart):
    """An orbit near a state at phase zero; of an equilibrium the period is None."""

    state: Values
    period: Annotated[int, Field(ge=1, le=64, strict=True)] | None = 1


class OrbitRequest(_ResponseRequest):
    """One periodic orbit: a point on a branch of a diagram, or an orbit near a state."""

    rank: ClassVar[int] = 0
    seconds: ClassVar[float] = 30.0

    kind: Literal["orbit"]
    at: OnBranch | OrbitThrough


class PlaneAxis(_Message):
    """One of the two parameters of a plane."""

    name: Name  # the parameter, or the state
    span: tuple[Number, Number]  # its first and last value


class _WindowRequest(_ModelRequest):
    """A window of two parameters."""

    x: PlaneAxis
    y: PlaneAxis

    @model_validator(mode="after")
    def _two_parameters(self) -> Self:
        if self.x.name == self.y.name:
            raise ValueError(f"{self.x.name} is on both axes; give two different parameters")
        return self

    @property
    def varied(self) -> tuple[str, ...]:
        """The two parameters."""
        return self.x.name, self.y.name


class PlaneRequest(_Slow, _WindowRequest):
    """The bifurcations in a window of two parameters, and the regions between them."""

    kind: Literal["plane"]


class RegimesRequest(_Slow, _WindowRequest):
    """The regimes in a window of two parameters, with increasing resolution."""

    kind: Literal["regimes"]


class TrajectoryRequest(_ModelRequest):
    """A solution from rest or from a state."""

    start: Literal["rest"] | Values = "rest"  # states at phase zero by name
    perturbation: Values = {}  # added to the states, by name


class SweepRequest(_Slow, _ShownRequest, TrajectoryRequest):
    """A motion followed along a parameter, each value from the last state of the one before."""

    kind: Literal["sweep"]
    heard: Name | None = None  # output that sounds; what is shown if None
    points: Annotated[int, Field(ge=2, le=500, strict=True)] = 120
    # Value from which both runs follow the motion that starts; from end to end if None
    begin: Number | None = None
    runs: Annotated[tuple[Literal["up", "down"], ...], Field(min_length=1, max_length=2)] = (
        "up",
        "down",
    )


MOST_PERIODS = 20_000
"""Maximum number of periods of a simulation."""


class SolutionRequest(TrajectoryRequest):
    """A solution over some time."""

    periods: Annotated[int, Field(ge=1, le=MOST_PERIODS, strict=True)] = 400  # of the forcing
    # Seconds that an interval of an unforced solution takes that goes on; as suits it if None
    interval: Annotated[Number, Field(gt=0)] | None = None


class SimulationRequest(SolutionRequest):
    """A simulation, with notes of its progress."""

    kind: Literal["simulation"]
    show: Name | None = None  # the output of which a figure is drawn


class MotionRequest(SolutionRequest):
    """Views of the end of a simulation: in time, in a section, as a spectrum."""

    rank: ClassVar[int] = 1

    kind: Literal["motion"]
    outputs: Annotated[tuple[Name, ...], Field(min_length=1, max_length=4)]
    # Forcing periods, or rounds of a cycle, that are shown; as many as suit the motion if None
    window: Annotated[int, Field(ge=1, le=PAGE.window, strict=True)] | None = None


class SoundRequest(SolutionRequest):
    """The end of a simulation as sound."""

    rank: ClassVar[int] = 1

    kind: Literal["sound"]
    output: Name


class FrictionRequest(Quick, _ModelRequest):
    """The friction coefficients of the contacts, over the slip speed."""

    kind: Literal["friction"]


class ExponentsRequest(TrajectoryRequest):
    """The kind of a solution, by its Lyapunov exponents."""

    seconds: ClassVar[float] = 300.0

    kind: Literal["exponents"]


class BasinsRequest(_Slow, _ModelRequest):
    """Basins of attraction on a plane of two states, with increasing resolution."""

    kind: Literal["basins"]
    x: PlaneAxis
    y: PlaneAxis


DrawnRequest = Annotated[
    DiagramRequest | OrbitRequest | PlaneRequest | SimulationRequest | SweepRequest,
    Discriminator("kind"),
]
"""A request that is answered with something that can leave the page."""

_View = (
    DiagramRequest
    | ScreenRequest
    | OrbitRequest
    | PlaneRequest
    | SimulationRequest
    | MotionRequest
    | SoundRequest
    | SweepRequest
    | ExponentsRequest
    | BasinsRequest
    | RegimesRequest
    | FrictionRequest
)

ViewRequest = Annotated[_View, Discriminator("kind")]
"""A request that is answered with something to look at."""

KINDS = tuple(get_args(item.model_fields["kind"].annotation)[0] for item in get_args(_View))
"""Kinds of requests that can be canceled."""


class CancelRequest(_Request):
    """Stop a computation."""

    kind: Literal["cancel"]
    of: Annotated[str, Field(pattern=f"^({'|'.join(KINDS)})$")]  # kind of the request


Request = Annotated[_View | CancelRequest, Discriminator("kind")]
"""Any request over the WebSocket."""


_ANY: TypeAdapter[Any] = TypeAdapter(Request)


class Pin(_Message):
    """A response that is drawn beside a diagram for comparison."""

    name: Annotated[str, Field(max_length=PAGE.name_length)]
    parameters: Values  # those that differ from the defaults, SI units


class ExportRequest(_Message):
    """A view as a file, or as the text that makes it."""

    kind: ClassVar[str] = "export"

    view: DrawnRequest  # the request that made the view
    # ``"python"``, ``"toml"``, ``"csv"``, ``"nc"``, or that of a figure
    format: Literal["python", "toml", "csv", "nc", "pdf", "svg", "png"]
    pins: Annotated[list[Pin], Field(max_length=PAGE.pins)] = []  # curves beside a diagram
    measurements: FileName | None = None  # file whose measurements are drawn on the diagram
    measured: str | None = None  # what is in that file, for a figure

    @property
    def is_text(self) -> bool:
        """Whether nothing is computed for it: it only says what was asked for."""
        return self.format in ("python", "toml")


class ValuesRequest(Quick, _OfModel):
    """Values of a model's parameters, all of them, to learn which it cannot have."""

    kind: ClassVar[str] = "values"
    parameters: Values  # the values, SI units


class MeasurementsRequest(Quick, _OfModel):
    """A measured response of a model, whose parameter and outputs it names."""

    kind: ClassVar[str] = "measurements"
    name: FileName
    measurements: str  # in the words of the file


class LawRequest(Quick, _OfModel):
    """Another friction law in a contact, as the text of the model with it."""

    kind: ClassVar[str] = "law"
    contact: Annotated[int, Field(ge=0, lt=PAGE.names, strict=True)]  # its place among the contacts
    law: Name  # name of the law


class TextRequest(Quick, _OfModel):
    """The text of a model, to edit it, and its equations."""

    kind: ClassVar[str] = "text"


class ModelRequest(Quick):
    """A model of the client's own, to learn what it has."""

    kind: ClassVar[str] = "model"
    remedy: ClassVar[str] = "write a smaller model, or shorter formulas"

    text: ModelText
    name: FileName | None = None  # the file that it is from, for messages


PostedRequest = (
    ExportRequest | ValuesRequest | MeasurementsRequest | TextRequest | ModelRequest | LawRequest
)
"""A request over HTTP that a worker answers once."""


def parse_request(text: str | bytes) -> Request:
    """Read one request of a client.

    >>> request = parse_request('{"kind": "cancel", "id": 3, "of": "plane"}')
    >>> request.of, request.slot
    ('plane', 'live')
    """
    return _ANY.validate_json(text)


def refusal_of(text: str | bytes, error: ValidationError | None = None) -> dict[str, Any]:
    """Return the answer to a request that cannot be used.

    >>> refusal_of('{"kind": "plane", "id": 7}')
    {'kind': 'plane', 'id': 7, 'slot': 'live', 'done': True, 'error': ''}
    """
    try:
        given = json.loads(text)
    except (ValueError, RecursionError):
        given = None
    read = given if isinstance(given, dict) else {}
    kind, number, slot = read.get("kind"), read.get("id"), read.get("slot")
    return {
        "kind": kind if kind in (*KINDS, "cancel") else "error",
        "id": number if isinstance(number, int) and abs(number) <= 2**53 else None,
        "slot": slot if isinstance(slot, str) and re.match(SLOT, slot) else "live",
        "done": True,
        "error": "" if error is None else _sentence(error),
    }


def _sentence(error: ValidationError) -> str:
    first = error.errors(include_url=False, include_input=False, include_context=False)[0]
    field = ".".join(str(item) for item in first["loc"])
    what = first["msg"].removeprefix("Value error, ")
    return f"the request cannot be used: {field + ': ' if field else ''}{what}"
