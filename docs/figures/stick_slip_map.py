"""Where the tip of the oscillator begins to stick, and what motions do beside.

python docs/figures/stick_slip_map.py writes stick_slip_coulomb.json and stick_slip_stribeck.json,
which stick_slip_study.py draws.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

import slipfold as sf

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

PERIODS, TOLERANCE = 150, 1e-4
"""Forcing periods that a motion is given to settle, and how far from settled it may be."""

LONGER = 400
"""Forcing periods after which motions under exact and regularized friction are compared."""

SMOOTHED = (1e-2, 1e-3)
"""Slip speed below which friction is smooth, over the speed of the plate."""


def main() -> None:
    """Compute what is not in the files yet."""
    for law in LAWS:
        found = read(law)
        if "locus" not in found:
            found["locus"] = where_stick_begins(law)
            write(law, found)
    found = read("coulomb")
    for speed in SPEEDS:
        for pulsation in PULSATIONS:
            if key(speed, pulsation) not in found:
                found[key(speed, pulsation)] = outcome("coulomb", float(speed), float(pulsation))
                write("coulomb", found)
            place = found[key(speed, pulsation)]
            if "off" not in place:
                place["off"] = off(float(speed), float(pulsation))
                write("coulomb", found)


def read(law: str) -> dict[str, Any]:
    """Return what is known of a law."""
    file = FOLDER / f"stick_slip_{law}.json"
    return json.loads(file.read_text()) if file.exists() else {}


def write(law: str, found: dict[str, Any]) -> None:
    """Keep what is known of a law."""
    file = FOLDER / f"stick_slip_{law}.json"
    file.write_text(json.dumps(found, indent=0, sort_keys=True) + "\n")


def where_stick_begins(name: str) -> list[list[float]]:
    """Return speeds and pulsations at which the response of period 1 begins to stick."""
    oscillator = sf.SlidingOscillator(friction=LAWS[name], f=FREQUENCY, Nd=BRANCH)
    alone = sf.Settings(largest_period=1)
    found = sf.response(oscillator, vary="Vd", span=(0.2, SPEEDS[0]), settings=alone).special
    graze = next(item.point for item in found if item.point.type == "GRAZE")
    (locus,) = sf.locus(graze, ("Vd", "Nd"), ((0.005, 0.2), (0.0, 0.98)), switch=False).loci
    return locus.values.tolist()


def computed_regimes() -> sf.RegimeMap:
    """Return what motions do over speed and pulsation under Coulomb friction."""
    oscillator = sf.SlidingOscillator(friction=LAWS["coulomb"], f=FREQUENCY)
    plane = {"Vd": (0.02, 0.2), "Nd": (0.02, 0.96)}
    return sf.regimes(oscillator, plane, points=(25, 20), transient=150)


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
        "x": float(last.maximum[[state.name for state in motion.model.states].index("x")]),
    }


def off(speed: float, pulsation: float) -> list[float | None]:
    """Return by how much the largest x/L under regularized friction is off, smoothed less and less.

    None where a motion has not settled, or on another period.
    """
    place = {"f": FREQUENCY, "Nd": pulsation, "Vd": speed}
    exact = sf.simulate(sf.SlidingOscillator(friction=LAWS["coulomb"]), LONGER, **place)
    found = list[float | None]()
    for share in SMOOTHED:
        law = sf.Regularized(LAWS["coulomb"], "sqrt", e=share * speed)
        smooth = sf.simulate(sf.SlidingOscillator(friction=law), LONGER, **place)
        alike = exact.settlement.period is not None is not smooth.settlement.period
        alike = alike and exact.settlement.period == smooth.settlement.period
        found.append(
            float(smooth.last_round.maximum[0] - exact.last_round.maximum[0]) if alike else None
        )
    return found


if __name__ == "__main__":
    main()
