"""Requests over the WebSocket and their answers, with the real solver."""

import math
from itertools import pairwise

import pytest

import slipfold as sf
from helpers.dry_friction import FORCED_SLIDER
from helpers.explorer_server import BASE, SLOW_PLANE, answers_to, diagram
from slipfold.interface.explorer.answering import Answering
from slipfold.interface.explorer.catalogue import Catalogue
from slipfold.interface.explorer.curves import LONG, GapsProgress
from slipfold.interface.explorer.messages import DiagramRequest, ExportRequest, PlaneRequest
from slipfold.interface.explorer.settings import PAGE
from slipfold.progress import Progress

ORBIT = {"kind": "orbit", "id": 2, **BASE}


@pytest.fixture(scope="module")
def base():
    return sf.response(sf.SlidingOscillator(f=12.5), "Nd", (0, 0.98))


def test_a_diagram_has_the_branches_and_bifurcations_of_the_response(client, base):
    answer = client.ask(diagram())
    assert "moved" not in answer
    assert [b["period"] for b in answer["branches"]] == [b.period for b in base.branches]
    for shown, branch in zip(answer["branches"], base.branches, strict=True):
        assert shown["stopped"]["reason"] == branch.stopped.reason
        for mark, point in zip(shown["special"], branch.special, strict=True):
            assert (mark["type"], mark["criticality"]) == (point.type, point.criticality)
            assert mark["value"] == pytest.approx(point.value, rel=1e-12)
            assert point.name in mark["sentence"]
            assert (point.leads_to is None) == ("leaves here" not in mark["sentence"])


def test_values_that_cannot_be_had_are_reported_without_computing(explorer):
    asked = {"model": "sliding", "parameters": {"Nd": 5.0, "Ns": 1.0}}
    with explorer.http() as http:
        assert "not below Ns" in http.post("/api/values", json=asked).json()["Nd"]
        unknown = http.post("/api/values", json={**asked, "model": "nothing"})
    assert (unknown.status_code, "no model 'nothing'" in unknown.text) == (400, True)


def test_lines_are_whole_and_marks_lie_on_them(client):
    answer = client.ask(diagram())
    for branch in answer["branches"]:
        x, y = branch["x"], branch["y"]
        assert len(x) == len(y) == len(branch["arclength"])
        edges = [(item["first"], item["last"]) for item in branch["segments"]]
        assert edges[0][0] == 0
        assert edges[-1][1] == len(x) - 1
        assert all(left[1] == right[0] for left, right in pairwise(edges))
        places = list(zip(x, y, strict=True))
        for mark in branch["special"]:
            assert min(math.hypot(mark["value"] - a, mark["y"] - b) for a, b in places) < 1e-6


def test_a_moved_diagram_comes_before_the_one_that_is_followed_and_agrees_with_it(client):
    client.ask(diagram(1))
    moved, *_, exact = ask_all(client, diagram(2, parameters={"f": 12.5, "Vd": 0.61}))
    assert moved["moved"]
    assert "moved" not in exact
    for rough, fine in zip(moved["branches"], exact["branches"], strict=True):
        for mark, true in zip(rough["special"], fine["special"], strict=True):
            assert mark["type"] == true["type"]
            assert mark["value"] == pytest.approx(true["value"], rel=1e-10)
            assert mark["y"] == pytest.approx(true["y"], rel=1e-6)
            assert mark["uncertainty"] is None  # computed for what is followed


def moved_through(*values, rests=0.6):
    """Return what is answered as a slider runs through values, but for where it rests."""
    answers, answering = [], Answering(Catalogue())
    for value in (0.6, *values):
        request = diagram(2, parameters={"f": 12.5, "Vd": value}, rests=value in (0.6, rests))
        answers += [item for item in answers_to(request, answering) if not request["rests"]]
    assert all(answer["moved"] and answer["more"] and answer["done"] for answer in answers)
    return answers, answering


def test_what_is_moved_does_not_depend_on_the_way_of_the_slider():
    (directly,), _ = moved_through(0.63)
    *_, through = moved_through(0.61, 0.62, 0.63)[0]
    assert through["branches"] == directly["branches"]
    (later,), _ = moved_through(0.62, 0.63, rests=0.62)
    *_, again = moved_through(0.63, 0.62, 0.63, rests=0.62)[0]
    assert again["branches"] == later["branches"]


def test_an_orbit_of_a_moved_diagram_follows_no_response_again(monkeypatch):
    """A slider that moves asks for both: the orbit would take as long as the diagram."""
    answers, answering = moved_through(0.61, 0.62)  # the orbit waits until the next one is moved
    monkeypatch.setattr("slipfold.interface.explorer.answering.response", None)
    branch = answers[0]["branches"][0]
    middle = len(branch["x"]) // 2
    at = {"branch": 1, "arclength": branch["arclength"][middle], "value": branch["x"][middle]}
    (orbit,) = answers_to({**ORBIT, "parameters": {"f": 12.5, "Vd": 0.61}, "at": at}, answering)
    model = sf.SlidingOscillator(Vd=0.61, Nd=at["value"])
    exact = sf.periodic_orbit(model, 1, {name: v[0] for name, v in orbit["states"].items()})
    found = sorted(abs(complex(*pair)) for pair in orbit["multipliers"])
    assert found == pytest.approx(sorted(abs(exact.multipliers)), rel=1e-8)


def ask_all(client, request):
    client.send(request)
    return client.until_done(request["id"])


def test_a_response_that_takes_long_says_how_far_it_is(monkeypatch):
    monkeypatch.setattr(PAGE, "interval", 0.0)
    answers = answers_to(diagram(1, span=[0, 0.1]))
    *progress, last = [answer for answer in answers if not answer.get("more")]
    # The exact curve is there before it is checked.
    (known,) = [answer for answer in answers if answer.get("more")]
    assert known["branches"] == last["branches"]
    assert (known["checked"], last["checked"]["agree"]) == (None, True)
    assert {note["progress"].split(",")[0] for note in progress} == {"branch 1", "branch 2"}
    assert all(0 <= note["value"] <= 0.1 and not note["done"] for note in progress)


def test_an_orbit_on_a_branch_closes_and_has_its_multipliers(client, base):
    branch = base.branches[1]
    place = float(branch.arclength[9])
    answer = client.ask({**ORBIT, "at": {"branch": 2, "arclength": place}})
    assert (answer["kind"], answer["slot"]) == ("orbit", "live")
    assert answer["period"] == 2
    assert answer["value"] == branch.parameter[9]
    assert answer["stability"] == ("stable" if branch.stable[9] else "unstable")
    assert [complex(*item) for item in answer["multipliers"]] == pytest.approx(
        branch.multipliers[9].tolist(), rel=1e-9
    )
    assert answer["t"][-1] == pytest.approx(2 / 12.5, rel=1e-6)
    for column in [*answer["states"].values(), *answer["outputs"].values()]:
        assert column[0] == pytest.approx(column[-1])
    assert answer["mechanism"] == {"kind": "sliding"}


def test_no_orbit_elsewhere_takes_the_place_of_the_requested_one(monkeypatch):
    monkeypatch.setattr(PAGE, "filling", 0.0)
    long, seconds = "here, not to 0.9, since it takes long", "OrbitRequest.seconds"
    has, ends = "has Nd = 0.0", "ends at Nd = 0.375947, not at 0.9"
    for limit, place, why in (math.inf, 0.1, has), (math.inf, 1e3, ends), (0.0, 1e3, long):
        monkeypatch.setattr(f"slipfold.interface.explorer.messages.{seconds}", limit)
        at = {"branch": 1, "arclength": place, "value": 0.9}
        *_, answer = answers_to({**ORBIT, "at": at}, Answering(Catalogue()))
        assert why in answer["error"]


def test_an_orbit_near_a_state_is_found(client):
    state = {"x": 0.1, "y": 0.05, "vx": 0, "vy": 0}
    answer = client.ask({**ORBIT, "at": {"value": 0.03, "state": state}})
    right = sf.periodic_orbit(sf.SlidingOscillator(f=12.5, Nd=0.03), 1, state)
    assert answer["states"]["x"][0] == pytest.approx(right.state[0], rel=1e-6)


def test_a_motion_ends_with_what_simulate_says(client):
    values = {"f": 12.2, "Nd": 0.15}
    request = {"kind": "simulation", "id": 3, "model": "sliding", "parameters": values}
    *progress, last, contacts = ask_all(client, request)
    assert all(set(item) >= {"far", "done"} for item in progress)
    assert contacts["contacts"]["period"] == 2
    right = sf.simulate(sf.SlidingOscillator(**values), 400)
    assert last["verdict"] == right.settlement.message
    assert (last["settled"], last["period"]) == (True, 2)
    x = right.sample(per_period=64)[1][:, 0].reshape(400, 64)
    assert last["sections"]["max"]["x"] == pytest.approx(x.max(axis=1), rel=1e-5, abs=1e-8)


def test_a_motion_starts_beside_an_orbit_where_it_is_nudged(client):
    request = {"kind": "simulation", "id": 4, "model": "sliding", "periods": 1}
    start, perturbation = {"x": 0.1, "y": 0.05, "vx": 0, "vy": 0}, {"x": 0.01}
    last = ask_all(client, {**request, "start": start, "perturbation": perturbation})[-2]
    state = {**start, "x": 0.11}
    x = sf.simulate(sf.SlidingOscillator(), 1, state).sample(per_period=64)[1][:, 0]
    assert last["sections"]["max"]["x"] == pytest.approx([x.max()])


PLANE = {
    "kind": "plane",
    "id": 6,
    "model": "sliding",
    "x": {"name": "f", "span": [12.46, 12.54]},
    "y": {"name": "Nd", "span": [0, 0.05]},
}


def test_a_plane_tells_its_progress_and_has_the_loci(client):
    *progress, plane = ask_all(client, PLANE)
    assert plane["note"] is None
    assert all("  " not in item["progress"] for item in progress)
    # Loci come while they are followed, and all of them before the regions.
    [followed] = [item["loci"] for item in progress if "loci" in item]
    assert followed == plane["loci"]
    lines = {line["number"]: line for item in progress for line in item["lines"]}
    assert {line["type"] for line in lines.values()} == {locus["type"] for locus in followed}
    ends = [(line["x"][-1], line["y"][-1]) for line in lines.values()]
    drawn = [
        place
        for locus in followed
        for segment in locus["segments"]
        for place in zip(segment["x"], segment["y"], strict=True)
    ]
    assert all(any(place == pytest.approx(end, rel=1e-5) for place in drawn) for end in ends)
    assert ("PD", 1) in {(locus["type"], locus["period"]) for locus in plane["loci"]}
    regions = plane["regions"]
    assert len(regions["labels"]) == len(regions["y"])
    assert {len(row) for row in regions["labels"]} == {len(regions["x"])}
    assert {label for row in regions["labels"] for label in row} - {0} <= set(
        map(int, regions["names"])
    )


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"model": "slidin"}, "there is no model 'slidin'"),
        ({"parameters": {"F": 1.0}}, "has no parameter 'F'"),
        ({"parameters": {"f": -1.0}}, "f = -1 is outside its bounds"),
        ({"vary": "nd"}, "has no parameter 'nd'"),
        ({"span": [0.1, 0.1]}, "is empty"),
        ({"show": "z"}, "'z'"),
    ],
    ids=str,
)
def test_what_cannot_be_computed_is_said_in_a_sentence(client, change, words):
    answer = client.ask(diagram(8, **change))
    assert words in answer["error"]
    assert "Traceback" not in answer["error"]


@pytest.mark.parametrize("junk", ["", "{", "null", "[]", '{"kind": "shell"}', b"\xff\xfe", "\x00"])
def test_junk_is_refused_and_the_next_request_is_answered(client, junk):
    client.send(junk)
    assert client.receive()["error"].startswith("the request cannot be used")
    assert client.ask(diagram())["branches"]


def test_the_newest_request_wins(client):
    client.ask(diagram(0))
    for number in range(1, 30):
        client.send(diagram(number, parameters={"f": 12.5 + 0.0001 * number}))
    done = []
    while 29 not in done:
        answer = client.receive()
        assert "error" not in answer
        if answer["done"]:
            done.append(answer["id"])
    # One may have been finished before the next arrived, not most of them.
    assert len(done) < 15


def test_slots_do_not_disturb_each_other(client):
    for number, slot in enumerate(["pin:1", "live", "pin:2"]):
        client.send(diagram(number, slot=slot, parameters={"f": 12.3 + 0.05 * number}))
    done = {}
    while len(done) < 3:
        answer = client.receive()
        if answer["done"]:
            done[answer["id"]] = answer["slot"]
    assert done == {0: "pin:1", 1: "live", 2: "pin:2"}


def test_what_is_cancelled_is_not_answered(client):
    client.send(SLOW_PLANE)
    client.send({"kind": "cancel", "id": 10, "of": "plane"})
    while (answer := client.receive())["kind"] != "cancel":
        assert not answer["done"]
    client.send(diagram(11))
    while not (answer := client.receive())["done"]:
        assert answer["kind"] == "diagram"
    assert answer["branches"]


def test_a_motion_is_judged_as_lyapunov_judges_it_from_where_it_starts(client):
    motion = {"model": "duffing", "parameters": {"W": 1.4}}
    motion |= {"start": {"q": 0.1}, "perturbation": {"v": 0.5}}
    client.send({"kind": "exponents", "id": 5, **motion})
    *progress, last = client.until_done(5)
    duffing = sf.built_in_models()["duffing"](W=1.4)
    own = sf.lyapunov(duffing, state={"q": 0.1, "v": 0.5}, tolerance=1e-6)
    assert last["exponents"] == own.exponents.tolist()
    assert (last["kind_of_motion"], last["period"]) == ("periodic", 1)
    assert last["message"] == own.classification.message
    assert all(answer["periods"] <= answer["total"] for answer in progress)


def test_pictures_of_regimes_become_finer(monkeypatch):
    monkeypatch.setattr("slipfold.interface.explorer.pictures.REGIME_CELLS", ((1, 1), (1, 2)))
    window = {"x": {"name": "f", "span": [12.499, 12.501]}, "y": {"name": "Nd", "span": [0, 0.08]}}
    # Values of what is varied play no part.
    values = {"f": 13.0, "Nd": 0.5}
    asked = {"kind": "regimes", "id": 1, "model": "sliding", "parameters": values, **window}
    pictures = [answer for answer in answers_to(asked) if "labels" in answer]
    # Of the first picture what repeats is sent before the rest is known.
    assert [answer["done"] for answer in pictures] == [False, False, True]
    assert pictures[0]["labels"] == pictures[1]["labels"] == [[1]]
    last = pictures[-1]
    assert last["x"]["values"] == pytest.approx([12.5])
    assert last["y"]["values"] == pytest.approx([0.02, 0.06])
    # As in docs/how-to/tori-and-chaos.md.
    shown = [[last["names"][number - 1] for number in row] for row in last["labels"]]
    assert shown == [["period 1"], ["torus"]]


def test_pictures_of_basins_keep_the_numbers_of_attractors(monkeypatch):
    monkeypatch.setattr("slipfold.interface.explorer.pictures.BASIN_POINTS", (6, 11))
    plane = {"x": {"name": "q", "span": [-4, 4]}, "y": {"name": "v", "span": [-4, 4]}}
    asked = {"kind": "basins", "id": 1, "model": "duffing", "parameters": {"W": 1.2}, **plane}
    answers = answers_to(asked)
    coarse, fine = (answer for answer in answers if "labels" in answer)
    assert [answer["done"] for answer in (coarse, fine)] == [False, True]
    assert answers[-1] is fine
    # Every other start of the finer picture is one of the coarser.
    assert [row[::2] for row in fine["labels"][::2]] == coarse["labels"]
    assert {label for row in fine["labels"] for label in row} == {1, 2}
    assert [item["name"] for item in fine["attractors"]] == ["period 1", "period 1"]
    counts = [sum(row.count(number) for row in fine["labels"]) for number in (1, 2)]
    assert [item["fraction"] * 121 for item in fine["attractors"]] == pytest.approx(counts)


def answered(catalogue, **request):
    answers = answers_to(diagram(parameters={}, **request), Answering(catalogue))
    return [answer for answer in answers if "branches" in answer]


def test_what_motions_settle_on_is_added_where_the_response_ends(monkeypatch):
    monkeypatch.setattr("slipfold.interface.explorer.messages.DiagramRequest.seconds", math.inf)
    monkeypatch.setattr(PAGE, "filling", math.inf)
    model = sf.System.from_toml(FORCED_SLIDER)
    view = {"model": model.name, "vary": "F", "span": [0, 1.2]}
    *_, response, last = answered(Catalogue(model), **view)
    # What is known is shown before more is looked for.
    assert (response["more"], response["done"], last["done"]) == (True, False, True)
    assert last["branches"][:1] == response["branches"]
    (end,) = (branch["stopped"] for branch in response["branches"])
    assert end["reason"].startswith("touches Vrel = 0")
    assert end["reason"].endswith("; no orbit was found beyond")
    assert end["beyond"]["direction"] == 1
    right = sf.response(model, "F", (0, 1.2), gaps=True)
    ends = [branch.stopped.value for branch in right.branches]
    assert [item["stopped"]["value"] for item in last["branches"]] == ends
    assert len(right.branches) > 1
    # Where contacts begin to stick is marked as bifurcations are.
    marks = [(mark["type"], mark["value"]) for item in last["branches"] for mark in item["special"]]
    assert marks == [(point.type, point.value) for _, point in right.special]
    assert {"GRAZE", "STICK"} <= {kind for kind, _ in marks}


def test_a_motion_is_followed_and_what_cannot_be_is_said():
    view = {"model": "duffing", "vary": "W", "span": [1.1, 1.3], "show": "q"}
    orbit = sf.periodic_orbit(sf.built_in_models()["duffing"]().replace(W=1.2))
    state = dict(zip(("q", "v"), orbit.state.tolist(), strict=True))
    known = {"value": 1.2, "state": state, "period": 1}
    nowhere = {"value": 2.0, "state": state}
    *_, last = answered(Catalogue(), **view, also=[known, nowhere])
    *_, alone = answered(Catalogue(), **view)
    assert last["branches"] == alone["branches"]
    assert ["outside the span" in why for why in last["unfollowed"]] == [True]


def test_what_takes_too_long_is_shown_as_far_as_it_was_followed(tmp_path, monkeypatch):
    monkeypatch.setattr(PAGE, "filling", 0.0)
    *_, last = answered(Catalogue(), model="vanderpol-free", vary="mu", span=[0.1, 3])
    assert (last["done"], last["branches"][0]["stopped"]["kind"]) == (True, "span")
    assert all(item["stopped"]["kind"] == "interrupted" for item in last["branches"][1:])
    assert (last["unfollowed"], len(last["branches"])) == ([LONG], 1)
    monkeypatch.setattr("slipfold.interface.explorer.messages.DiagramRequest.seconds", 0.0)
    answering = Answering(Catalogue())
    *_, last = answers_to(diagram(), answering)
    assert (last["done"], last["branches"][0]["stopped"]["kind"]) == (True, "interrupted")
    monkeypatch.setattr(PAGE, "filling", math.inf)
    request = DiagramRequest.model_validate(diagram())
    watch = GapsProgress(lambda _: None, sf.SlidingOscillator(), request, None)
    with pytest.raises(KeyboardInterrupt):  # it would be given up with what is shown
        watch(Progress("gaps", 0, values={"branches": ()}))
    monkeypatch.setattr("slipfold.interface.explorer.messages.DiagramRequest.seconds", math.inf)
    # What the clock ended is shown, and followed again.
    shown = [it["branches"] for it in answers_to(diagram(), answering) if "branches" in it]
    assert [shown[i][0]["stopped"]["kind"] for i in (0, -1)] == ["interrupted", "limit"]
    assert [it["branches"] for it in answers_to(diagram(), answering)] == shown[-1:]
    contact = {"slip": "-v", "normal": "0.3", "friction": sf.Coulomb(mu_k=1.0)}
    dry = sf.System(
        parameters={"A": 0.1, "w": 1.0},
        forcing={"period": "2*pi/w"},
        states={"x": "v", "v": "A*cos(w*t) - x - 0.1*v + tip"},
        contacts={"tip": contact},
    )
    axes = {"x": {"name": "A", "span": [0.1, 0.2]}, "y": {"name": "w", "span": [1, 1.1]}}
    answering = Answering(Catalogue(dry))
    # What is not followed to its end is kept for its file, and without regions it is said why.
    request = {**PLANE, "model": dry.name, **axes}
    view = PlaneRequest.model_validate(request)
    for limit, note in (0.0, "takes long"), (math.inf, "no regions: the slip of the contact tip"):
        monkeypatch.setattr("slipfold.interface.explorer.messages.PlaneRequest.seconds", limit)
        *_, plane = answers_to(request, answering)
        assert (plane["done"], plane["regions"]) == (True, None)
        assert note in plane["note"]
        file = tmp_path / f"{limit}.nc"
        file.write_bytes(answering.export(ExportRequest(view=view, format="nc"), lambda: None))
        assert sf.load(file).interrupted == (limit == 0)
