"""Whatever is given where it makes no sense: a sentence, never a traceback of something else."""

import inspect
import random

import numpy as np
import pytest

import slipfold as sf
from slipfold import InputError
from slipfold.models.parametric import Parametric

JUNK = [
    *(None, 3, -1, 0, 1.5, np.nan, True, 1 + 2j, 10**400, "x", "q1", "5 mm", b"z", object()),
    *([], {}, (), [1, 2], {"q1": 1}, {1: 2.0}, {None: 1}, {"q1": "a"}, ("q1", "q2"), ((1, 2),)),
    *([("q1", 2)], [[1, 2], [3]], np.eye(2), np.ones(3), sf.Coulomb(), sf.ConstantLoad(1.0)),
]  # fmt: skip
PUBLIC = [getattr(sf, name) for name in sf.__all__]
CLASSES = [
    item
    for item in PUBLIC
    if item.__module__.startswith("slipfold.models.structures")
    and item.__name__ != "ReductionReport"
]


@pytest.mark.parametrize("cls", CLASSES, ids=lambda cls: cls.__name__)
def test_junk(cls):
    choose = random.Random(20260105)
    named = [p for p in inspect.signature(cls).parameters.values() if p.kind != p.VAR_KEYWORD]
    for _ in range(150):
        given = {
            p.name: choose.choice(JUNK)
            for p in named
            if p.default is p.empty or choose.random() < 0.4
        }
        if cls is sf.Structure:
            given |= {"M": np.eye(2), "K": np.eye(2)}
        try:
            made = cls(**given)
        except InputError:
            continue
        # What passes can be hashed and compared, and has a kind of its own kind.
        assert hash(made) == hash(made)
        if isinstance(made, Parametric):
            assert made.kind.kind == made.kind
