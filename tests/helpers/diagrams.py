"""A diagram put together by hand from reference orbits, and a comparison of diagrams."""

import numpy as np

from slipfold import Branch, Diagram, End, Event, Settings, SlidingOscillator, SpecialPoint, Steps
from slipfold.results.records import Provenance

MODEL = SlidingOscillator(f=12.5, alpha="59.9deg")

# Orbits of period 1 at f = 12.5 Hz from shared/reference/sliding.json: Nd = 0, 0.05, 0.1 N.
STATES = np.array(
    [
        [0.117402977126, 0.061106649797, 0.0, 0.0],
        [0.098213199247, -0.035076538475, 1.722533093226, 16.172916936663],
        [0.081835200408, -0.116609441502, 3.233575818289, 31.049107141969],
    ]
)
EIGENVALUES = np.array([-0.530528347 + 78.291272945j, -1.898259036 + 44.811184307j])
MULTIPLIERS = np.array(
    [
        np.exp(EIGENVALUES / 12.5).repeat(2),
        [-1.164143839166, 0.956714471746 + 0.019196489885j, 0, -0.633704555798],
        [-2.281699695519, 0.95219399991 + 0.019415035225j, 0, -0.323102851611],
    ]
)
MULTIPLIERS[0, 1::2] = MULTIPLIERS[0, ::2].conj()
MULTIPLIERS[1:, 2] = MULTIPLIERS[1:, 1].conj()


def special_point(kind="PD", **changes):
    given = {
        "type": kind,
        "name": "period doubling",
        "model": MODEL.replace(Nd=0.043578911491),
        "vary": "Nd",
        "value": 0.043578911491,
        "uncertainty": 1e-13,
        "period": 1,
        "nodes": STATES[1:2] * 0.9,
        "multipliers": np.array([-1, 0.957 + 0.019j, 0.957 - 0.019j, -0.7]),
        "multiplier_uncertainty": np.array([1e-12, 2e-12, 2e-12, 5e-13]),
        "residual": 1e-13,
        "arclength": 0.5,
        "criticality": "supercritical",
        "coefficient": -1.25,
        "leads_to": 2,
    }
    given.update(changes)
    if "value" in changes:
        given["model"] = MODEL.replace(Nd=changes["value"])
    return SpecialPoint(**given)


def response_branch(**changes):
    given = {
        "id": 1,
        "kind": "periodic",
        "period": 1,
        "parent": None,
        "model": MODEL,
        "vary": "Nd",
        "parameter": np.array([0.0, 0.05, 0.1]),
        "nodes": STATES[:, None],
        "multipliers": MULTIPLIERS,
        "residual": np.array([1e-14, 2e-14, 3e-13]),
        "arclength": np.array([0.0, 0.6, 1.1]),
        "special": (
            special_point(),
            special_point(
                "EVENT",
                name="spring collapse",
                value=0.1,
                arclength=1.1,
                nodes=STATES[2:3],
                criticality=None,
                coefficient=None,
                leads_to=None,
            ),
        ),
        "stopped": End("limit", "spring collapsed: l/L fell to 0.01; stay below <this> value", 0.1),
        "started": End("span", "the span begins here", 0.0),
    }
    given.update(changes)
    return Branch(**given)


def doubled_branch():
    none = {"criticality": None, "coefficient": None, "leads_to": None, "period": 2}
    nodes = np.stack([STATES[1:], STATES[1:] * 1.01])
    nodes[1, 1, 0] = 1 / 3
    return response_branch(
        id=2,
        period=2,
        parent=1,
        parameter=np.array([0.05, 0.1]),
        nodes=nodes,
        multipliers=MULTIPLIERS[1:] * 0.5,
        residual=np.array([1e-14, 2e-14]),
        arclength=np.array([0.0, 0.25]),
        special=(
            special_point("NS", name="torus", value=0.0567, arclength=0.1, nodes=nodes[0], **none),
            special_point("EVENT", name="x", value=0.07, arclength=0.2, nodes=nodes[1], **none),
        ),
        stopped=End("span", "the span ends here", 0.1),
        started=End("bifurcation", "left branch 1 at a period doubling", 0.05),
    )


def made_diagram(**changes):
    given = {
        "model": MODEL,
        "vary": "Nd",
        "span": (0.0, 0.1),
        "branches": (response_branch(), doubled_branch()),
        "settings": Settings(steps=Steps(largest=0.05), largest_period=4),
        "events": (Event("x", 0.3), Event("Vrel", 0.1 + 0.2, "min", stop=True)),
        "provenance": Provenance("0.1", "7.13", "2.4", "3.11", "2026-01-02T03:04:05+00:00", 0.1),
    }
    given.update(changes)
    return Diagram(**given)
