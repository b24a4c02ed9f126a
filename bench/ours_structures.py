"""slipfold on the strip, printed as the peers print theirs.

    python bench/ours_structures.py --repeat 2 [--settings smooth|dry]

From sparse matrices to the response with stability and bifurcations. `built` is what is done
once: modes, the reduction, compiled forces. The orbits that are compared are outside the measured
time.
"""

import time

import numpy as np

import slipfold as sf
from peers import record
from slipfold.version import package_version
from strip import BAND, COMPARED, DAMPING, DRY_SIZES, FORCE, FRICTION, MESHES, strip

ACCURACY, HARMONIC = 1e-5, 25
"""Largest error of receptances up to this harmonic."""

SAMPLES = 512
"""Of an orbit: harmonics up to 25 matter to 1e-9."""


SIZES = {"smooth": tuple(MESHES), "dry": DRY_SIZES}


def structure(size: int, kind: str = "smooth") -> tuple[sf.Structure, float]:
    """The strip as a user would write it, and its lowest frequency in Hz."""
    made = strip(size)
    lowest = made.lowest / (2 * np.pi)
    tip = f"q{made.tip + 1}"
    dry = sf.Coulomb(mu_k=FRICTION)
    law = dry if kind == "dry" else sf.Regularized(dry, e=made.rise)
    model = sf.Structure(
        made.mass,
        sf.ProportionalDamping(beta_K=2 * DAMPING / made.lowest),
        made.stiffness,
        reduction=sf.FreeInterface(up_to=HARMONIC * lowest, accuracy=ACCURACY),
        contacts=sf.FrictionContact(tip, law, load=FORCE, Vd=0),
        forcing=sf.HarmonicForce(tip, F=FORCE),
        watch={"w": tip},
        f=BAND[0] * lowest,
    )
    return model, lowest


def main() -> None:
    """Warm up, time, print the record."""
    options = record.arguments("slipfold on the strip", SIZES)
    found = record.Record("slipfold", package_version(), {}, 0.0, {}, processor_seconds={})
    for size in SIZES[options.settings]:
        begun = time.process_time()
        model, lowest = structure(size, options.settings)
        span = (BAND[0] * lowest, BAND[1] * lowest)
        sf.response(model, "f", span)
        built, times = time.process_time() - begun, []
        for _ in range(options.repeat):
            begun, used = time.perf_counter(), time.process_time()
            branch = sf.response(model, "f", span).branches[0]
            times.append((time.perf_counter() - begun, time.process_time() - used))
        task = str(size)
        found.settings[task] = {
            "modes": len(model.natural_frequencies),
            "built": built - min(used for _, used in times),
        }
        found.seconds[task] = [wall for wall, _ in times]
        found.processor_seconds[task] = [used for _, used in times]
        found.points[task] = len(branch)
        found.final_state[task] = [
            first_harmonic(model.replace(f=share * lowest)) for share in COMPARED
        ]
    found.print()


def first_harmonic(model: sf.Structure) -> float:
    """Amplitude of the first harmonic of the tip."""
    moved = sf.periodic_orbit(model).output("w", SAMPLES)[1]
    return float(2 * np.abs(np.fft.rfft(moved)[1]) / len(moved))


if __name__ == "__main__":
    main()
