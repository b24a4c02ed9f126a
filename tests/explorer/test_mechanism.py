"""The mechanism that is drawn of a model: the same from matrices and from equations."""

from pathlib import Path

import numpy as np
import pytest

import slipfold as sf
from slipfold.interface.explorer.mechanism import loops_of, mechanism_of
from slipfold.models.registry import model_of_text

MODELS = Path(__file__).parent / "models"


def test_a_chain_has_the_same_mechanism_from_equations_and_from_matrices():
    chain = model_of_text((MODELS / "ten-masses.toml").read_text())
    size = 10
    stiffness = 2 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1)
    matrices = sf.Structure(
        M=np.eye(size),
        C=0.02 * np.eye(size),
        K=stiffness,
        names=[f"x{number + 1}" for number in range(size)],
        forcing=sf.HarmonicForce("x1", F=0.05),
    )
    assert mechanism_of(chain) == mechanism_of(matrices)
    neighbors = [[body, body + 1] for body in range(size - 1)]
    assert sorted(mechanism_of(chain)["springs"]) == sorted([[0, -1], *neighbors, [9, -1]])
    assert mechanism_of(chain)["dashpots"] == []  # each mass has one, which says nothing


BRISTLES = model_of_text((MODELS / "bristles.toml").read_text())
PLANAR = sf.SlidingOscillator(friction=sf.LuGre(), f=12.0)


@pytest.mark.parametrize(("model", "size"), [(BRISTLES, 1.0), (PLANAR, PLANAR.L)])
def test_the_friction_loops_of_contacts_that_never_stick_enclose_the_work(model, size):
    orbit = sf.periodic_orbit(model)
    names = [item.name for item in (*model.states, *model.outputs())]
    values = dict(zip(names, orbit.outputs(4096)[1].T, strict=True))
    work = 0.0
    for loop in loops_of(model):
        moved = sum(weight * values[name] for name, weight in loop["along"].items())
        rate = np.fft.ifft(2j * np.pi * np.fft.fftfreq(4096, 1 / 4096) * np.fft.fft(moved)).real
        work += size * np.mean(values[loop["force"]] * rate)
    power = np.mean(values["power_plate"] - values["power_friction"])
    assert work == pytest.approx(power * orbit.duration, rel=1e-6)
    assert not loops_of(sf.SlidingOscillator())  # its simulation shows them


def test_contacts_elements_and_forces_stand_where_the_file_puts_them():
    belt = mechanism_of(model_of_text((MODELS / "two-on-a-belt.toml").read_text()))
    assert [(item["name"], item["bodies"], item["moves"]) for item in belt["contacts"]] == [
        ("front", [0], True),
        ("rear", [1], True),
    ]
    gap = sf.Structure(
        M=np.eye(2),
        K=[[2, 0], [0, 3]],
        names="u w",
        elements=[sf.CubicSpring({"u": 1, "w": -1}, k3=5), sf.CubicSpring("w", k3=5)],
        forcing=sf.HarmonicForce("w", F=1),
    )
    assert mechanism_of(gap)["springs"] == [[0, -1], [1, -1], [0, 1], [1, -1]]
    assert mechanism_of(gap)["forces"] == [1]


def test_a_contact_of_equations_belongs_to_the_mass_whose_speed_it_has():
    dry = sf.System(
        parameters={"k": 4.0, "V": 0.2},
        states={"a": "va", "b": "vb", "va": "k*(b - a)", "vb": "k*(a - 2*b) + pad"},
        contacts={"pad": {"slip": "V - vb", "normal": "3", "friction": "Coulomb"}},
    )
    assert mechanism_of(dry)["contacts"] == [{"name": "pad", "bodies": [1], "moves": True}]
    assert sorted(mechanism_of(dry)["springs"]) == [[0, 1], [1, -1]]


def test_what_has_no_masses_or_too_many_is_not_drawn():
    assert mechanism_of(sf.System(parameters={"a": 1}, states={"q": "-a*q"})) is None
    assert mechanism_of(sf.Structure(M=np.eye(60), K=np.eye(60))) is None
    beam = sf.Structure(M=np.eye(3), K=np.diag([1, 2, 3]), reduction=sf.FreeInterface(2))
    assert mechanism_of(beam) is None


def test_contacts_of_sectors_have_names_of_their_own():
    disk = sf.Structure(
        M=np.diag([1, 0]),
        K=[[2, -1], [-1, 1]],
        names="u next",
        cyclic=sf.CyclicSymmetry(4, 2, "u", "next"),
        contacts=sf.FrictionContact("u", sf.Coulomb(), load=1, Vd=0, name="pad"),
        forcing=sf.HarmonicForce("u", F=1),
    )
    assert [each["name"] for each in mechanism_of(disk)["contacts"]] == ["pad", "pad_s1"]
