"""Plain harmonic balance on the strip, condensed to its contact.

    python bench/peers/balance_structures.py --repeat 1 [--settings usual|fine]

As the field does it (Krack and Gross, Harmonic Balance for Nonlinear Vibration Problems, Springer
2019): the linear structure enters by its receptance at the contact, from a sparse factorization for
each harmonic and frequency; friction is evaluated in time. The frequency takes equal steps, each
with the last solution as its guess. There is no stability. `usual` has 25 harmonics at 121
frequencies, of the largest strip at three of them; `fine` has 75 at these three, the reference.
"""

import sys
import time
from pathlib import Path

import numpy as np
import record
import scipy
from scipy.sparse.linalg import splu

sys.path.insert(0, str(Path(__file__).parents[1]))

from strip import BAND, COMPARED, FORCE, FRICTION, MESHES, Array, Strip, strip

PRESETS = {"usual": {"harmonics": 25, "points": 121}, "fine": {"harmonics": 75, "points": 3}}

LARGEST = 1000
"""Degrees of freedom up to which the whole response takes seconds."""


def receptance(made: Strip, s: complex) -> complex:
    """Displacement of the tip for a unit force there."""
    load = np.zeros(made.mass.shape[0], complex)
    load[made.tip] = 1
    matrix = (s * s * made.mass + (1 + s * made.beta) * made.stiffness).tocsc()
    return complex(splu(matrix).solve(load)[made.tip])


class Balance:
    """Fourier coefficients of the tip, real: mean, cosines, sines."""

    def __init__(self, made: Strip, harmonics: int) -> None:
        self.made, self.orders = made, np.arange(1, harmonics + 1)
        count = 8 * (harmonics + 1)
        angle = 2 * np.pi * np.outer(np.arange(count), self.orders) / count
        self.basis = np.hstack([np.ones((count, 1)), np.cos(angle), np.sin(angle)])
        self.into = 2 * self.basis.T / count
        self.into[0] /= 2

    def answer(self, omega: float) -> Array:
        """Matrix from coefficients of a force at the tip to those of its displacement."""
        h = len(self.orders)
        result = np.zeros((2 * h + 1, 2 * h + 1))
        result[0, 0] = receptance(self.made, 0j).real
        for k in self.orders:
            g = receptance(self.made, 1j * k * omega)
            result[np.ix_([k, h + k], [k, h + k])] = [[g.real, g.imag], [-g.imag, g.real]]
        return result

    def rate(self, omega: float) -> Array:
        """Matrix from coefficients of the displacement to samples of the velocity."""
        h = len(self.orders)
        cosines, sines = self.basis[:, 1 : h + 1], self.basis[:, h + 1 :]
        zero = np.zeros((len(self.basis), 1))
        return omega * np.hstack([zero, -self.orders * sines, self.orders * cosines])

    def solve(self, guess: Array, omega: float) -> Array:
        """Newton's method with the exact Jacobian."""
        answer, rate = self.answer(omega), self.rate(omega) / self.made.rise
        load, unit = np.eye(1, len(guess), 1)[0] * FORCE, np.eye(len(guess))
        x = guess
        for _ in range(50):
            pull = np.tanh(rate @ x)
            gap = x - answer @ (load - FORCE * FRICTION * self.into @ pull)
            slopes = self.into @ ((1 - pull**2)[:, None] * rate)
            step = np.linalg.solve(unit + FORCE * FRICTION * answer @ slopes, gap)
            x = x - step
            if np.abs(step).max() < 1e-10 * np.abs(x).max():
                return x
        raise RuntimeError(f"Newton's method does not converge at {omega:g} rad/s")


def main() -> None:
    """Time the responses, print the record."""
    options = record.arguments("harmonic balance on the strip", PRESETS)
    preset = PRESETS[options.settings]
    found = record.Record(
        peer="harmonic balance",
        version=f"SciPy {scipy.__version__}",
        settings={"name": options.settings, **preset},
        build_seconds=0.0,
        seconds={},
        processor_seconds={},
    )
    for size in MESHES:
        made = strip(size)
        balance = Balance(made, preset["harmonics"])
        few = preset["points"] <= len(COMPARED) or size > LARGEST
        shares = COMPARED if few else np.linspace(*BAND, preset["points"])
        times, first = [], {}
        for _ in range(options.repeat):
            begun, used = time.perf_counter(), time.process_time()
            x = np.zeros(2 * preset["harmonics"] + 1)
            for share in shares:
                x = balance.solve(x, share * made.lowest)
                first[round(share, 6)] = float(np.hypot(x[1], x[1 + preset["harmonics"]]))
            times.append((time.perf_counter() - begun, time.process_time() - used))
        found.seconds[str(size)] = [wall for wall, _ in times]
        found.processor_seconds[str(size)] = [used for _, used in times]
        found.points[str(size)] = len(shares)
        found.final_state[str(size)] = [first[share] for share in COMPARED]
    found.print()


if __name__ == "__main__":
    main()
