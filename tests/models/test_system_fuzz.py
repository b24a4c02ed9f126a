"""Whatever stands in a file or formula: a model or one clear message, soon, and nothing is run."""

import math

import heyoka as hy
from hypothesis import strategies as st

import slipfold as sf
from helpers.spoilt_files import check_made, fuzzed, spoilt_files
from slipfold import built_in_models
from slipfold.models.formulas.functions import FUNCTIONS
from slipfold.models.formulas.grammar import FormulaError, format_tree, parse_formula
from slipfold.models.registry import built_in_text, model_named

FEW = 80

WORDS = st.sampled_from(
    [
        *FUNCTIONS,
        *("q", "v", "F", "W", "t", "pi", "e", "x", "abs", "__import__", "eval", "lambda"),
        *("+", "-", "*", "/", "^", "**", "(", ")", ",", ".", "=", "'", '"', "[", "]", "\n", " "),
        *("0", "1", "2.5", "1e308", "1e-320", "1e999", ".5", "9" * 400, "μ", "\x00", "\ud800", "²"),
    ]
)
FORMULAS = st.one_of(
    st.lists(WORDS, max_size=30).map("".join),
    st.lists(WORDS, max_size=30).map(" ".join),
    st.text(max_size=40),
    st.tuples(st.sampled_from(["(", "-", "sin(", "q^", "2*(", "q+"]), st.integers(0, 3000)).map(
        lambda item: item[0] * item[1] + "q"
    ),
)

SYSTEMS = [name for name in built_in_models() if isinstance(model_named(name), sf.System)]
TEXTS = [built_in_text(name) for name in SYSTEMS]
PIECES = st.one_of(
    WORDS,
    st.sampled_from(
        [
            *("[states]", "[forcing]", "[[states]]", "[states.q]", "{", "}", '"""', "#", "true"),
            *("q = ", "period = ", "inf", "nan", "1979-05-27", "[1, 2]", "{ a = 1 }", "\\u0000"),
            *("value", "rate", "min = ", "bound", "{value}", "{value:99999d}", "model", "t", "T"),
        ]
    ),
    st.text(max_size=8),
)


SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(10**400), 10**400),
    st.floats(),
    FORMULAS,
    st.sampled_from(["q", "v", "2*pi/W", "F*cos(W*t) - q", "-v", "a", "b", "a + b", "W"]),
)
NAMES = st.sampled_from(
    ["q", "v", "W", "F", "a", "b", "T", "phase", "name", "e", "period", "", "μ"]
)
KEYS = st.sampled_from(
    [
        *("value", "unit", "min", "max", "above", "below", "doc", "symbol", "rate", "scale"),
        *("start", "formula", "label", "output", "bound", "reason", "measure", "stop", "period"),
        "amplitude",
    ]
)
ENTRIES = st.one_of(
    SCALARS,
    st.dictionaries(KEYS, SCALARS, max_size=4),
    st.lists(SCALARS, max_size=2),
)
TABLES = st.dictionaries(
    st.sampled_from(
        [
            *("name", "title", "parameters", "formulas", "states", "forcing", "outputs", "limits"),
            *("events", "model"),
        ]
    ),
    st.one_of(st.dictionaries(st.one_of(NAMES, KEYS), ENTRIES, max_size=4), SCALARS),
    max_size=7,
)


def formula(text):
    try:
        found = parse_formula(text)
    except FormulaError as error:
        found = error
    if isinstance(found, FormulaError):
        assert found.message
        assert 0 <= found.position <= len(text)
    elif len(text) < 200:
        # Comparing trees of thousands of levels would need as deep a stack.
        assert parse_formula(format_tree(found)) == found


def use(model):
    """What is accepted is a model: the same one from its text, with symbols and with numbers."""
    assert sf.System(model.to_toml()) == model
    q = {state.name: hy.expression(state.name) for state in model.states}
    c = model.coefficients({item.name: hy.expression(item.name) for item in model.parameters})
    rates = model.rates(q, c, hy.expression("phase"))
    assert list(rates) == list(q)
    period = model.period(model.values)
    assert math.isfinite(period)
    assert period > 0


test_any_formula = fuzzed(FORMULAS, formula, FEW)


def in_a_system(text):
    tables = {
        "parameters": {"W": 1.0, "F": 0.5},
        "states": {"q": "v", "v": text},
        "forcing": {"period": "2*pi/W"},
    }
    check_made(lambda: sf.System(tables), use)


test_any_formula_in_a_system = fuzzed(FORMULAS, in_a_system, FEW)


def from_text(text):
    check_made(lambda: sf.System.from_toml(f"\n{text}"), use)


def from_tables(tables):
    check_made(lambda: sf.System(tables), use)


test_any_spoilt_file = fuzzed(spoilt_files(TEXTS, PIECES), from_text, FEW)
test_any_tables = fuzzed(TABLES, from_tables, FEW)
