"""Where the tip of the oscillator begins to stick, and what motions do beside.

python docs/figures/stick_slip_map.py writes stick_slip_coulomb.json and stick_slip_stribeck.json,
which stick_slip_study.py draws.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import slipfold as sf
from slipfold.continuation.newton import correct
from slipfold.loci.describe import pair_of
from slipfold.loci.locus_equations import LocusEquations
from slipfold.loci.one_locus import trace_locus
from slipfold.loci.start import regular_start
from slipfold.orbits.discretisations.switched_shooting import SwitchedShooting
from slipfold.orbits.kinds import orbits_of
from slipfold.orbits.stick_slip.touching_shooting import TouchingShooting

FOLDER = Path(__file__).parent

LAWS = {
    "coulomb": sf.Coulomb(mu_k=0.5, mu_s=0.5),
    "stribeck": sf.Stribeck(mu_s=0.6, mu_k=0.5, vs=0.05),
}
"""Friction laws by name."""

SPEEDS = np.array([0.02, 0.05, 0.08, 0.11])
PULSATIONS = np.array([0.15, 0.5, 0.85])
FREQUENCY = 12.5
BRANCH = 0.3
"""Pulsation at which the response is followed to where stick begins."""

KEPT = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4)
"""Slip that is kept on the way to the touch, over its size."""

PERIODS, TOLERANCE = 150, 1e-4
"""Forcing periods that a motion is given to settle, and how far from settled it may be."""


def main() -> None:
    """Compute what is not in the files yet."""
    for law in LAWS:
        found = read(law)
        if "loci" not in found:
            found["loci"] = where_stick_begins(law)
            write(law, found)
    found = read("coulomb")
    for speed in SPEEDS:
        for pulsation in PULSATIONS:
            if key(speed, pulsation) not in found:
                found[key(speed, pulsation)] = outcome("coulomb", float(speed), float(pulsation))
                write("coulomb", found)


def read(law: str) -> dict[str, Any]:
    """Return what is known of a law."""
    file = FOLDER / f"stick_slip_{law}.json"
    return json.loads(file.read_text()) if file.exists() else {}


def write(law: str, found: dict[str, Any]) -> None:
    """Keep what is known of a law."""
    file = FOLDER / f"stick_slip_{law}.json"
    file.write_text(json.dumps(found, indent=0, sort_keys=True) + "\n")


def where_stick_begins(name: str) -> list[list[list[float]]]:
    """Return the locus of GRAZE of the response of period 1, as two lines from one place.

    The response ends where slip is nearly zero, which is near enough to begin with.
    """
    oscillator = sf.SlidingOscillator(friction=LAWS[name], f=FREQUENCY, Nd=BRANCH)
    branch = sf.response(oscillator, vary="Vd", span=(0.2, SPEEDS[0])).branches[0]
    model = branch.orbit(-1).model
    orbits = orbits_of(model, {"Vd": 0.3, "Nd": 0.9}, 1, 1, by=SwitchedShooting)
    z = orbits.unknown(branch.nodes[-1][:1], model)
    by = TouchingShooting.at(orbits.by, orbits.nodes(z), orbits.constants(z), "GRAZE")
    z = orbits.described_by(by).adopt(orbits, z)
    for kept in KEPT:
        touch = replace(by.touch, level=kept)
        nearer = TouchingShooting(by.model, by.free, by.period, touch, by.kind)
        curve = LocusEquations(orbits.described_by(nearer), "GRAZE")
        found = correct(curve, z, np.eye(1, len(z), len(z) - 1)[0])
        if not found.converged:
            return []
        z = found.z
    settings, window = sf.Settings(), ((0.005, 0.2), (0.0, 0.98))
    trails = [
        trace_locus(curve, point, window, settings)
        for point in regular_start(curve, z, settings).points
    ]
    return [[pair_of(item.curve, item) for item in trail.points] for trail in trails]


def key(speed: float, pulsation: float) -> str:
    """Return the name of a place."""
    return f"Vd={speed:.4g} Nd={pulsation:.4g}"


def outcome(name: str, speed: float, pulsation: float) -> dict[str, float | str | None]:
    """Return what a motion from rest does in the end."""
    oscillator = sf.SlidingOscillator(friction=LAWS[name])
    place = {"f": FREQUENCY, "Nd": pulsation, "Vd": speed}
    motion = sf.simulate(oscillator, PERIODS, tolerance=TOLERANCE, **place)
    last = motion.last_round
    if motion.stopped is not None or last is None:
        return {"regime": "stopped", "period": None, "stops": 0, "fraction": None, "x": None}
    return {
        "regime": motion.regime,
        "period": motion.settlement.period,
        "stops": len(last.sticking),
        "fraction": round(last.fraction, 9),
        "x": float(last.most[[state.name for state in motion.model.states].index("x")]),
    }


if __name__ == "__main__":
    main()
