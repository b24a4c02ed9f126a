"""What is shown, as a file or as the text that makes it."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, cast

import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError, refusal
from slipfold.flow.simulate import initial_state
from slipfold.interface.explorer.messages import (
    DiagramRequest,
    DrawnRequest,
    OrbitRequest,
    OrbitThrough,
    PlaneRequest,
    SimulationRequest,
    SweepRequest,
)
from slipfold.interface.explorer.sweeps import PARTS, swept_model, values_of_runs
from slipfold.interface.explorer.texts import case_text, changed_values, is_built_in, whole_text
from slipfold.interface.explorer.trajectories import run_of, start_of
from slipfold.lines import parts_of
from slipfold.models.definitions.system_file import write_tables
from slipfold.models.equilibria import check_followed
from slipfold.models.model import Model
from slipfold.models.quantities import DURATION
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.models.structures.structure import Structure
from slipfold.models.system import System
from slipfold.models.unforced import Unforced
from slipfold.orbits.eigenvalues import MODE_UNITS, modes_of
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.parameter_space.measurement import Measurement
from slipfold.results.diagram import Diagram
from slipfold.results.result import Result
from slipfold.results.tables import Frame

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MEDIA_TYPES = {
    "python": "text/x-python; charset=utf-8",
    "toml": "application/toml; charset=utf-8",
    "csv": "text/csv; charset=utf-8",
    "nc": "application/x-netcdf",
    "pdf": "application/pdf",
    "svg": "image/svg+xml",
    "png": "image/png",
}
"""What each format is."""

SUFFIXES = {name: "py" if name == "python" else name for name in MEDIA_TYPES}
"""Ends of the names of files."""

FIGURES = ("pdf", "svg", "png")
"""Formats of figures, which are those of ``slipfold plot``."""


def written(result: Result, form: str) -> bytes:
    """Return the content of a file that a result writes."""
    with tempfile.TemporaryDirectory(prefix="slipfold-") as folder:
        path = Path(folder) / "result"
        (result.save if form == "nc" else result.to_csv)(path)
        return path.read_bytes()


def modes_table(orbit: PeriodicOrbit, jacobian: Array) -> bytes:
    """Return an equilibrium as a spreadsheet, a row a mode. Shapes: jacobian (n, n)."""
    modes, states = modes_of(jacobian), zip(orbit.model.states, orbit.state, strict=True)
    columns = dict(zip(MODE_UNITS, modes.T, strict=True))
    columns |= {item.name: np.full(len(modes), value) for item, value in states}
    units = MODE_UNITS | {item.name: item.unit for item in orbit.model.states}
    return Frame(columns, units).to_csv().encode()


def figure(
    result: Result,
    view: DrawnRequest,
    form: str,
    pinned: Mapping[str, Diagram] = MappingProxyType({}),
    measured: Measurement | None = None,
) -> bytes:
    """Return a figure of a view, as ``slipfold plot``; with other responses and a measurement."""
    # Drawing takes long to load, and most requests do without it.
    from slipfold.plots.response import draw_family, draw_measured, name_family
    from slipfold.plots.style import drawn

    def draw(ax: Axes) -> None:
        if pinned:
            diagrams = [cast(Diagram, result), *pinned.values()]
            shown, measure = cast(DiagramRequest, view).show, cast(DiagramRequest, view).statistic
            draw_family(diagrams, shown, measure, ax)
            if measured is not None:
                draw_measured(ax, measured, measure, shown)
                ax.legend()
            name_family(ax, diagrams, ["current", *pinned], shown, measure)
        elif isinstance(view, DiagramRequest):
            result.plot(view.show, measure=view.statistic, measured=measured, ax=ax)
        elif isinstance(view, SimulationRequest):
            result.plot(view.show or result.model.shown[0], ax=ax)
        elif isinstance(view, PlaneRequest):
            result.plot(ax=ax)
        else:
            raise InputError("there is no figure of one orbit; save its pictures as SVG or PNG")

    return drawn(draw, form)


def _filed_model(model: Model, file: Path) -> Structure:
    """Return the structure that a file holds, with the values that it has there."""
    result = Structure.from_toml(file)
    if result.kind != model.kind:
        raise InputError(
            f"{file} holds another structure than when the page was opened; open it again"
        )
    return result


_CLASS, _PUBLIC = re.compile(r"\b([A-Z]\w*)\("), r"sf.\1("
"""Names of classes in what a friction law prints, and the same as public names."""


def python_text(
    model: Model, view: DrawnRequest, file: Path | None = None, measurements: str | None = None
) -> str:
    """Return a script that computes and draws what a view shows, with measurements of a file.

    >>> from slipfold.interface.explorer.messages import parse_request
    >>> view = parse_request(
    ...     '{"kind": "diagram", "id": 1, "model": "sliding", "vary": "Nd", "span": [0, 0.98],'
    ...     ' "show": "x"}'
    ... )
    >>> print(python_text(SlidingOscillator(), view))
    import slipfold as sf
    <BLANKLINE>
    model = sf.SlidingOscillator()
    diagram = sf.response(model, vary="Nd", span=(0.0, 0.98), gaps=True)
    print(diagram.summary())
    diagram.plot("x", measure="max").figure.savefig("diagram.svg")
    <BLANKLINE>
    """
    if isinstance(view, OrbitRequest):
        if not isinstance(view.at, OrbitThrough):
            raise InputError(
                "this orbit is not found again from its state alone, as where a branch ends at a "
                "limit of its model; choose one beside it"
            )
        model = model.replace(**{view.vary: view.at.value})
    steps = "\n".join(_steps(model, view, measurements))
    used = "".join(f"{line}\n" for name, line in IMPORTS.items() if name in steps)
    head = f"{used}\n" if used else ""
    return f"{head}import slipfold as sf\n\nmodel = {_model(model, file, view.text)}\n{steps}\n"


# By what a script uses of them
IMPORTS = {"np.": "import numpy as np", "Figure(": "from matplotlib.figure import Figure"}


def _steps(model: Model, view: DrawnRequest, measurements: str | None) -> list[str]:
    if isinstance(view, DiagramRequest):
        span = f"({view.span[0]!r}, {view.span[1]!r})"
        read = f"measured = sf.read_measurement({measurements!r}, model)"
        also = f", also={[start.along(view.vary) for start in view.also]!r}"
        return [
            f'diagram = sf.response(model, vary="{view.vary}", span={span}'
            f"{also if view.also else ''}, gaps=True)",
            "print(diagram.summary())",
            *([read] if measurements else []),
            f'diagram.plot("{view.show}", measure="{view.statistic}"'
            f'{", measured=measured" if measurements else ""}).figure.savefig("diagram.svg")',
        ]
    if isinstance(view, PlaneRequest):
        window = (
            f"(({view.x.span[0]!r}, {view.x.span[1]!r}), ({view.y.span[0]!r}, {view.y.span[1]!r}))"
        )
        plane = f'("{view.x.name}", "{view.y.name}")'
        return [
            f"result = sf.bifurcation_set(model, {plane}, {window})",
            "print(result.summary())",
            'result.plot().figure.savefig("plane.svg")',
        ]
    if isinstance(view, SimulationRequest):
        run, periods = run_of(model, view)
        takes = "" if periods is None else f", periods={periods}"
        takes += f", state={start_of(model, view)!r}"
        if periods is not None and not model.forced:
            takes += f", duration={run.values['duration']!r}"
        return [
            f"solution = sf.simulate(model{takes})",
            "print(solution.summary())",
            f'solution.plot("{view.show or model.shown[0]}").figure.savefig("solution.svg")',
        ]
    if isinstance(view, SweepRequest):
        return _sweep_steps(model, view)
    at = cast(OrbitThrough, view.at)  # what is left is an orbit
    if at.period is None:
        return _modes_of_equilibrium(model, at.state)
    takes = f"period={at.period}" if at.duration is None else f"duration={at.duration!r}"
    return [
        f"orbit = sf.periodic_orbit(model, state={at.state!r}, {takes})",
        "print(orbit.multipliers, orbit.stable)",
        "time, states = orbit.sample()",
    ]


def _modes_of_equilibrium(model: Model, state: dict[str, float]) -> list[str]:
    """Return the Python for the modes of an equilibrium, which may be a fold or a branch point."""
    return [
        f"state = {initial_state(model, state).tolist()!r}",
        "values = np.linalg.eigvals(model.jacobian(state))",
        'print("eigenvalues (1/s):", values)',
        'print("frequencies (Hz):", abs(values.imag) / (2 * np.pi))',
        'print("damping ratios:", -values.real / np.maximum(abs(values), 1e-300))',
    ]


def _sweep_steps(model: Model, view: SweepRequest) -> list[str]:
    """Return the Python that follows the same motions."""
    begin, span = view.begin, f"{min(view.span)!r}, {max(view.span)!r}, {view.points}"
    if begin is None:
        ways = [f"np.linspace({span})" + ("" if run == "up" else "[::-1]") for run in view.runs]
    else:
        ways = [
            f"np.linspace({begin!r}, {float(values[-1])!r}, {len(values)})"
            for values in values_of_runs(model, view).values()
        ]
    runs = ", ".join(f'"{run}": {way}' for run, way in zip(view.runs, ways, strict=True))
    unit = "" if model.forced else f", duration={swept_model(model, view).values['duration']!r}"
    each = '*solution.extrema("{}", "{}")'
    found = ", ".join(each.format(view.show, part) for part in parts_of(view.statistic))
    return [
        f"runs = {{{runs}}}",
        f"start = state = {start_of(model, view)!r}",
        "swept = {}",
        "for run, values in runs.items():",
        *([] if begin is None else ["    state = start"]),
        "    swept[run] = []",
        "    for value in values.tolist():",
        "        motion = state",
        f"        for periods in {PARTS}:",
        f"            solution = sf.simulate(model, periods, motion, {view.vary}=value{unit})",
        "            motion = solution.states[-1]",
        "            if solution.stopped or solution.settlement.settled:",
        "                break",
        "        if solution.stopped:",
        '            print(f"swept {run}, it ended: {solution.stopped.reason}")',
        "            break",
        "        state = motion",
        f"        swept[run] += [(value, y) for y in np.unique([{found}]).tolist()]",
        "ax = Figure().subplots()",
        "for run, places in swept.items():",
        '    ax.plot(*np.reshape(places, (-1, 2)).T, ".", label=f"swept {run}")',
        "ax.legend()",
        'ax.figure.savefig("sweep.svg")',
    ]


def _model(model: Model, file: Path | None, text: str | None = None) -> str:
    """Return an expression that makes a model; numbers are exact when read back."""
    values = _values(model)
    if isinstance(model, SlidingOscillator):
        law = model.structure.get("friction")
        friction = [] if law is None else [f"friction={_CLASS.sub(_PUBLIC, repr(law))}"]
        return f"sf.SlidingOscillator({', '.join([*friction, *([values] if values else [])])})"
    if is_built_in(model):
        return f'sf.built_in_models()["{model.name}"]({values})'
    if isinstance(model, Unforced):
        forced = f"sf.Unforced({_model(model.forced_model, file)})"
        own = DURATION.name
        changed = model.values[own] != DURATION.default
        return f"{forced}.replace({own}={model.values[own]!r})" if changed else forced
    assert isinstance(model, System | Structure)  # a page has no others
    usual: Model
    if file is None or isinstance(model, System):
        own, usual = whole_text(model, text)
        made = f"sf.{type(model).__name__}.from_toml({_quoted(own)})"
    else:
        usual = _filed_model(model, file)
        made = f"sf.Structure.from_toml({str(file)!r})"
    values = _values(model, usual)
    return f"{made}.replace({values})" if values else made


def _values(model: Model, usual: Model | None = None) -> str:
    return ", ".join(f"{name}={value!r}" for name, value in changed_values(model, usual).items())


def _quoted(text: str) -> str:
    """Return a literal of a text of several lines; quotes and backslashes stay what they are."""
    if "'''" in text or text.endswith("'"):
        return repr(text)
    return f"r'''\n{text}'''"


def toml_text(model: Model, view: DrawnRequest, file: Path | None = None) -> str:
    """Return a case file; its first line is the command that computes what the view shows.

    >>> from slipfold.interface.explorer.messages import parse_request
    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
    >>> view = parse_request(
    ...     '{"kind": "diagram", "id": 1, "model": "sliding", "vary": "Nd", "span": [0, 0.98],'
    ...     ' "show": "x"}'
    ... )
    >>> print(toml_text(SlidingOscillator(f=12.2), view))
    # slipfold response case.toml --vary Nd=0.0:0.98 --gaps
    model = "sliding"
    <BLANKLINE>
    [parameters]
    f = 12.2
    <BLANKLINE>
    """
    if isinstance(view, OrbitRequest):
        raise InputError(
            "no command computes a single orbit from a case file; copy it as Python instead"
        )
    if isinstance(view, SweepRequest):
        raise InputError("no command computes a sweep of the page; copy it as Python instead")
    command = _command(model, view)
    if is_built_in(model) or not isinstance(model, System | Structure):
        return f"# {command}\n{case_text(model, changed_values(model))}"
    if isinstance(model, Structure) and file is not None:
        changed = changed_values(model, _filed_model(model, file))
        case = {"model": str(file), **({"parameters": changed} if changed else {})}
        return f"# {command}\n{write_tables(case)}"
    # The values of a definition are its own, so the command changes them.
    own, usual = whole_text(model, view.text)
    changed = changed_values(model, usual)
    sets = "".join(f" --set {name}={value!r}" for name, value in changed.items())
    return f"# {command}{sets}\n{own}"


def _command(model: Model, view: DrawnRequest) -> str:
    if isinstance(view, DiagramRequest):
        also = "".join(
            f" --also {','.join(f'{k}={v!r}' for k, v in start.along(view.vary).items())}"
            for start in view.also
        )
        return f"slipfold response case.toml --vary {_ends(view.vary, view.span)}{also} --gaps"
    if isinstance(view, PlaneRequest):
        axes = " ".join(f"--vary {_ends(axis.name, axis.span)}" for axis in (view.x, view.y))
        regions = model.forced and not refusal(check_followed, model)
        return f"slipfold locus case.toml {axes}{' --regions' if regions else ''}"
    assert isinstance(view, SimulationRequest)  # orbits were refused
    start = start_of(model, view)
    states = "".join(f" --state {name}={value!r}" for name, value in start.items())
    run, periods = run_of(model, view)
    takes = "" if periods is None else f" --periods {periods}"
    if periods is not None and not model.forced:
        states += f" --set duration={run.values['duration']!r}"
    return f"slipfold simulate case.toml{takes}{states}"


def _ends(name: str, span: tuple[float, float]) -> str:
    return f"{name}={span[0]!r}:{span[1]!r}"
