"""From a finite-element model to its friction damper: python docs/figures/friction_damper.py.

It writes friction_damper.png, and with the argument ``sizes`` the table friction_damper_sizes.md.
"""

from __future__ import annotations

import resource
import sys
import time
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy import sparse
from scipy.sparse.linalg import spsolve

import slipfold as sf
from slipfold.plots.style import COLUMN, figure_style

FOLDER = Path(__file__).parent

LENGTH, WIDTH, HEIGHT, YOUNG, POISSON, DENSITY = 0.3, 0.1, 0.002, 210e9, 0.3, 7850.0
"""A steel cantilever, in SI units."""

LOADS = (0.2, 1.2, 7.0, 50.0)
"""Normal forces of the damper in N, of which responses are drawn."""


def assembled(elements, places, size):
    """Add the same element matrices at their places. Shapes: elements (d, d), places (m, d)."""
    rows = np.repeat(places, places.shape[1], axis=1).ravel()
    columns = np.tile(places, places.shape[1]).ravel()
    return [
        sparse.coo_array((np.tile(one.ravel(), len(places)), (rows, columns)), (size, size)).tocsr()
        for one in elements
    ]


def beam(count):
    """Mass, stiffness and names of a cantilever of Euler-Bernoulli elements: w and slope r."""
    h = LENGTH / count
    bent = np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2],
                     [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h**2, -6 * h, 4 * h**2]])  # fmt: skip
    moved = np.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h**2, 13 * h, -3 * h**2],
                      [54, 13 * h, 156, -22 * h],
                      [-13 * h, -3 * h**2, -22 * h, 4 * h**2]])  # fmt: skip
    elements = [
        DENSITY * WIDTH * HEIGHT * h / 420 * moved,
        YOUNG * WIDTH * HEIGHT**3 / 12 / h**3 * bent,
    ]
    places = 2 * np.arange(count)[:, None] + np.arange(4)
    mass, stiffness = assembled(elements, places, 2 * count + 2)
    names = [f"{kind}{node}" for node in range(1, count + 1) for kind in "wr"]
    return mass[2:, 2:], stiffness[2:, 2:], names


def plate(along, across):
    """Mass, stiffness and names of a cantilevered plate of rectangular elements (Melosh)."""
    a, b = LENGTH / along, WIDTH / across
    powers = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3),
              (3, 1), (1, 3)]  # fmt: skip

    def terms(x, y, dx=0, dy=0):
        def slope(power, value, order):
            factor = np.prod([power - step for step in range(order)])
            return factor * value ** max(power - order, 0)

        return np.array([slope(p, x, dx) * slope(q, y, dy) for p, q in powers])

    corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
    rows = [row for x, y in corners
            for row in (terms(x, y), terms(x, y, 0, 1) / b, -terms(x, y, 1, 0) / a)]  # fmt: skip
    shapes = np.linalg.inv(rows)
    ratios = np.array([[1, POISSON, 0], [POISSON, 1, 0], [0, 0, (1 - POISSON) / 2]])
    bending = YOUNG * HEIGHT**3 / 12 / (1 - POISSON**2) * ratios
    mass, stiffness = np.zeros((2, 12, 12))
    places, weights = np.polynomial.legendre.leggauss(4)
    for x, one in zip((places + 1) / 2, weights / 2, strict=True):
        for y, other in zip((places + 1) / 2, weights / 2, strict=True):
            curved = [
                terms(x, y, 2) / a**2,
                terms(x, y, 0, 2) / b**2,
                2 * terms(x, y, 1, 1) / a / b,
            ]
            curved, moved = np.array(curved) @ shapes, terms(x, y)[None] @ shapes
            stiffness += one * other * a * b * curved.T @ bending @ curved
            mass += one * other * a * b * DENSITY * HEIGHT * moved.T @ moved
    nodes = np.arange((along + 1) * (across + 1)).reshape(along + 1, across + 1)
    corners = [nodes[:-1, :-1], nodes[1:, :-1], nodes[1:, 1:], nodes[:-1, 1:]]
    places = 3 * np.stack(corners, -1).reshape(-1, 4)[:, :, None] + np.arange(3)
    mass, stiffness = assembled([mass, stiffness], places.reshape(-1, 12), 3 * nodes.size)
    first = 3 * (across + 1)
    names = [f"{kind}{row}_{column}" for row in range(1, along + 1)
             for column in range(across + 1) for kind in "wab"]  # fmt: skip
    return mass[first:, first:], stiffness[first:, first:], names


def damped(matrices, tip, middle, load=1.0):
    """A cantilever with a force at its tip and a friction damper in its middle."""
    mass, stiffness, names = matrices
    return sf.Structure(
        mass,
        sf.ModalDamping(0.005),
        stiffness,
        names=names,
        reduction=sf.FreeInterface(up_to="800 Hz", accuracy=1e-3),
        contacts=sf.FrictionContact(
            middle, sf.Regularized(sf.Coulomb(mu_k=0.3), e="2 mm/s"), load=load, Vd=0
        ),
        forcing=sf.HarmonicForce(tip, F=0.1),
        watch={"tip": tip},
    )


def receptance(matrices, names, frequencies):
    """Displacement of a degree of freedom for a unit force there, by the full matrices."""
    mass, stiffness, known = matrices
    place = known.index(names)
    force = np.eye(1, len(known), place)[0]
    return [
        spsolve((stiffness * (1 + 0.01j) - (2 * np.pi * f) ** 2 * mass).tocsc(), force)[place]
        for f in frequencies
    ]


def main() -> None:
    """Compute the responses and draw them."""
    matrices = beam(50)
    model = damped(matrices, "w50", "w15")
    print(model.reduction_report)
    with figure_style():
        figure = Figure(figsize=(4 * COLUMN, 1.05 * COLUMN), layout="constrained")
        left, second, third, right = figure.subplots(1, 4)
        draw_receptances(left, matrices, model)
        for load in LOADS:
            diagram = sf.response(model, "f", (14, 45), Ns=load, events=[sf.Event("tip")])
            (branch,) = diagram.branches
            tip = 1e3 * branch.extrema_of("tip").maximum[:, 0]
            second.plot(branch.parameter, tip, label=f"{load:g} N")
            (peak,) = branch.special
            print(f"{load} N: {len(branch)} points, peak {peak.value:.4f} Hz, {branch.stopped}")
        (locus,) = sf.locus(peak, ("f", "Ns"), {"f": (14, 45), "Ns": (0.1, 60)}).loci
        best = next(point for point in locus.special if point.name == "smallest max tip")
        smallest = 1e3 * best.measured
        print(f"best: {best!r}, {smallest:.6g} mm; {len(locus)} points")
        second.plot(locus.values[:, 0], 1e3 * locus.measured, ":", color="black", label="peaks")
        second.plot(best.values[0], smallest, "o", color="black")
        second.set(
            xlabel="forcing frequency $f$ (Hz)", ylabel="largest displacement of the tip (mm)"
        )
        second.set_yscale("log")
        second.legend(title="normal force")
        third.loglog(locus.values[:, 1], 1e3 * locus.measured, color="black")
        third.plot(best.values[1], smallest, "o", color="black", label=f"{best.values[1]:.2f} N")
        third.set(xlabel="normal force $N_s$ (N)", ylabel="peak of the tip (mm)")
        third.legend(title="best force")
        draw_damping(right, model, (2.0, best.values[1]))
        figure.savefig(FOLDER / "friction_damper.png", dpi=200)


def draw_damping(ax, model, loads) -> None:
    """Draw the damping ratio of the first mode over its amplitude, for some normal forces."""
    for load in loads:
        (branch,) = sf.backbone(model, "tip", "4 mm", Ns=load).branches
        ratio = 100 * branch.parameter * branch.durations / (4 * np.pi)
        ax.semilogx(
            1e3 * branch.extrema_of("tip").of("tip")[1][1:], ratio[1:], label=f"{load:.3g} N"
        )
        print(f"free at {load:.4g} N: {len(branch)} points, {ratio[0]:.3f} to {ratio[-1]:.3f} %")
    ax.set(xlabel="amplitude of the tip (mm)", ylabel="damping ratio of the first mode (%)")
    ax.set_xlim(1e-3, 4)
    ax.legend(title="normal force")


def draw_receptances(ax, matrices, model) -> None:
    """Draw the receptance of the tip by the full matrices and by the coordinates kept."""
    frequencies = np.geomspace(8, 3000, 600)
    exact = np.abs(receptance(matrices, "w50", frequencies))
    row = model.basis[matrices[2].index("w50")]
    stiff, mass = np.diag(model.stiffness_matrix), np.diag(model.mass_matrix)
    squares = (2 * np.pi * frequencies[:, None]) ** 2
    few = np.abs((row**2 / (stiff * (1 + 0.01j) - squares * mass)).sum(axis=1))
    ax.loglog(
        frequencies, 1e3 * exact, color="black", label=f"{len(matrices[2])} degrees of freedom"
    )
    ax.loglog(frequencies, 1e3 * few, "--", color="tab:orange", label=f"{len(row)} coordinates")
    ax.axvspan(8, 800, color="0.93", linewidth=0)
    ax.set(xlabel="frequency (Hz)", ylabel="receptance of the tip (mm/N)")
    ax.legend()


def sizes() -> None:
    """Write what structures of several sizes cost."""
    heads = ["structure", "degrees of freedom", "kept", "error", "reduction (s)", "points",
             "ms a point", "MB"]  # fmt: skip
    lines = [f"| {' | '.join(heads)} |", len(heads) * "|---" + "|"]
    for kind, given in (("beam", 10), ("beam", 50), ("beam", 500), ("plate", (19, 5)),
                        ("plate", (57, 58))):  # fmt: skip
        matrices = beam(given) if kind == "beam" else plate(*given)
        ends = ((f"w{given}", f"w{3 * given // 10}") if kind == "beam"
                else (f"w{given[0]}_{given[1] // 2}", f"w{3 * given[0] // 10}_0"))  # fmt: skip
        began = time.process_time()
        model = damped(matrices, *ends)
        report, taken = model.reduction_report, time.process_time() - began
        sf.periodic_orbit(model.replace(f=17.0))  # compiles
        began = time.process_time()
        (branch,) = sf.response(model, vary="f", span=(17, 20), Ns=2).branches
        each = 1e3 * (time.process_time() - began) / len(branch)
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
        numbers = [
            kind, f"{report.whole:,}", len(model.states) // 2, f"{report.receptance_error:.1g}",
            f"{taken:.2g}", len(branch), f"{each:.0f}", memory,
        ]  # fmt: skip
        lines.append(f"| {' | '.join(map(str, numbers))} |")
        print(lines[-1], flush=True)
    (FOLDER / "friction_damper_sizes.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    sizes() if sys.argv[1:] == ["sizes"] else main()
