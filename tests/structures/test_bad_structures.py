"""Matrices, elements, contacts and forces that cannot be: one clear sentence each."""

import numpy as np
import pytest
from scipy import sparse

import slipfold as sf
from slipfold import (
    BaseMotion,
    BoucWen,
    ContactLoad,
    Coulomb,
    CraigBampton,
    CubicSpring,
    FrictionContact,
    GapSpring,
    GeometricSpring,
    HarmonicForce,
    InputError,
    LinearSpring,
    ModalDamping,
    ModalReduction,
    ModulatedLoad,
    MultiHarmonicForce,
    PolynomialSpring,
    ProportionalDamping,
    Regularized,
    Structure,
    TabulatedForce,
    response,
)

I2, K2 = np.eye(2), np.array([[2.0, -1.0], [-1.0, 1.0]])
EMPTY = np.diag([1.0, 0.0])
SKEW = np.array([[2.0, -1.0], [-0.5, 1.0]])


def make(M=I2, C=None, K=K2, **options):
    return Structure(M, C, K, **options)


BAD = {
    "not square": (lambda: make(M=np.ones((3, 2))), "M has the shape 3 x 2; give a square"),
    "a number": (lambda: make(K=3.0), "K has the shape of a number"),
    "empty": (lambda: make(M=np.ones((0, 0))), "M has the shape 0 x 0"),
    "ragged": (lambda: make(K=[[1, 2], [3]]), "K is not a matrix of numbers"),
    "words": (lambda: make(K=[["a", "b"], ["c", "d"]]), "K is not a matrix of numbers"),
    "complex": (lambda: make(K=K2 * 1j), "K is complex"),
    "size of C": (lambda: make(C=np.eye(3)), "C has 3 rows and M has 2"),
    "no K": (lambda: Structure(I2), "no stiffness matrix; give K"),
    "NaN": (lambda: make(K=[[1, 0], [np.nan, 1]]), "entry nan in row 2, column 1"),
    "sparse inf": (lambda: make(K=sparse.csr_array([[np.inf, 0], [0, 1]])), "inf in row 1, col"),
    "an argument": (lambda: make(forces=HarmonicForce("q1")), "no argument 'forces'; did you mean"),
    "triangle": (
        lambda: make(K=np.tril(K2)),
        "K has one entry of each mirrored pair only: row 1, column 2 is 0, row 2, column 1 is -1; "
        'give triangles = "symmetric" if this is one triangle of a symmetric matrix, or',
    ),
    "triangle of damping": (lambda: make(C=np.triu(K2)), "C has one entry of each mirrored pair"),
    "triangle of the mass": (
        lambda: make(M=np.triu(K2), triangles="whole"), "M is not symmetric: row 1, column 2 is -1"
    ),
    "triangles": (
        lambda: make(triangles="lower"), """triangles = 'lower' is not known; give "symmetric" or"""
    ),
    "mass not symmetric": (lambda: make(M=SKEW), "M is not symmetric: row 1, column 2 is -1"),
    "no mass at all": (lambda: make(M=np.zeros((2, 2))), "M is zero; give at least one"),
    "no mass, no stiffness": (
        lambda: make(M=EMPTY, K=EMPTY), "q2 has neither mass nor stiffness; give it one of them"
    ),
    "no mass, K not symmetric": (
        lambda: make(M=EMPTY, K=SKEW, triangles="whole"), "condensation of q2, which has no"
    ),
    "damped without mass": (lambda: make(M=EMPTY, C=I2), "C acts on q2, which has no mass; give"),
    "contact without mass": (
        lambda: make(M=EMPTY, contacts=FrictionContact("q2")), "contacts act at q2, which has no"
    ),
    "watched force without mass": (
        lambda: make(M=EMPTY, forcing=HarmonicForce("q2"), watch={"u": "q2"}),
        "q2 has no mass and moves statically with the force at q2",
    ),
    "loose without mass": (
        lambda: make(M=np.diag([1.0, 0, 0]), K=np.array([[1.0, 0, 0], [0, 1, -1], [0, -1, 1]])),
        "degrees of freedom without mass can move without force",
    ),
    "half a mass": (lambda: make(M=np.array([[1, 1], [1, 0]])), "the mass of q2 is 0 kg, and oth"),
    "singular mass": (lambda: make(M=np.ones((2, 2))), "some displacement has no mass"),
    "negative mass": (lambda: make(M=np.array([[1, 2], [2, 1]])), "or a negative one"),
    "large singular mass": (
        lambda: make(M=sparse.block_diag([np.ones((2, 2))] * 400), K=sparse.eye_array(800)),
        "some displacement has no mass",
    ),
    "K": (
        lambda: make(K=SKEW), "K is not symmetric: row 1, column 2 is -1, row 2, column 1 is -0.5, "
        "which differ by more than 1e-09 of the largest entry; put its antisymmetric part, (K - K^T"
    ),
    "a term of K": (lambda: make(K={1: K2, "p": SKEW}), "K is not symmetric: row 1, column 2 is"),
    "K for Rayleigh": (
        lambda: make(C=ProportionalDamping(1, 1), K=SKEW, triangles="whole"), "so give C as a matr"
    ),
    "K for modes": (
        lambda: make(K=SKEW, triangles="whole", reduction=ModalReduction(1)), "needs a symmetric on"
    ),
    "33 contacts": (
        lambda: make(contacts=[FrictionContact("q1")] * 33), "33 friction contacts are more than 32"
    ),
    "ratio": (lambda: make(C=ModalDamping(-0.1)), "zeta = -0.1 is outside its bounds"),
    "alpha_M": (lambda: ProportionalDamping(-1), "alpha_M = -1 is outside"),
    "same names": (lambda: make(names="a a"), "two degrees of freedom are called a"),
    "bad name": (lambda: make(names=["a", "3"]), "'3' cannot name a degree of freedom"),
    "state names": (lambda: make(names="x vx"), "two states are called vx; give each comp"),
    "no names": (lambda: make(names=5), "1 names are given for 2"),
    "boundary number": (lambda: make(reduction=CraigBampton(3, 1)), "boundary = 3; give the names"),
    "no triples": (lambda: MultiHarmonicForce("q1", (1, 2)), "is not a periodic force"),
    "pairs": (lambda: PolynomialSpring("q1", (1, 2)), "is not a polynomial"),
    "axis number": (lambda: GeometricSpring("q1", 3), "axis = 3 does not fit"),
    "inner name": (lambda: make(names="p_a b"), "cannot be called p_a"),
    "no modes": (lambda: ModalReduction(), "needs modes, how many to keep, or up_to"),
    "both": (lambda: ModalReduction(2, 5.0), "give one of the two"),
    "up_to": (lambda: ModalReduction(up_to=-1), "up_to = -1 Hz"),
    "nothing in band": (lambda: make(reduction=ModalReduction(up_to=1e-6)), "has no mode up to"),
    "no boundary": (lambda: CraigBampton((), 1), "boundary = (); give the names"),
    "all boundary": (lambda: make(reduction=CraigBampton(("q1", "q2"), 0)), "nothing to reduce"),
    "floating": (
        lambda: make(K=np.diag([1.0, 0.0]), reduction=CraigBampton("q1", 1)),
        "does not hold the rest of the structure",
    ),
    "reduction": (lambda: make(reduction="modal"), "reduction = 'modal' is none"),
    "unknown dof": (
        lambda: make(names="root tip", elements=CubicSpring("tpi")),
        "no degree of freedom 'tpi'; did you mean tip? it has root, tip",
    ),
    "zero direction": (lambda: LinearSpring({"q1": 0.0}), "direction of a linear spring is zero"),
    "empty direction": (lambda: LinearSpring({}), "direction of a linear spring is zero"),
    "weight": (lambda: LinearSpring({"q1": np.nan}), "has the weight nan for q1"),
    "no direction": (lambda: LinearSpring(3), "acts at 3, which is not a direction"),
    "negative damper": (lambda: LinearSpring("q1", c=-1), "c = -1 is outside its bounds"),
    "NaN stiffness": (lambda: CubicSpring("q1", k3=np.nan), "k3 = nan is not a finite number"),
    "power": (lambda: PolynomialSpring("q1", {0: 1.0}), "whole numbers from 1 to 15"),
    "no polynomial": (lambda: PolynomialSpring("q1", {}), "is not a polynomial"),
    "exact table": (
        lambda: sf.TabulatedSpring("q1", [(0, 0), (1, 1)]), "without e has corners at its rows"
    ),
    "short table": (lambda: sf.TabulatedSpring("q1", [(0, 0)], e=1), "give 2 to 64 rows of displ"),
    "double row": (
        lambda: sf.TabulatedSpring("q1", [(0, 0), (0, 1)], e=1), "or two forces at one displacement"
    ),
    "exact compliance": (
        lambda: sf.ComplianceLoad("q1"), "without en has a corner where the surfaces part; give en"
    ),
    "exponent": (lambda: sf.ComplianceLoad("q1", en=1, exponent=0.5), "has the exponent 0.5"),
    "exact gap": (lambda: GapSpring("q1", k=1), "has a corner where it is touched"),
    "gap stiffness": (lambda: GapSpring("q1", k=-1, e=1e-3), "k = -1 is outside its bounds"),
    "side": (lambda: GapSpring("q1", e=1e-3, side="up"), "side = 'up' is not known"),
    "axis size": (lambda: GeometricSpring("q1", (1, 0, 0)), "give 1 finite components"),
    "same parameters": (
        lambda: make(elements=[LinearSpring("q1"), LinearSpring("q1")]),
        'two parameters are called k_q1; give each component a name of its own, such as name = "le',
    ),
    "no element": (lambda: make(elements=[3]), "3 is not known among elements"),
    "force among elements": (
        lambda: make(elements=HarmonicForce("q1")), "is not known among elements; give LinearSpring"
    ),
    "law": (lambda: FrictionContact("q1", 0.4), "law = 0.4 is not a friction law"),
    "load": (lambda: FrictionContact("q1", load=[1]), "is not a normal force; give a number in N"),
    "no load": (lambda: FrictionContact("q1", load=0), "Ns = 0 is outside its bounds"),
    "normal": (lambda: ContactLoad(None), "a contact load acts at None, which is not a direction"),
    "three directions": (
        lambda: FrictionContact(("a", "b", "c")), "acts along 3 directions; give 1 to 2"
    ),
    "parallel": (
        lambda: FrictionContact(("a", {"a": -2})), "a, -2 a of a friction contact lie in one anot"
    ),
    "plane of three": (
        lambda: GeometricSpring(("a", "b", {"a": 1, "b": 1}), (1, 1, 1)), "a, b, a + b of a geom"
    ),
    "harmonic": (lambda: HarmonicForce("q1", harmonic=1.5), "has the harmonic 1.5"),
    "harmonics": (lambda: MultiHarmonicForce("q1", {0: 1.0}), "is not a periodic force"),
    "amplitude": (lambda: MultiHarmonicForce("q1", {1: np.inf}), "F1 = inf is not a finite"),
    "samples": (lambda: TabulatedForce("q1", [1, 2]), "at least 3 finite numbers"),
    "constant table": (lambda: TabulatedForce("q1", [1, 1, 1]), "all the same"),
    "long table": (
        lambda: TabulatedForce("q1", np.sign(np.arange(400) - 200.0)),
        "has harmonics up to 200; give harmonics, at most 64",
    ),
    "base": (lambda: make(forcing=BaseMotion({"q9": 1})), "no degree of freedom 'q9'"),
    "watch": (lambda: make(watch="q1"), "watch = 'q1' is not a mapping"),
    "watch name": (lambda: make(watch={"1": "q1"}), "'1' cannot name an output"),
    "parameter": (
        lambda: make(elements=CubicSpring("q1")).replace(K3=1), "did you mean k3?"
    ),
    "stiff": (
        lambda: make(K=np.array([[4e12 + 1, -4e12], [-4e12, 4e12 + 1]])),
        "mode 2 at 4.5e+05 Hz is 8e+12 times as stiff as mode 1 at 0.16 Hz, which its rounding "
        "errors hide; give reduction=ModalReduction(modes=1), or a stiffness at most 1e+12 times",
    ),
    "too many": (lambda: make(M=np.eye(201), K=np.eye(201)), "has 201 degrees of freedom"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD.values(), ids=BAD)
def test_one_sentence(case):
    function, part = case
    with pytest.raises(InputError) as caught:
        function()
    message = str(caught.value)
    assert part in message
    assert "\n" not in message
    assert len(message) < 400


def test_a_level_cannot_lift_the_contact():
    model = make(
        contacts=FrictionContact("q1", load=ModulatedLoad(Ns=1, Nd=0.6)),
        forcing=HarmonicForce("q2", F=1.0),
    )
    assert model.forcing_amplitude == "level"
    with pytest.raises(InputError, match="is not below Ns"):
        model.replace(level=2)


def test_a_regularized_law_may_rest_and_a_memory_gives_states():
    resting = FrictionContact("q1", Regularized(Coulomb()), Vd=0)
    assert make(contacts=resting).values["Vd"] == 0
    model = make(contacts=FrictionContact("q1", BoucWen(), name="pad"))
    assert [state.name for state in model.states] == ["q1", "q2", "vq1", "vq2", "z_pad"]


def test_matrices_without_symmetry_are_taken_where_they_may_be():
    model = make(C=SKEW, K=SKEW, triangles="whole")
    assert "energy" not in [output.name for output in model.outputs()]
    assert model.stiffness_matrix == pytest.approx(SKEW)
    assert Structure.from_tables(model.to_tables()).replace(K=model.structure["K"]) == model


@pytest.mark.parametrize(("stiffness", "said"), [
    (K2, ()),
    (K2 - np.eye(2), ("1 of 2 modes have negative stiffness: only elements, contacts and",)),
    (np.array([[1, -1], [-1, 1]]), ("1 of 2 modes have no stiffness: only elements",)),
    (SKEW, ("K is not symmetric, so that there is no energy of the structure",)),
])  # fmt: skip
def test_what_is_unusual_is_said(stiffness, said):
    notes = make(K=stiffness, triangles="whole").notes
    assert len(notes) == len(said)
    assert all(note.startswith(words) for note, words in zip(notes, said, strict=True))


def test_steady_sliding_is_not_followed_to_a_surface_at_rest():
    tip = FrictionContact("tip", Coulomb(), Vd="2 m/s")
    rubbing = Structure(M=[[1.0]], K=[[100.0]], names=("tip",), contacts=tip)
    with pytest.raises(InputError, match="Vd = 0 is outside its bounds; Vd must be > 0 m/s"):
        response(rubbing, vary="Vd", span=(1, 0))
