"""Numbers with units as people write them."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipfold import InputError, System
from slipfold.models.units import parse_quantity

NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
SPACES = st.sampled_from(["", " ", "  "])
UNITS = {
    "deg": ("rad", math.pi / 180),
    "mm": ("m", 1e-3),
    "kHz": ("Hz", 1e3),
    "mN": ("N", 1e-3),
    "N/mm": ("N/m", 1e3),
    "cm/s": ("m/s", 1e-2),
    "m/min": ("m/s", 1 / 60),
    "N/um": ("N/m", 1e6),
    "ms": ("s", 1e-3),
    "g": ("kg", 1e-3),
    "%": ("", 1e-2),
}


@given(NUMBERS, SPACES, SPACES)
def test_text_of_a_number_is_the_number(value, before, after):
    assert parse_quantity(f"{before}{value!r}{after}", "N") == value


@given(NUMBERS, SPACES, st.sampled_from(sorted(UNITS)))
def test_other_unit_is_converted(value, space, suffix):
    unit, factor = UNITS[suffix]
    assert parse_quantity(f"{value!r}{space}{suffix}", unit) == value * factor


@given(NUMBERS, st.sampled_from(sorted(UNITS)), st.sampled_from(["N s/m", "1/s", "K"]))
def test_unit_of_another_kind_is_refused(value, suffix, unit):
    with pytest.raises(InputError, match=r"has the unit .*; give a number"):
        parse_quantity(f"{value!r}{suffix}", unit, "quantity")


@pytest.mark.parametrize(("text", "unit", "value"), [
    ("8/3", "", 8 / 3),
    (" -1/7 ", "", -1 / 7),
    ("2*pi", "rad/s", 2 * math.pi),
    ("pi", "rad", math.pi),
    ("-pi/3 rad", "rad", -math.pi / 3),
    ("180/7 deg", "rad", math.pi / 7),
    ("(1 + 2)/4 mm", "m", 0.75e-3),
    ("sqrt(2)", "", math.sqrt(2)),
    ("2^10 1/s", "1/s", 1024),
])  # fmt: skip
def test_arithmetic_is_calculated(text, unit, value):
    assert parse_quantity(text, unit) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["8/x", "8/", "x", "8/3 lb", "pi pi", "2**3", "__import__('os')"])
def test_what_is_no_arithmetic_is_refused(text):
    with pytest.raises(InputError, match="beta = "):
        parse_quantity(text, "m", "beta")


@given(st.text(max_size=12))
def test_any_text_is_a_number_or_an_input_error(text):
    try:
        result = parse_quantity(text, "m")
    except InputError as error:
        result = str(error)
    assert isinstance(result, float) or "give a number" in result


@pytest.mark.parametrize("text", ["", "mm", "five", "1,5", "--3", "0x10", "1e", "1_000", "2 3"])
def test_what_is_no_number_is_refused(text):
    with pytest.raises(InputError, match="L = "):
        parse_quantity(text, "m", "L")


def test_a_unit_may_begin_with_one_over_after_a_blank():
    for text in ("20 1/s", " 2e1\u202f1/s ", "20"):
        assert parse_quantity(text, "1/s") == 20
    assert parse_quantity("−0.5 1/m", "1/m") == -0.5
    with pytest.raises(InputError, match=r"has the unit '/s'; give .* 1/s"):
        parse_quantity("201/s", "1/s")
    with pytest.raises(InputError, match="has the unit '1/s'"):
        parse_quantity("20 1/s", "Hz")
    with pytest.raises(InputError, match="is not a number"):
        parse_quantity("20 2/s", "1/s")


def test_message_names_the_units_that_fit():
    with pytest.raises(InputError, match=r"alpha = '60mm' has the unit 'mm'; .* deg, rad"):
        parse_quantity("60mm", "rad", "alpha")


@pytest.mark.parametrize(
    ("unit", "meant"),
    [
        *[("rad/sec", "s"), ("hz", "Hz"), ("KG", "kg"), ("Newton/m", "N"), ("kilos", "kg")],
        *[("Nm/rad", "N m"), ("Ns/m", "N s"), ("Nmm", "N mm"), ("1/minutes", "min")],
    ],
)
def test_a_misspelled_unit_is_refused(unit, meant):
    text = f'[parameters]\nc = {{ value = 1.0, unit = "{unit}" }}\n[states]\nq = "-c*q"\n'
    with pytest.raises(InputError, match=rf"line 2, .*did you mean {meant}\?"):
        System.from_toml(text)


def test_an_unknown_unit_is_refused_by_those_that_are_known():
    parameters = {"c": {"value": 1.0, "unit": "bird/km^2"}}
    with pytest.raises(InputError, match=r"has 'bird', .*write e.g. m/s, .* of m, g, s, .* in doc"):
        System(parameters=parameters, states={"q": "-c*q"})


@pytest.mark.parametrize(
    "unit",
    [
        *["", "m", "rad/s", "N s/m", "kN/mm", "mS/cm^2", "1/yr", "µm", "mol/L", "°"],
        *["m/s²", "s⁻¹", "kg m²", "N·m", "mm²", "m³/s", "°C", "daN", "kgf", "mM", "µM/s", "kcal"],
        *["slug", "1/day", "L/hr", "mmHg", "atm", "ppm", "cSt", "kWh", "lbf in", "IU/mL"],
    ],
)
def test_other_units_are_taken(unit):
    system = System(parameters={"c": {"value": 1.0, "unit": unit}}, states={"q": "-c*q"})
    assert system.parameter("c").unit == unit
