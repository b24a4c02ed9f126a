"""Two changes of contacts between which a piece of a branch is shorter than a step."""

import math

import pytest

import slipfold as sf
from helpers.dry_friction import most_load

MU = 0.2


def _system(rate: float, changing: str, states: dict, contacts: dict) -> sf.System:
    """A system in which the formula Q of p passes a critical value where p is the root of q."""
    return sf.System(
        parameters={"p": -0.7, "q": 1e-4, "c": 0.5, "d": 0.0},
        formulas={"Q": f"{changing}*(1 + c*(p*p - q))", "A": f"cos({rate}*t)"},
        states=states,
        contacts={
            name: {"slip": slip, "normal": normal, "friction": {"law": "Coulomb", "mu_k": MU}}
            for name, (slip, normal) in contacts.items()
        },
        forcing={"period": f"2*pi/{rate}"},
    )


def grazing(also: dict | None = None) -> sf.System:
    """Steady slip of a mass on a belt stops where its velocity is that of the belt."""
    rate = 1.1
    force = abs(1 - rate**2 + 0.2j * rate) / rate
    states = {"x": "v", "v": "Q*A - x - 0.2*v + R", **(also or {})}
    return _system(rate, f"{force!r}", states, {"R": ("1 - v", "1")})


def sticking() -> sf.System:
    """Den Hartog's orbit begins to stick where it turns."""
    most = float(most_load(0.6 / (2 * math.pi), MU))
    return _system(0.6, f"{most!r}", {"x": "v", "v": "A - x + R"}, {"R": ("-v", "Q")})


def lifting() -> sf.System:
    """A mass on a belt swings linearly across it, with 4 y off its load."""
    swing, rate = 0.5 / (4 * 5), 1.3
    force = swing * abs(5 - rate**2 + 0.1j * rate)
    states = {"x": "v", "v": "R - x - 0.1*v", "y": "w", "w": "Q*A - y - 0.1*w + R_normal"}
    return _system(rate, f"{force!r}", states, {"R": ("0.3 - v", "0.5 - 4*y")})


def meeting() -> sf.System:
    """Two masses that a damper couples stop one after the other, and at once under equal loads."""
    states = {"x": "v", "v": "A - x + 0.05*(w - v) + R"}
    states |= {"y": "w", "w": "A - y + 0.05*(v - w) + S"}
    return _system(0.6, "2.9", states, {"R": ("-v", "2.9"), "S": ("-w", "Q")})


@pytest.mark.parametrize("largest", [pytest.param(0.05, marks=pytest.mark.long), 1.0])
@pytest.mark.parametrize(
    ("type", "make", "apart", "c"),
    [
        ("GRAZE", grazing, 1e-5, 0.5),
        ("STICK", sticking, 1e-4, -0.5),
        ("LIFT", lifting, 1e-5, 0.5),
        ("MEET", meeting, 1e-4, -0.1),
    ],
)
def test_both_changes_are_found_at_any_step(type, make, apart, c, largest):
    model = make().replace(c=c, q=apart**2, p=-0.5)
    settings = sf.Settings(largest_period=1, steps=sf.Steps(largest=largest))
    (branch,) = sf.response(sf.periodic_orbit(model), "p", (-0.5, 0.7), settings=settings).branches
    assert branch.stopped.kind == "span"
    found = [item for item in branch.special if item.type == type and abs(item.value) < 2 * apart]
    # Changes are resolved to 1e-11: a margin c (p^2 - q) with that error has another root
    known = pytest.approx([-apart, apart], abs=1e-11 / (2 * abs(c) * apart))
    assert [item.value for item in found] == known
    for item in found:  # of the formulas rounding remains, a margin by 1e-16
        error = abs(abs(item.value) - apart)
        assert error <= item.uncertainty + 1e-16 / (2 * abs(c) * apart)


@pytest.mark.parametrize("make", [grazing, sticking, lifting, meeting])
def test_orbits_that_only_come_near_a_change_do_not_make_it(make):
    for gap in (1e-3, 1e-9):
        model = make().replace(c=0.1, q=-gap, p=-0.2)
        orbit = sf.periodic_orbit(model)
        (branch,) = sf.response(
            orbit, "p", (-0.2, 0.25), settings=sf.Settings(largest_period=1)
        ).branches
        assert (branch.stopped.kind, len(branch.special)) == ("span", 0)


def test_both_changes_are_found_on_a_locus():
    # Of a second mass period doublings do not depend on p
    model = grazing(also={"y": "w", "w": "-0.1*w - (0.15 + 0.33*d + 0.4*A)*y"})
    orbit, settings = sf.periodic_orbit(model), sf.Settings(largest_period=1)
    (branch,) = sf.response(orbit, "d", (0, 1.4), settings=settings).branches
    (doubling,) = branch.special
    (locus,) = sf.locus(doubling, ("p", "d"), {"p": (-0.7, 0.7), "d": (-0.3, 2)}).loci
    found = [item.values[0] for item in locus.special if item.type == "GRAZE"]
    assert found == pytest.approx([-0.01, 0.01], abs=1e-9)
