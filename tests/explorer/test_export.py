"""What is copied or saved makes what is shown: texts are run, files are read back."""

import csv
import io
import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

import slipfold as sf
from helpers.command_line import run
from helpers.dry_friction import FORCED_SLIDER
from helpers.explorer_models import BRAKE
from helpers.explorer_server import BASE, answers_to, diagram
from helpers.long_tests import long_except
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
    parse_request,
)
from slipfold.interface.explorer.plain import short
from slipfold.interface.explorer.settings import PAGE
from slipfold.models.registry import built_in_models, model_of_text

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
FREE_SIMULATION = {**SIMULATION, "model": "rayleigh", "parameters": {"e": 0.7}, "start": "rest"}
FREE_SIMULATION |= {"text": FILES["rayleigh"].read_text(), "perturbation": {"x": 0.1}, "show": "x"}
BELT = {"kind": "simulation", "id": 1, "model": "steady-sliding", "start": {"x": 0.1}}
PLANE = {
    "kind": "plane",
    "id": 1,
    "model": "sliding",
    "parameters": {},
    "x": {"name": "f", "span": [12.4, 12.5]},
    "y": {"name": "Nd", "span": [0, 0.06]},
}
FREE_PLANE = {
    **PLANE,
    "model": "stuart-landau",
    "x": {"name": "r", "span": [-1, 1]},
    "y": {"name": "w", "span": [0.5, 2]},
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


def exporting(given, file=None):
    answering = Answering(Catalogue(given, file))

    def export(view, form):
        request = ExportRequest.model_validate({"view": view, "format": form})
        return answering.export(request, lambda: None)

    return export


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


def run_python(text, folder, monkeypatch):
    monkeypatch.chdir(folder)
    names = {}
    exec(compile(text, "copied.py", "exec"), names)
    return names


@pytest.mark.parametrize("view", [DIAGRAM, DUFFING, OWN], ids=["sliding", "duffing", "own"])
def test_copied_python_draws_the_same_curve(exported, view, tmp_path, monkeypatch, capsys):
    names = run_python(exported(view, "python").decode(), tmp_path, monkeypatch)
    (tmp_path / "saved.nc").write_bytes(exported(view, "nc"))
    saved = sf.load(tmp_path / "saved.nc")
    assert names["diagram"].model == saved.model
    for mine, theirs in zip(names["diagram"].branches, saved.branches, strict=True):
        np.testing.assert_array_equal(mine.parameter, theirs.parameter)
        np.testing.assert_array_equal(mine.nodes, theirs.nodes)
    assert "<svg" in (tmp_path / "diagram.svg").read_text()
    assert "TY" in capsys.readouterr().out


@pytest.mark.parametrize("view", [DIAGRAM, FREE_PLANE, SIMULATION], ids=lambda view: view["kind"])
def test_figures_are_those_of_the_package(exported, view):
    assert exported(view, "pdf").startswith(b"%PDF")


def test_one_orbit_has_no_figure(exported):
    with pytest.raises(InputError, match="there is no figure of one orbit; save its pictures as"):
        exported(ORBIT, "pdf")
    with pytest.raises(InputError, match="has no state, from which a script finds it"):
        exported(ORBIT, "python")


def test_the_copied_case_of_a_structures_file_names_it(of_file, tmp_path, monkeypatch):
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


def test_a_case_with_a_friction_law_is_copied(tmp_path, monkeypatch, capsys):
    file = tmp_path / "given.toml"
    file.write_text(STEADY)
    model = find_model(str(file), {})
    export = exporting(model, equations_file(str(file)))
    view = diagram(model="steady-sliding", parameters={"mu_k": 0.4}, vary="Vd", span=[0.6, 0.5])
    (tmp_path / "case.toml").write_text(export(view, "toml").decode())
    assert find_model(str(tmp_path / "case.toml"), {}) == model.replace(mu_k=0.4)
    names = run_python(export(view, "python").decode(), tmp_path, monkeypatch)
    assert names["model"] == model.replace(mu_k=0.4)


MODELS = dict.fromkeys(built_in_models()) | FILES
EACH = long_except(MODELS, ("duffing", "stuart-landau", "chain"))
"""Often folds of a response, a Hopf point and a structure."""


@pytest.mark.parametrize("name", EACH)
def test_copies_of_every_model_give_its_numbers_to_all_digits(name, tmp_path, monkeypatch, capsys):
    text = MODELS[name].read_text() if MODELS[name] else None
    model = built_in_models()[name]() if text is None else model_of_text(text)
    changed = model.replace(**{item.name: 0.97 * model.values[item.name] for item in small(model)})
    values = {item.name: changed.values[item.name] for item in model.variable_parameters}
    view = {**SIMULATION, "model": name, "text": text, "parameters": values, "periods": 2}
    view |= {"start": "rest", "perturbation": {model.states[0].name: 1e-9}, "show": None}
    export = exporting(None)
    names = run_python(export(view, "python").decode(), tmp_path, monkeypatch)
    assert names["model"] == changed
    (tmp_path / "saved.nc").write_bytes(export(view, "nc"))
    saved = sf.load(tmp_path / "saved.nc")
    np.testing.assert_array_equal(names["solution"].states, saved.states)
    case = export(view, "toml").decode()
    (tmp_path / "case.toml").write_text(case)
    sets = re.findall(r"--set (\w+)=(\S+)", case.splitlines()[0])
    assert find_model(str(tmp_path / "case.toml"), dict(sets)) == saved.model


def small(model):
    """Parameters that may be made smaller by some per cent."""
    return [item for item in model.variable_parameters[:3] if item.lower <= 0]


@pytest.mark.parametrize(
    "view",
    [DIAGRAM, DUFFING, OWN, SIMULATION, FREE_SIMULATION, BELT],
    ids=["sliding", "duffing", "own", "simulation", "autonomous", "belt"],
)
def test_the_command_in_a_copied_case_file_gives_the_same_numbers(
    exported, view, tmp_path, monkeypatch
):
    text = exported(view, "toml").decode()
    (tmp_path / "case.toml").write_text(text)
    monkeypatch.chdir(tmp_path)
    program, *arguments = shlex.split(text.splitlines()[0].removeprefix("# "))
    assert program == "slipfold"
    assert run(*arguments, "--out", "run.nc").exit_code == 0
    (tmp_path / "saved.nc").write_bytes(exported(view, "nc"))
    ours, theirs = sf.load("saved.nc"), sf.load("run.nc")
    assert ours.model == theirs.model
    ours, theirs = ours.to_xarray(), theirs.to_xarray()
    for name in ours.data_vars:
        np.testing.assert_array_equal(ours[name].values, theirs[name].values)


@pytest.mark.parametrize("kind", ["forced", "cycle", "doubled", "equilibrium"])
def test_an_orbit_as_netcdf_is_the_same_when_loaded(exported, tmp_path, kind, monkeypatch, capsys):
    places = {"forced": (2, 0.3), "cycle": (2, 0.5), "doubled": (3, 0.5), "equilibrium": (1, 0.1)}
    free = {"kind": "orbit", "id": 1, "model": "stuart-landau", "vary": "r", "span": [-1, 1]}
    doubled = {**free, "model": "roessler", "vary": "c", "span": [2.5, 3]}
    at = dict(zip(("branch", "arclength"), places[kind], strict=True))
    view = {**{"forced": ORBIT, "doubled": doubled}.get(kind, free), "at": at}
    (tmp_path / "orbit.nc").write_bytes(exported(view, "nc"))
    orbit = sf.load(tmp_path / "orbit.nc")
    table = list(csv.reader(io.StringIO(exported(view, "csv").decode())))
    values = [float(value) for value in table[1]]
    placed = {**view, "at": answers_to(view)[-1]["through"]}
    copied = run_python(exporting(None)(placed, "python").decode(), tmp_path, monkeypatch)
    if kind == "equilibrium":
        assert copied["values"].real.tolist() == pytest.approx([values[0]] * 2, rel=1e-12)
        assert "frequencies (Hz): [0.159154" in capsys.readouterr().out
        (r, frequency, damping, *state), value = values, orbit.model.values["r"]
        assert table[0][:3] == ["growth rate (1/s)", "frequency (Hz)", "damping ratio"]
        assert [r, frequency] == pytest.approx([value, 0.5 / np.pi], rel=1e-12)
        assert damping == pytest.approx(-value / np.hypot(value, 1), rel=1e-12)
    else:
        state = values[1 : 1 + len(orbit.state)]
        assert copied["orbit"].duration == pytest.approx(orbit.duration, rel=1e-12)
        assert copied["orbit"].state == pytest.approx(orbit.state, rel=1e-8)
    assert state == orbit.state.tolist()
    # From its nodes alone it has the duration and the multipliers that it was saved with.
    assert orbit.check().passed


@pytest.mark.parametrize(
    "view", [SIMULATION, FREE_SIMULATION, BELT], ids=lambda view: view["model"]
)
def test_copied_python_gives_the_motion_that_is_shown(
    exported, view, tmp_path, monkeypatch, capsys
):
    script = exported(view, "python").decode()
    assert view is not SIMULATION or 'solution.plot("y")' in script
    names = run_python(script, tmp_path, monkeypatch)
    (tmp_path / "saved.nc").write_bytes(exported(view, "nc"))
    states, shown = names["solution"].states, answers_to(view)[-2]
    np.testing.assert_array_equal(states, sf.load(tmp_path / "saved.nc").states)
    assert states[-1].tolist() == [*shown["last"].values()]
    assert len(states) - 1 == shown["sections"]["count"] * shown["sections"]["periods"]


@pytest.mark.parametrize(
    "view",
    [pytest.param(PLANE, marks=pytest.mark.long), FREE_PLANE],
    ids=["forced", "autonomous"],
)
def test_copied_python_gives_the_same_plane(exported, view, tmp_path, monkeypatch, capsys):
    names = run_python(exported(view, "python").decode(), tmp_path, monkeypatch)
    (tmp_path / "saved.nc").write_bytes(exported(view, "nc"))
    saved = sf.load(tmp_path / "saved.nc")
    assert saved.loci
    for mine, theirs in zip(names["result"].loci, saved.loci, strict=True):
        np.testing.assert_array_equal(mine.values, theirs.values)


SWEEPS = {
    "forced": {"model": "sliding", "vary": "Nd", "span": [0.05, 0.15], "parameters": {"f": 12.2}},
    "cycle": {"model": "vanderpol-free", "vary": "mu", "span": [1.0, 0.5], "begin": 0.8},
    "limit": {"model": "sliding", "vary": "Nd", "span": [0.9, 1.3], "parameters": {"Ns": 1.5}},
}


@pytest.mark.parametrize("name", SWEEPS)
def test_copied_python_follows_the_same_motions(exported, name, tmp_path, monkeypatch, capsys):
    view = {"kind": "sweep", "id": 1, "points": 5, "show": "x", "statistic": "min", **SWEEPS[name]}
    *places, last = answers_to(view)
    names = run_python(exported(view, "python").decode(), tmp_path, monkeypatch)
    for way, copied in names["swept"].items():
        shown = {place["x"]: place["y"] for place in places if place["run"] == way}
        assert {x: short([y for at, y in copied if at == x]) for x, _ in copied} == shown
    printed = capsys.readouterr().out
    assert [way for way in names["swept"] if f"swept {way}, it ended" in printed] == [*last["ends"]]
    assert "<svg" in (tmp_path / "sweep.svg").read_text()


def test_a_sweep_is_no_file(exported):
    view = {"kind": "sweep", "id": 1, "show": "x", **SWEEPS["forced"]}
    for form in ("csv", "toml"):
        with pytest.raises(InputError, match="copy it as Python"):
            exported(view, form)


def first_view(name):
    """What the page shows of a model at first, and its plane."""
    own = MODELS[name] and MODELS[name].read_text()
    models = Catalogue().describe() if own is None else [Catalogue().described(own, name)]
    described = next(item for item in models if own or item["name"] == name)
    view = {key: described["default"][key] for key in ("parameters", "vary", "span", "show")}
    axes = [{"name": p["name"], "span": [p["low"], p["high"]]} for p in described["parameters"]]
    usual = dict(zip(("x", "y"), axes, strict=False))
    whole = {"model": described["name"], "text": own, "id": 1}
    return {**whole, **view}, {**whole, **(described["plane"] or usual)}


@pytest.mark.parametrize("name", EACH)
def test_copied_python_of_a_first_view_gives_all_its_numbers(name, tmp_path, monkeypatch, capsys):
    view, answering = {"kind": "diagram", **first_view(name)[0]}, Answering(Catalogue())
    shown, export = answers_to(view, answering)[-1], exporting(None)
    names = run_python(export(view, "python").decode(), tmp_path, monkeypatch)
    copied = diagram_view(names["diagram"], view.pop("show"), shown["y"]["statistic"])
    assert copied["branches"] == shown["branches"]
    for branch in shown["branches"]:
        middle = branch["arclength"][len(branch["arclength"]) // 2]
        for place in [middle, *(point["arclength"] for point in branch["special"])]:
            at = {"branch": branch["id"], "arclength": place}
            orbit = answers_to({**view, "kind": "orbit", "at": at}, answering)[-1]
            placed = {**view, "kind": "orbit", "at": orbit["through"]}
            names = run_python(export(placed, "python").decode(), tmp_path, monkeypatch)
            if orbit["through"]["period"] is None:
                values = [complex(*value) for value in orbit["eigenvalues"]]
                np.testing.assert_array_equal(*map(np.sort_complex, (names["values"], values)))
            else:
                state = [*orbit["through"]["state"].values()]
                size = np.abs(state).max() * max(1.0, abs(complex(*orbit["multipliers"][0])))
                assert names["orbit"].state == pytest.approx(state, rel=0, abs=1e-11 * size)


@pytest.mark.long
@pytest.mark.parametrize("name", MODELS)
def test_copied_python_of_a_sweep_and_a_plane_of_every_model_runs(
    name, tmp_path, monkeypatch, capsys
):
    view, plane = first_view(name)
    export = exporting(None)
    sweep = {"kind": "sweep", "points": 3, **view}
    answers, request = answers_to(sweep), parse_request(json.dumps(sweep))
    swept = run_python(export(sweep, "python").decode(), tmp_path, monkeypatch)["swept"]
    copied = [value for way in ("up", "down") for value, _ in swept[way]]
    assert [place["x"] for place in answers[:-1] for _ in place["y"]] == copied
    if "y" not in plane:
        return
    text = export({"kind": "plane", **plane}, "python").decode()
    # A plane takes minutes for some models; the numbers of two are compared above.
    monkeypatch.setattr(sf, "bifurcation_set", lambda *args, **options: (args, options))
    first, second = plane["x"], plane["y"]
    (model, axes, window), options = run_python(text.split("print")[0], tmp_path, monkeypatch)[
        "result"
    ]
    assert model == (Catalogue().of(request) if view["text"] else built_in_models()[name]())
    assert axes == (first["name"], second["name"])
    assert window == (tuple(first["span"]), tuple(second["span"]))
    assert options == {}  # as those of the plane that is shown


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
def test_copied_texts_follow_what_motions_settle_on(slider, tmp_path, monkeypatch, capsys):
    rows = list(csv.reader(io.StringIO(slider(STICKS, "csv").decode())))
    names = run_python(slider(STICKS, "python").decode(), tmp_path, monkeypatch)
    first, sticks = names["diagram"].branches[:2]
    assert first.parameter.max() == 1.2
    assert sticks.stuck_fraction.max() > 0
    names["diagram"].to_csv(tmp_path / "own.csv")
    assert list(csv.reader((tmp_path / "own.csv").read_text().splitlines())) == rows
    case = slider(STICKS, "toml").decode()
    (tmp_path / "case.toml").write_text(case)
    command = shlex.split(case.splitlines()[0].removeprefix("# slipfold "))
    assert "--also" in command
    assert run(*command, "--csv", "again.csv").exit_code == 3  # branches end
    assert list(csv.reader((tmp_path / "again.csv").read_text().splitlines())) == rows


@pytest.mark.parametrize(("slip", "regions"), [("Vd - v", True), ("-v", False)])
def test_a_copied_command_asks_for_the_regions_that_there_may_be(slip, regions):
    model = sf.System.from_toml(FORCED_SLIDER.replace("Vd - v", slip))
    axes = {"x": {"name": "F", "span": [0.1, 0.2]}, "y": {"name": "W", "span": [1, 1.1]}}
    case = exporting(model)({**PLANE, "model": model.name, **axes}, "toml").decode()
    assert ("--regions" in case.splitlines()[0]) == regions
