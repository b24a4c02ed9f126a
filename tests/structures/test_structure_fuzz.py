"""Whatever stands in the file of a structure: a model or one clear message, soon."""

import heyoka as hy
from hypothesis import strategies as st

import slipfold as sf
from helpers.frame import TEXT
from helpers.spoilt_files import check_made, fuzzed, spoilt_files
from slipfold import built_in_models
from slipfold.models.registry import built_in_text, model_named

FEW = 60

MORE = """
[[elements]]
type = "PolynomialSpring"
at = { tip = 1, root = -1 }
stiffness = { 1 = 3, 5 = 4.5 }
[[elements]]
type = "GapSpring"
name = "stop"
at = "tip"
k = 10
e = "1mm"
[[contacts]]
name = "pad"
along = ["tip", "root"]
alpha = "60deg"
friction = { law = "Regularized", of = { law = "Stribeck", vs = "20 cm/s" }, e = 0.1 }
load = { type = "ContactLoad", normal = "root", kn = 3 }
"""
TEXTS = [
    TEXT + MORE,
    *(
        built_in_text(name)
        for name in built_in_models()
        if isinstance(model_named(name), sf.Structure)
    ),
]
CLASSES = [
    *("LinearSpring", "CubicSpring", "PolynomialSpring", "GapSpring", "GeometricSpring"),
    *("FrictionContact", "HarmonicForce", "MultiHarmonicForce", "TabulatedForce", "BaseMotion"),
    *("ConstantLoad", "ModulatedLoad", "ContactLoad", "ModalDamping", "ProportionalDamping"),
    *("ModalReduction", "CraigBampton", "Coulomb", "Stribeck", "Regularized", "LuGre", "Iwan"),
]
NAMES = st.sampled_from(["root", "tip", "q1", "mode1", "", "vtip", "phase", "μ", "a b", "f", "k"])
KEYS = st.sampled_from(
    [
        *("type", "law", "of", "at", "along", "friction", "load", "normal", "axis", "name", "k3"),
        *("k", "c", "gap", "e", "side", "L", "stretch", "Vd", "alpha", "Ns", "Nd", "kn", "F", "A"),
        *("phi", "harmonic", "harmonics", "samples", "stiffness", "factor", "ratios", "zeta"),
        *("boundary", "modes", "up_to", "alpha_M", "beta_K", "M", "C", "K", "names", "diagonal"),
        *("length_scale", "size", "rows", "columns", "entries", "mu_s", "vs", "elements", "shape"),
        *("1", "3", "0", "999", "f", "root", "tip"),
    ]
)
SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 5),
    st.integers(-(10**400), 10**400),
    st.floats(),
    st.sampled_from(CLASSES),
    NAMES,
    st.sampled_from(["5 mm", "1e999", "3 Hz", "60deg", "inf", "x.npz", "../x.mat", "\x00", "{"]),
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3), st.dictionaries(st.one_of(KEYS, NAMES), inner, max_size=4)
    ),
    max_leaves=8,
)
MATRICES = st.one_of(
    st.just([[2, -1], [-1, 1]]),
    st.just({"diagonal": [1, 2]}),
    st.just({"size": 2, "rows": [0, 1], "columns": [0, 1], "entries": [1.0, 2.0]}),
    st.lists(st.lists(st.one_of(st.integers(-2, 3), st.floats(-1, 2)), max_size=3), max_size=3),
    VALUES,
)
PARTS = st.lists(
    st.dictionaries(KEYS, VALUES, max_size=5).flatmap(
        lambda table: st.sampled_from(CLASSES).map(lambda name: {"type": name, "at": "tip"} | table)
    ),
    max_size=3,
)
TABLES = st.fixed_dictionaries(
    {
        "structure": st.one_of(
            st.fixed_dictionaries(
                {"M": MATRICES, "K": MATRICES},
                optional={"C": MATRICES, "names": st.one_of(st.just("root tip"), VALUES)},
            ),
            VALUES,
        )
    },
    optional={
        **dict.fromkeys(("elements", "contacts", "forcing"), st.one_of(PARTS, VALUES)),
        **dict.fromkeys(("damping", "reduction", "watch", "parameters", "name", "x"), VALUES),
    },
)
PIECES = st.one_of(
    KEYS,
    NAMES,
    st.sampled_from(CLASSES),
    st.sampled_from(
        [
            *("[structure]", "[[elements]]", "[contacts]", "{", "}", "[", "]", '"""', "#", "true"),
            *("= ", "inf", "nan", "-", "1979-05-27", "[[1, 2], [3, 4]]", "{ a = 1 }", "\\u0000"),
            *("9" * 400, "1e308", "1e-320", "0", "\ud800", "\n", '"', "5 mm", "/etc/passwd"),
        ]
    ),
    st.text(max_size=8),
)


def use(model):
    """What is accepted is a model: the same one from its tables, and with equations."""
    assert sf.Structure.from_tables(model.to_tables()) == model
    q = {state.name: hy.expression(state.name) for state in model.states}
    c = model.coefficients({item.name: hy.expression(item.name) for item in model.parameters})
    assert list(model.rates(q, c, hy.expression("phase"))) == list(q)
    assert model.period(model.values) > 0


def from_text(text):
    check_made(lambda: sf.Structure.from_toml(f"\n{text}"), use)


def from_tables(tables):
    check_made(lambda: sf.Structure.from_tables(tables), use)


test_any_spoilt_file = fuzzed(spoilt_files(TEXTS, PIECES), from_text, FEW)
test_any_tables = fuzzed(TABLES, from_tables, FEW)
