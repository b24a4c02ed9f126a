"""Every special point of a set of systems as JSON, run by itself in an environment of choice.

python located_points.py > points.json
"""

import json
import sys

import numpy as np

import slipfold as sf
from slipfold.models.registry import model_named

RESPONSES = {
    # Models, what is varied and the largest period followed: every kind of special point.
    "sliding 12.5": ("sliding", {"f": 12.5}, "Nd", (0, 0.98), 8),
    "sliding 12.2": ("sliding", {"f": 12.2}, "Nd", (0, 0.98), 8),
    "sliding slow": ("sliding", {"f": 12.5, "Vd": 0.4}, "Nd", (0, 0.5), 2),
    "sliding over f": ("sliding", {"Nd": 0.1}, "f", (11.5, 13), 2),
    "duffing": ("duffing", {}, "W", (0.9, 1.4), 1),
    "vanderpol": ("vanderpol", {}, "w", (1.0, 1.2), 1),
    "mathieu": ("mathieu", {}, "h", (0.0, 0.1), 1),
    "lure": ("lure", {}, "a", (1.2, 0.6), 2),
    "freire": ("freire", {}, "n", (-0.56, -0.62), 1),
    "squeal": ("squeal", {}, "mu", (0.5, 0.8), 1),
    "stribeck": ("stribeck", {}, "vd", (2.0, 0.9), 1),
    "lorenz": ("lorenz", {}, "rho", (0.5, 20), 1),
}

HARDENING = {
    "name": "hardening",
    "parameters": {"F": 1.0},
    "states": {"q": "v", "v": "F*cos(t) - 0.2*v - q - q^3"},
    "forcing": {"period": "2*pi"},
}
"""Its symmetric orbit loses its symmetry and regains it: branch points of forced orbits."""


def responses():
    for name, (model, values, vary, span, largest) in RESPONSES.items():
        settings = sf.Settings(largest_period=largest)
        yield name, sf.response(model_named(model, **values), vary, span, settings=settings)
    settings = sf.Settings(largest_period=1)
    yield "hardening", sf.response(sf.System(**HARDENING), "F", (0, 12), settings=settings)


def numbers(item):
    multipliers = np.asarray(item.multipliers)
    return {
        "type": item.type,
        "value": item.value,
        "uncertainty": item.uncertainty,
        "multipliers": [[value.real, value.imag] for value in multipliers],
        "multiplier_uncertainty": list(item.multiplier_uncertainty),
        "criticality": item.criticality,
    }


def main():
    found = {
        name: [[numbers(item) for item in branch.special] for branch in diagram.branches]
        for name, diagram in responses()
    }
    json.dump(found, sys.stdout)


if __name__ == "__main__":
    main()
