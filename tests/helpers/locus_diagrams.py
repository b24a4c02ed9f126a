"""A bifurcation set put together by hand, and a comparison of such diagrams."""

import dataclasses
from collections.abc import Mapping

import numpy as np

from helpers.diagrams import STATES
from slipfold import (
    End,
    Locus,
    LocusDiagram,
    LocusPoint,
    Region,
    RegionCheck,
    RegionMap,
    RegionMotion,
    Settings,
    SlidingOscillator,
    Steps,
)
from slipfold.results.records import Provenance

MODEL = SlidingOscillator(f=11.5, Nd=0.0, alpha="59.9deg")
VARY = ("f", "Nd")
ON_PD = np.array([-1, 0.957 + 0.019j, 0.957 - 0.019j, -0.7])
ON_NS = np.array([0.6 + 0.8j, 0.6 - 0.8j, 0.3, 0.2])
ON_LP = np.array([1, 0.5, 0.3, 0.2], dtype=complex)


def locus_point(kind="GPD", **changes):
    given = {
        "type": kind,
        "name": "generalized period doubling",
        "vary": VARY,
        "values": (12.43620847, 0.04201532481),
        "uncertainty": (1e-12, 2e-13),
        "period": 1,
        "nodes": STATES[1:2] * 0.9,
        "multipliers": ON_PD.copy(),
        "residual": 1e-13,
        "arclength": 0.5,
        "coefficients": {"l2": -0.1 / 3, "b": 0.0},
        "leads_to": (2, 3),
    }
    given.update(changes)
    values = dict(zip(given["vary"], given["values"], strict=True))
    given.setdefault("model", MODEL.replace(**values))
    return LocusPoint(**given)


def minimum():
    return locus_point(
        "MIN",
        name="smallest Nd",
        values=(12.46290698, 0.04008397729),
        arclength=0.75,
        coefficients={"b": 47.0487},
        criticality="supercritical",
        leads_to=(),
    )


def doubling_locus(**changes):
    given = {
        "id": 1,
        "type": "PD",
        "period": 1,
        "parent": None,
        "model": MODEL.replace(f=12.5, Nd=0.0435789),
        "vary": VARY,
        "values": np.array([[11.5, 0.58], [12.4362, 0.042], [13.5, 0.29]]),
        "nodes": STATES[:, None],
        "multipliers": np.tile(ON_PD, (3, 1)),
        "coefficient": np.array([-44.7, np.nan, 92.0]),
        "residual": np.array([1e-14, 2e-14, 3e-13]),
        "arclength": np.array([0.0, 0.6, 1.1]),
        "special": (locus_point(), minimum()),
        "started": End("window", "left the window at f = 11.5", (11.5, 0.58)),
        "stopped": End("limit", "spring collapsed; stay below <this> value", (13.5, 0.29)),
    }
    given.update(changes)
    return Locus(**given)


def fold_locus(**changes):
    nodes = np.stack([STATES[1:], STATES[1:] * 1.01])
    nodes[1, 1, 0] = 1 / 3
    given = {
        "id": 2,
        "type": "LP",
        "period": 2,
        "parent": 1,
        "values": np.array([[12.4362, 0.042], [11.5, 0.15]]),
        "nodes": nodes,
        "multipliers": np.tile(ON_LP, (2, 1)),
        "coefficient": np.full(2, np.nan),
        "residual": np.array([1e-14, 2e-14]),
        "arclength": np.array([0.0, 0.25]),
        "special": (),
        "started": End("codimension-2", "emanates at a GPD of locus 1", (12.4362, 0.042)),
        "stopped": End("window", "left the window at f = 11.5", (11.5, 0.15)),
    }
    given.update(changes)
    return doubling_locus(**given)


def torus_locus(**changes):
    none = {"coefficients": {}, "leads_to": (), "period": 2, "multipliers": ON_NS.copy()}
    chenciner = locus_point("CH", name="Chenciner", values=(12.5, 0.108), arclength=0.1, **none)
    given = {
        "id": 3,
        "type": "NS",
        "values": np.array([[12.54, 0.2], [12.4978, 0.108], [12.6, 0.06], [12.54, 0.2]]),
        "period": 2,
        "parent": 1,
        "nodes": np.stack([STATES[[0, 1, 2, 0]]] * 3, axis=1),
        "multipliers": np.tile(ON_NS, (4, 1)),
        "coefficient": np.array([-0.5, 1.0, 2.0, -0.5]),
        "residual": np.full(4, 1e-14),
        "arclength": np.array([0.0, 0.1, 0.3, 0.4]),
        "special": (chenciner,),
        "started": End("closed", "the locus closed on itself", (12.54, 0.2)),
        "stopped": End("closed", "the locus closed on itself", (12.54, 0.2)),
    }
    given.update(changes)
    return doubling_locus(**given)


def region_map(**changes):
    checks = (
        RegionCheck((12.0, 0.1), "rest", 1, True, "settled on period 1"),
        RegionCheck((12.0, 0.1), "2", 0, False, "left the orbit; it is <not> stable"),
    )
    motions = (
        RegionMotion((12.5, 0.4), "torus", 0, 1e-9),
        RegionMotion((12.5, 0.6), "periodic", 4),
    )
    given = {
        "first": np.array([12.0, 13.0]),
        "second": np.array([0.1, 0.3, 0.5]),
        "labels": np.array([[1, 2], [1, 0], [3, 3]]),
        "regions": (
            Region(1, (1,), 1 / 3, (12.0, 0.1), True, checks[:1]),
            Region(2, (1, 2), 1 / 6, (13.0, 0.1), False, checks),
            Region(3, (), 1 / 3, (12.5, 0.5), True, (), motions),
        ),
    }
    given.update(changes)
    return RegionMap(**given)


def made_locus_diagram(**changes):
    given = {
        "model": MODEL,
        "vary": VARY,
        "window": ((11.5, 13.5), (0.0, 0.98)),
        "loci": (doubling_locus(), fold_locus(), torus_locus()),
        "regions": region_map(),
        "settings": Settings(steps=Steps(largest=0.05), largest_period=4),
        "provenance": Provenance("0.1", "7.13", "2.4", "3.11", "2026-01-02T03:04:05+00:00", 0.1),
    }
    given.update(changes)
    return LocusDiagram(**given)


def assert_same(one, other, where="diagram"):
    """Compare results part by part and number for number, NaN equal to NaN."""
    if isinstance(one, float):  # NumPy's as well
        assert isinstance(other, float), where
        assert one == other or (np.isnan(one) and np.isnan(other)), where
        return
    assert type(one) is type(other), where
    if isinstance(one, np.ndarray):
        np.testing.assert_array_equal(one, other, strict=True, err_msg=where)
    elif dataclasses.is_dataclass(one):
        for field in dataclasses.fields(one):
            name = field.name
            assert_same(getattr(one, name), getattr(other, name), f"{where}.{name}")
    elif isinstance(one, Mapping):
        assert list(one) == list(other), where
        assert_same(tuple(one.values()), tuple(other.values()), where)
    elif isinstance(one, tuple):
        assert len(one) == len(other), where
        for index, (a, b) in enumerate(zip(one, other, strict=True)):
            assert_same(a, b, f"{where}[{index}]")
    else:
        assert one == other, where
