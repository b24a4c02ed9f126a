"""What is copied or saved makes what is shown: texts are run, files are read back."""

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest

import slipfold as sf
from helpers.copied import has_orbit, run_command, run_python, same_orbit, same_result
from helpers.dry_friction import FORCED_SLIDER
from helpers.explorer_models import BRAKE
from helpers.explorer_server import BASE, answers_to, diagram
from helpers.long_tests import long_except
from helpers.ways_out import RESULTS, has_numbers
from slipfold import InputError
from slipfold.interface.cli.reading import equations_file, find_model
from slipfold.interface.explorer.answering import Answering
from slipfold.interface.explorer.catalogue import Catalogue
from slipfold.interface.explorer.curves import diagram_view
from slipfold.interface.explorer.messages import (
    DiagramRequest,
    ExportRequest,
    OrbitRequest,
    PlaneRequest,
)
from slipfold.interface.explorer.plain import short
from slipfold.interface.explorer.settings import PAGE
from slipfold.models.registry import built_in_models

FILES = {item.stem: item for item in sorted(Path(__file__).parent.glob("models/*.toml"))}
VALUES = {"f": 12.2, "Vd": 0.1 + 0.5}
DIAGRAM = diagram(parameters={**VALUES, "Nd": 0.5}, span=[0, 0.3], show="y", statistic="modulus")
ORBIT = {"kind": "orbit", "id": 1, **BASE, "at": {"branch": 2, "arclength": 0.3}}
SIMULATION = {
    "kind": "simulation",
    "id": 1,
    "model": "sliding",
    "parameters": {**VALUES, "Nd": 0.15},
    "start": {"x": 0.1},
    "perturbation": {"vy": 0.5},
    "periods": 50,
    "show": "y",
}
BELT = {"kind": "simulation", "id": 1, "model": "steady-sliding", "start": {"x": 0.1}}
PLANE = {
    "kind": "plane",
    "id": 1,
    "model": "sliding",
    "parameters": {},
    "x": {"name": "f", "span": [12.4, 12.5]},
    "y": {"name": "Nd", "span": [0, 0.06]},
}
SYSTEM = """
name = "own"
title = 'it''s "own"'
[parameters]
W = { value = 0.9, unit = "rad/s", above = 0 }
F = { value = 0.18 }
[states]
q = { rate = "v" }
v = { rate = "F*cos(W*t) - 0.05*v - q - 0.1*q^3" }
[forcing]
period = "2*pi/W"
""".replace("'it''s \"own\"'", '"one\'s own"')
DUFFING = diagram(model="duffing", parameters={"F": 0.17}, vary="W", span=[0.8, 1.4], show="q")
OWN = {**DUFFING, "model": "own", "statistic": "max_and_min"}
CHANGED = f"{BRAKE}[parameters]\nmu_s = 0.7\n"
STICKS = diagram(
    model="forced slider",
    parameters={"F": 0.7},
    vary="Vd",
    span=[1.2, 0.5],
    also=[
        {"value": 0.55, "state": {"x": 0.1}},
        {"value": 1.1, "state": {"x": 0.2, "v": -1.0}, "period": 1},
    ],
)
BRAKES = diagram(model="brake", parameters={"mu_s": 0.6}, vary="Vd", span=[2, 0.7], show="tip")


@pytest.fixture(autouse=True, scope="module")
def unhurried():
    """The page ends what takes long where it is: ends would depend on the load of the machine."""
    with pytest.MonkeyPatch.context() as patch:
        for request in (DiagramRequest, OrbitRequest, PlaneRequest):
            patch.setattr(request, "seconds", np.inf)
        for name in ("following", "filling", "loci"):
            patch.setattr(PAGE, name, np.inf)
        yield


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """What scripts and commands write goes into a folder of its own."""
    monkeypatch.chdir(tmp_path)


def exporting(given, file=None):
    answering = Answering(Catalogue(given, file))

    def export(view, form):
        request = ExportRequest.model_validate({"view": view, "format": form})
        return answering.export(request, lambda: None)

    return export


def saved(export, view):
    """Load what is saved as netCDF."""
    Path("saved.nc").write_bytes(export(view, "nc"))
    return sf.load("saved.nc")


@pytest.fixture(scope="module")
def exported():
    return exporting(sf.System.from_toml(SYSTEM))


@pytest.fixture
def of_file(tmp_path):
    """A structure from a file whose path needs care; the page changes what the file changes."""
    file = tmp_path / 'one\'s "own".toml'
    file.write_text(CHANGED)
    return exporting(find_model(str(file), {}), equations_file(str(file)))


@pytest.fixture(scope="module")
def slider():
    return exporting(sf.System.from_toml(FORCED_SLIDER))


CYCLE = {"value": 0.8, "state": {"x": 2.0, "v": 0.0}, "period": 1, "duration": 6.4}
FOLLOWED = diagram(model="vanderpol-free", parameters={}, vary="mu", span=[0.5, 1], also=[CYCLE])
VIEWS = {"sliding": DIAGRAM, "duffing": DUFFING, "own": OWN, "followed": FOLLOWED}
VIEWS |= {"simulation": SIMULATION, "belt": BELT}


@pytest.mark.parametrize("name", long_except(VIEWS, {*VIEWS} - {"duffing"}))
def test_what_is_copied_and_saved_has_the_numbers_that_are_shown(exported, name, capsys):
    view = VIEWS[name]
    kind, result = view["kind"], saved(exported, view)
    answers = answers_to(view, Answering(Catalogue(sf.System.from_toml(SYSTEM))))
    has_numbers(kind, result, [it for it in answers if {"branches", "last"} & {*it}][-1])
    copied = run_python(exported(view, "python").decode())[RESULTS[kind]]
    assert copied.summary() in capsys.readouterr().out
    same_result(copied, result)
    assert "<svg" in Path(f"{RESULTS[kind]}.svg").read_text()
    same_result(run_command(exported(view, "toml").decode()), result)


def test_one_orbit_has_no_figure(exported):
    with pytest.raises(InputError, match="there is no figure of one orbit; save its pictures as"):
        exported(ORBIT, "pdf")
    with pytest.raises(InputError, match="this orbit is not found again from its state alone"):
        exported(ORBIT, "python")


def test_the_copied_case_of_a_structures_file_names_it(of_file, tmp_path):
    text = of_file(BRAKES, "toml").decode()
    case = tmp_path / "case.toml"
    case.write_text(text)
    model = find_model(str(case), {})
    assert model == find_model(str(tmp_path / 'one\'s "own".toml'), {"mu_s": "0.6"})
    assert text.startswith("# slipfold response case.toml --vary Vd=2.0:0.7 --gaps\n")


def test_a_file_that_has_changed_is_not_copied(of_file, tmp_path):
    (tmp_path / 'one\'s "own".toml').write_text(CHANGED.replace("2000", "3000"))
    for form in ("python", "toml"):
        with pytest.raises(InputError, match="holds another structure than when the page was open"):
            of_file(BRAKES, form)


STEADY = 'model = "steady-sliding"\nfriction = { law = "Regularized", of = "Coulomb", e = 0.01 }\n'


def test_a_case_with_a_friction_law_is_copied():
    Path("given.toml").write_text(STEADY)
    model = find_model("given.toml", {})
    export = exporting(model, equations_file("given.toml"))
    view = diagram(model="steady-sliding", parameters={"mu_k": 0.4}, vary="Vd", span=[0.6, 0.5])
    Path("case.toml").write_text(export(view, "toml").decode())
    assert find_model("case.toml", {}) == model.replace(mu_k=0.4)
    names = run_python(export(view, "python").decode())
    assert names["model"] == model.replace(mu_k=0.4)


OFTEN = ("duffing", "stuart-landau", "chain")
"""Folds of a response, a Hopf point and a structure."""


@pytest.mark.parametrize("name", OFTEN)
def test_copies_with_other_values_give_their_numbers_to_all_digits(name):
    model = built_in_models()[name]()
    changed = model.replace(**{item.name: 0.97 * model.values[item.name] for item in small(model)})
    values = {item.name: changed.values[item.name] for item in model.variable_parameters}
    view = {**SIMULATION, "model": name, "parameters": values, "periods": 2, "show": None}
    view |= {"start": "rest", "perturbation": {model.states[0].name: 1e-9}}
    export = exporting(None)
    names, result = run_python(export(view, "python").decode()), saved(export, view)
    assert names["model"] == changed
    same_result(names["solution"], result)
    same_result(run_command(export(view, "toml").decode()), result)


def small(model):
    """Parameters that may be made smaller by some per cent."""
    return [item for item in model.variable_parameters[:3] if item.lower <= 0]


@pytest.mark.parametrize("kind", ["forced", "first", "cycle", "doubled", "equilibrium"])
def test_an_orbit_as_netcdf_is_the_same_when_loaded(exported, kind, capsys):
    places = {
        "forced": (2, 0.3),
        "first": (2, 0.0),
        "cycle": (2, 0.5),
        "doubled": (3, 0.5),
        "equilibrium": (1, 0.1),
    }
    free = {"kind": "orbit", "id": 1, "model": "stuart-landau", "vary": "r", "span": [-1, 1]}
    doubled = {**free, "model": "roessler", "vary": "c", "span": [2.5, 3]}
    at = dict(zip(("branch", "arclength"), places[kind], strict=True))
    view = {**{"forced": ORBIT, "first": ORBIT, "doubled": doubled}.get(kind, free), "at": at}
    orbit = saved(exported, view)
    table = list(csv.reader(io.StringIO(exported(view, "csv").decode())))
    values = [float(value) for value in table[1]]
    shown = answers_to(view)[-1]
    placed = {**view, "at": shown["through"]}
    copied = run_python(exporting(None)(placed, "python").decode())
    if kind == "equilibrium":
        assert copied["values"].real.tolist() == pytest.approx([values[0]] * 2, rel=1e-12)
        assert "frequencies (Hz): [0.159154" in capsys.readouterr().out
        (r, frequency, damping, *state), value = values, orbit.model.values["r"]
        assert table[0][:3] == ["growth rate (1/s)", "frequency (Hz)", "damping ratio"]
        assert [r, frequency] == pytest.approx([value, 0.5 / np.pi], rel=1e-12)
        assert damping == pytest.approx(-value / np.hypot(value, 1), rel=1e-12)
    else:
        state = values[1 : 1 + len(orbit.state)]
        has_orbit(orbit, shown)
        same_orbit(copied, shown)
    assert state == orbit.state.tolist()
    # From its nodes alone it has the duration and the multipliers that it was saved with.
    assert orbit.check().passed


SWEEPS = {
    "forced": {"model": "sliding", "vary": "Nd", "span": [0.05, 0.15], "parameters": {"f": 12.2}},
    "cycle": {"model": "vanderpol-free", "vary": "mu", "span": [1.0, 0.5], "begin": 0.8},
    "limit": {"model": "sliding", "vary": "Nd", "span": [0.9, 1.3], "parameters": {"Ns": 1.5}},
}


@pytest.mark.parametrize("name", SWEEPS)
def test_copied_python_follows_the_same_motions(exported, name, capsys):
    view = {"kind": "sweep", "id": 1, "points": 5, "show": "x", "statistic": "min", **SWEEPS[name]}
    *places, last = answers_to(view)
    names = run_python(exported(view, "python").decode())
    for way, copied in names["swept"].items():
        shown = {place["x"]: place["y"] for place in places if place["run"] == way}
        assert {x: short([y for at, y in copied if at == x]) for x, _ in copied} == shown
    printed = capsys.readouterr().out
    assert [way for way in names["swept"] if f"swept {way}, it ended" in printed] == [*last["ends"]]
    assert "<svg" in Path("sweep.svg").read_text()


def test_a_sweep_is_no_file(exported):
    view = {"kind": "sweep", "id": 1, "show": "x", **SWEEPS["forced"]}
    for form in ("csv", "toml"):
        with pytest.raises(InputError, match="copy it as Python"):
            exported(view, form)


MODELS = dict.fromkeys(built_in_models()) | FILES


def first_view(name):
    """What the page shows of a model at first."""
    own = MODELS[name] and MODELS[name].read_text()
    models = Catalogue().describe() if own is None else [Catalogue().described(own, name)]
    described = next(item for item in models if own or item["name"] == name)
    view = {key: described["default"][key] for key in ("parameters", "vary", "span", "show")}
    return {"kind": "diagram", "id": 1, "model": described["name"], "text": own, **view}


@pytest.mark.parametrize("name", long_except(MODELS, OFTEN))
def test_copied_python_of_a_first_view_gives_all_its_numbers(name):
    view, answering = first_view(name), Answering(Catalogue())
    shown, export = answers_to(view, answering)[-1], exporting(None)
    names = run_python(export(view, "python").decode())
    copied = diagram_view(names["diagram"], view.pop("show"), shown["y"]["statistic"])
    assert copied["branches"] == shown["branches"]
    for branch in shown["branches"]:
        middle = branch["arclength"][len(branch["arclength"]) // 2]
        for place in [
            branch["arclength"][0],
            middle,
            *(point["arclength"] for point in branch["special"]),
        ]:
            at = {"branch": branch["id"], "arclength": place}
            orbit = answers_to({**view, "kind": "orbit", "at": at}, answering)[-1]
            placed = {**view, "kind": "orbit", "at": orbit["through"] if orbit["again"] else at}
            if not orbit["again"]:
                with pytest.raises(InputError, match="not found again from its state alone"):
                    export(placed, "python")
                continue
            same_orbit(run_python(export(placed, "python").decode()), orbit)


@pytest.mark.parametrize(("form", "name"), [("python", "py"), ("toml", "toml"), ("csv", "csv")])
def test_the_server_hands_files_over_with_names(explorer, form, name):
    with explorer.http() as http:
        answer = http.post("/api/export", json={"view": diagram(span=[0, 0.05]), "format": form})
    assert answer.status_code == 200
    assert answer.headers["content-disposition"] == f'attachment; filename="diagram.{name}"'


def test_what_cannot_be_exported_is_said_in_a_sentence(explorer):
    with explorer.http() as http:
        answer = http.post("/api/export", json={"view": ORBIT, "format": "toml"})
        assert (answer.status_code, answer.text) == (
            400,
            "no command computes a single orbit from a case file; copy it as Python instead",
        )
        malformed = http.post("/api/export", json={"view": {}, "format": "pickle"})
    assert malformed.status_code == 422
    assert json.loads(malformed.text)["detail"]


@pytest.mark.long
def test_copied_texts_follow_what_motions_settle_on(slider):
    first, sticks = (result := saved(slider, STICKS)).branches[:2]
    assert first.parameter.max() == 1.2
    assert sticks.stuck_fraction.max() > 0
    same_result(run_python(slider(STICKS, "python").decode())["diagram"], result)
    case = slider(STICKS, "toml").decode()
    assert "--also" in case.splitlines()[0]
    same_result(run_command(case, ends=(3,)), result)  # branches end
    result.to_csv("own.csv")
    assert Path("own.csv").read_bytes() == slider(STICKS, "csv")


@pytest.mark.parametrize(("slip", "regions"), [("Vd - v", True), ("-v", False)])
def test_a_copied_command_asks_for_the_regions_that_there_may_be(slip, regions):
    model = sf.System.from_toml(FORCED_SLIDER.replace("Vd - v", slip))
    axes = {"x": {"name": "F", "span": [0.1, 0.2]}, "y": {"name": "W", "span": [1, 1.1]}}
    case = exporting(model)({**PLANE, "model": model.name, **axes}, "toml").decode()
    assert ("--regions" in case.splitlines()[0]) == regions
