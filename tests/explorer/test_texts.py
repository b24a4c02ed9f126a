"""Models that are written on the page: parsed and never run, bounded, and as good as others."""

import re
from contextlib import suppress

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

import slipfold as sf
from helpers.explorer_models import BRAKE, BRAKE_OF_FILE, STIFFNESS
from helpers.explorer_server import diagram, running_explorer
from slipfold.interface.explorer.answering import Answering
from slipfold.interface.explorer.catalogue import Catalogue
from slipfold.interface.explorer.equations import equations_of
from slipfold.interface.explorer.messages import ExportRequest, ModelRequest
from slipfold.interface.explorer.security import ServerLimits
from slipfold.interface.explorer.settings import PAGE
from slipfold.interface.explorer.texts import answered, text_of
from slipfold.models.model import evaluation_of
from slipfold.models.registry import built_in_models, built_in_text, model_of_text

DUFFING = built_in_text("duffing")
QUINTIC = DUFFING.replace("- g*q^3", "- g*q^3 - 0.02*q^5")
OWN = {"vary": "W", "span": [0.8, 1.0], "show": "q", "parameters": {"F": 0.1}}


def post(explorer, path, **content):
    with explorer.http() as http:
        return http.post(f"/api/{path}", json=content)


def test_a_written_model_is_answered_as_one_of_the_catalogue(explorer, client):
    described = post(explorer, "model", text=QUINTIC, name="my own.toml").json()
    assert described["name"] == "duffing"
    assert [item["name"] for item in described["parameters"]] == ["W", "F", "d", "k", "g"]
    given = client.ask(diagram(model="duffing (edited)", text=QUINTIC, **OWN))
    expected = sf.response(sf.System.from_toml(QUINTIC).replace(F=0.1), "W", (0.8, 1.0))
    (branch,) = expected.branches
    last = given["branches"][0]["y"][-1]
    assert last == pytest.approx(branch.extrema_of("q").maximum[-1], rel=1e-6)
    refusals = post(explorer, "values", model="own", text=QUINTIC, parameters={"W": -1.0}).json()
    assert refusals == {"W": "W = -1 is outside its bounds; W must be > 0 rad/s"}


@pytest.mark.parametrize("name", [name for name in built_in_models() if name != "sliding"])
def test_the_text_of_every_model_makes_it_again(name):
    model = built_in_models()[name]()
    assert model_of_text(text_of(model)) == model


def test_the_papers_oscillator_is_shown_by_its_equations():
    paper = sf.SlidingOscillator(Nd=0.3, f=12.2)
    ours = model_of_text(text_of(sf.SlidingOscillator())).replace(Nd=0.3, f=12.2)
    assert [item.name for item in ours.parameters] == [item.name for item in paper.parameters]
    random = np.random.default_rng(20261126)
    for state in random.normal(size=(20, 4)) * [0.4, 0.4, 30.0, 30.0]:
        phase = random.uniform()
        rates, expected = (evaluation_of(one).rates(one, state, phase) for one in (ours, paper))
        np.testing.assert_allclose(rates, expected, rtol=1e-12)
    assert model_of_text(text_of(paper)) == paper  # values of its own are those of a case


def rows(model, text="#"):
    groups = equations_of(model, text)["groups"]
    return {left: right for group in groups for left, right, _ in group["rows"]}


def test_equations_are_written_as_by_hand_with_their_sources():
    assert rows(sf.SlidingOscillator())["|(tipx, tipy)|"] == "μ N at most"  # a vector
    duffing = built_in_models()["duffing"]()
    assert rows(duffing)["v′"] == "F cos(Ω t) − d v − k q − g q³"
    about = equations_of(duffing, DUFFING)["about"]
    assert "Krack and Gross, Harmonic Balance" in about
    belt = sf.Structure(
        M=[[1.5]],
        C=[[0.2]],
        K=[[-3]],
        names="x",
        elements=sf.CubicSpring("x", k3=2),
        contacts=sf.FrictionContact("x", sf.CoulombViscous(), 2.0, Vd=1, name="pad"),
        forcing=sf.HarmonicForce("x", F=1),
    )
    found = rows(belt)
    assert found["1.5 x″ + 0.2 x′ − 3 x"] == "S1 + Rpad + P3"
    assert found["S1"] == "−k₃ (x)³"
    assert found["Rpad"].endswith("s = Vd pad − x′")
    assert found["|Rpad|"].endswith(" N at most")
    assert found["P3"] == "F cos(2π f t + φ)"
    assert found["μ(|s|)"].startswith("μk")
    gauss = sf.Regularized(sf.Stribeck(exponent=2))
    pad = sf.FrictionContact("x", gauss, 2.0)
    assert rows(sf.Structure([[1]], [[0]], [[1]], names="x", contacts=pad))["n"] == "2"


@pytest.mark.parametrize(
    ("law", "expected"),
    [
        (sf.LuGre(), {"R1": "N (σ₀ z + σ₁ z′ + σ₂ s)", "z′": "s − σ₀ |s| z/g(|s|)"}),
        (sf.BoucWen(), {"R1": "N z", "z′": "A s − |z|^(n−2) z (b |s·z| + c s·z)", "n": "2"}),
        (sf.CubicStribeck(), {"μ(|s|)": "μs − (μs − μm) |s| (3 − |s|²/vm²)/(2 vm)"}),
        (sf.Iwan(), {"R1": "Sum of mu_k N z ", "z′": "w − z |z|^(n−2) max(w·z, 0)"}),
        (sf.Regularized(sf.Coulomb(mu_k=0.3)), {"μ(|s|)": "μ₀(|s|) g(|s|/ε)", "μ₀(|s|)": "μk"}),
    ],
)
def test_the_equations_of_a_law_have_its_memory_and_what_it_regularizes(law, expected):
    contact = sf.FrictionContact("x", law, 2.0)
    found = rows(sf.Structure([[1]], [[0]], [[1]], names="x", contacts=contact))
    assert all(found[left].startswith(right) for left, right in expected.items())


@pytest.mark.parametrize("name", built_in_models())
def test_every_model_has_equations(name):
    model = built_in_models()[name]()
    assert len(rows(model)) >= 2
    assert "\\" not in str(rows(model))


def test_a_structure_that_was_made_in_python_has_a_text_with_all_its_matrices():
    chain = built_in_models()["chain"](F_shaker=0.5)
    own = chain.replace(title="one's 'own'")
    assert sf.Structure.from_toml(own.to_toml()) == own
    spun = sf.Structure(M=[[1, 0], [0, 1]], K={1: [[2, -1], [-1, 2]], "w^2": [[1, 0], [0, 0]]})
    assert sf.Structure.from_toml(spun.to_toml()) == spun
    assert model_of_text(text_of(spun)) == spun


def test_a_mistake_is_reported_as_on_the_command_line(explorer, tmp_path):
    wrong = QUINTIC.replace("k*q ", "k*qq ")
    file = tmp_path / "own.toml"
    file.write_text(wrong)
    with pytest.raises(sf.InputError) as raised:
        sf.System.from_toml(file)
    answer = post(explorer, "model", text=wrong, name="own.toml")
    assert answer.status_code == 400
    assert answer.text == str(raised.value).replace(str(file), "own.toml")
    assert answer.text.splitlines()[0].startswith("own.toml, line 17, column 36: ")
    assert answer.text.splitlines()[2].strip() == "^^"


HOSTILE = {
    "brackets": "a = " + "[" * 30_000 + "]" * 30_000,
    "deep tables": "[" + ".".join("a" * 10_000) + "]",
    "parentheses": f"[states]\nq = '{'(' * 4000}q{')' * 4000}'",
    "powers": "[states]\nq = '10^10^10^10 + q^1e308'",
    "no number": "[parameters]\na = 1e999\n[states]\nq = '-a*q'",
    "sums": "[sizes]\nn = 1000\n[states]\nq = 'sum(i=1:n, sum(j=1:n, sum(k=1:n, q*i*j*k)))'",
    "a million states": "[sizes]\nn = 1000000\n[states]\n'x[i=1:n]' = '-x[i]'",
    "a million masses": "[structure]\nnames = 'a'\n"
    + "\n".join(
        f"{key} = {{ size = 1000000, rows = [0], columns = [0], entries = [1] }}" for key in "MK"
    ),
    "a formula that is Python": "[states]\nq = '__import__(\"os\").getpid()'",
    "a path": "[structure]\nM = '/etc/passwd'\nK = [[1]]",
    "a path above": "[structure]\nM = '../secret.mtx'\nK = [[1]]",
    "another case": "model = '/etc/passwd.toml'",
    "nothing to vary": "[states]\nq = '-q'",
}


@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE)
def test_a_hostile_text_is_refused_in_a_sentence(text):
    request = ModelRequest(text=text)
    with pytest.raises(sf.InputError) as raised:
        answered(Catalogue(), request)
    assert len(str(raised.value)) < 1000


@pytest.mark.long
def test_a_text_that_takes_long_is_given_up_and_the_server_goes_on():
    slow = "[sizes]\nn = 499\n[parameters]\na = 1\n[states]\n'x[i=1:n]' = 'v[i]'\n'v[i=1:n]' = '"
    slow += "-a*x[i]*sin(x[i])" * 300 + "'"
    limits = ServerLimits(seconds={"model": 0.5})
    with running_explorer(workers=1, limits=limits) as explorer:
        answer = post(explorer, "model", text=slow)
        assert answer.status_code == 400
        assert answer.text.startswith("this took more than 0.5 s and was given up; write a smaller")
        assert post(explorer, "text", model="duffing").json()["text"] == DUFFING
        limits.seconds["model"] = 60.0
        assert post(explorer, "model", text=QUINTIC).status_code == 200


def test_a_text_has_a_largest_size(explorer, client):
    long = DUFFING + "#" * PAGE.text
    assert post(explorer, "model", text=long).status_code == 422
    answer = client.ask(diagram(text=long))
    assert answer["error"].startswith("the request cannot be used: ")
    assert len(answer["error"]) < 200


def test_files_with_matrices_are_read_in_the_folder_of_the_servers_file_alone(tmp_path):
    (tmp_path / "K.mtx").write_text(STIFFNESS)
    file = tmp_path / "brake.toml"
    file.write_text(BRAKE_OF_FILE)
    mine = Catalogue(sf.Structure.from_toml(file), file)
    assert mine.described(BRAKE_OF_FILE, "")["name"] == "brake"
    assert text_of(mine.model("brake", {}), file) == BRAKE_OF_FILE
    for other, text in [
        (Catalogue(), BRAKE_OF_FILE),
        (mine, BRAKE_OF_FILE.replace("K.mtx", "../K.mtx")),
        (mine, BRAKE_OF_FILE.replace("K.mtx", f"{tmp_path}/K.mtx")),
        (mine, 'model = "brake.toml"'),
    ]:
        with pytest.raises(sf.InputError, match=r"this text is in none|leads out of the folder"):
            other.described(text, "")


def test_a_file_with_a_matrix_that_changes_is_read_again(tmp_path):
    (tmp_path / "K.mtx").write_text(STIFFNESS)
    file = tmp_path / "brake.toml"
    file.write_text(BRAKE_OF_FILE)
    catalogue = Catalogue(sf.Structure.from_toml(file), file)
    before = catalogue.model("brake", {}, BRAKE_OF_FILE)
    described = catalogue.described(BRAKE_OF_FILE, "")
    assert catalogue.model("brake", {}, BRAKE_OF_FILE) == before
    assert catalogue.describe()[0]["files"] == described["files"] != ""
    (tmp_path / "K.mtx").write_text(STIFFNESS.replace("2000.0", "2500.00"))
    after = catalogue.model("brake", {}, BRAKE_OF_FILE)
    assert ("2000" in before.to_toml(), "2500" in after.to_toml()) == (True, True)
    assert catalogue.described(BRAKE_OF_FILE, "")["files"] != described["files"]
    assert Catalogue().described(DUFFING, "")["files"] == ""
    assert catalogue.described(DUFFING + "# '../K.mtx' '/etc/passwd'", "")["files"] == ""


def test_a_copied_text_has_the_matrices_of_its_files_in_it(tmp_path):
    (tmp_path / "K.mtx").write_text(STIFFNESS)
    file = tmp_path / "brake.toml"
    file.write_text(BRAKE_OF_FILE)
    changed = BRAKE_OF_FILE.replace("[[0.05]]", "[[0.06]]")
    answering = Answering(Catalogue(sf.Structure.from_toml(file), file))
    view = diagram(model="brake (edited)", text=changed, parameters={}, vary="Vd", show="tip")
    request = ExportRequest.model_validate({"view": view, "format": "python"})
    script = answering.export(request, lambda: None).decode()
    text = re.search(r"from_toml\(r'''\n(.*)'''\)", script, re.DOTALL)[1]
    assert sf.Structure.from_toml(text) == Catalogue(None, file).model("brake", {}, changed)


LINES = [line for line in (DUFFING + BRAKE).splitlines() if line]


@hypothesis.settings(max_examples=60, deadline=None)
@hypothesis.given(st.lists(st.sampled_from(LINES) | st.text(max_size=12), max_size=30))
def test_lines_in_any_order_make_a_model_or_a_sentence(lines):
    with suppress(sf.InputError):
        answered(Catalogue(), ModelRequest(text="\n".join(lines) or "#"))
