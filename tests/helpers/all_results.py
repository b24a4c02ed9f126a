"""One result of each kind, small enough to be computed in a moment."""

import slipfold as sf
from helpers.diagrams import made_diagram
from helpers.dry_friction import den_hartog
from helpers.locus_diagrams import made_locus_diagram
from helpers.threshold_maps import made_map

DUFFING = sf.built_in_models()["duffing"]
SLIDING = sf.SlidingOscillator
BOX = {"q": (-3, 3), "v": (-3, 3)}
SCATTER = {"mu": "normal 5%", "Vd": "uniform 1%"}


def doubling():
    return sf.response(SLIDING(), vary="Nd", span=(0, 0.05), f=12.5).special[0]


def with_tori():
    model = sf.built_in_models()["vanderpol"](a=0.3, e=0.2)
    return sf.response(model, vary="w", span=(1, 1.03), tori=True)


def fitted():
    seen = sf.measure(SLIDING(f=12.5, mu=0.46), "Nd", [0.01, 0.02, 0.03, 0.04], ["max y"])
    return sf.fit(SLIDING(f=12.5), seen, {"mu": (0.3, 0.7)})


def planned():
    forces = [0.005 * step for step in range(1, 9)]
    quantities, fitted = ["max y", "max x"], ["mu", "Vd"]
    return sf.plan_measurement(SLIDING(f=12.5), "Nd", forces, quantities, fitted, errors=1e-4)


def study(compute, cases):
    given = {"model": "sliding", "parameters": {"f": 12.5}, "compute": compute, "cases": cases}
    return sf.study(given)


MADE = {
    "diagram": made_diagram,
    "empty diagram": lambda: made_diagram(branches=()),
    "cycles": lambda: sf.response(
        sf.built_in_models()["lorenz"](), "rho", (0, 30), settings=sf.Settings(largest_period=1)
    ),
    "gradients": lambda: sf.response(SLIDING(), "Nd", (0, 0.05), gradients=True, f=12.5),
    "isolated": lambda: sf.response(DUFFING(), "W", (1.0, 1.3), search=True),
    "stick": lambda: sf.response(den_hartog(0.6, 0.5, 0.8), "f", (0.09, 0.1)),
    "tori": with_tori,
    "loci": made_locus_diagram,
    "loci without regions": lambda: made_locus_diagram(regions=None),
    "responses": lambda: sf.responses(
        SLIDING(f=12.5), "Nd", (0, 0.1), over=[{"Vd": 0.5}, {"Vd": "600mm/s"}, {"Vd": -1}]
    ),
    "threshold map": made_map,
    "simulation": lambda: sf.simulate(SLIDING(), 600, f=12.2, Nd=0.15),
    "stopped simulation": lambda: sf.simulate(SLIDING(), 20, {"y": -0.99995}),
    "stick-slip": lambda: sf.simulate(den_hartog(0.6, 0.5, 0.8), 20),
    "lyapunov": lambda: sf.lyapunov(SLIDING(), 1000, f=12.5, Nd=0.02),
    "attractors": lambda: sf.attractors(DUFFING(W=1.2), BOX, starts=16),
    "basins": lambda: sf.basins(DUFFING(W=1.2), BOX, points=(6, 5)),
    "phases": lambda: sf.basins(DUFFING(W=1.2), {"phase": (0, 1), "v": (-4, 4)}, points=(4, 5)),
    "basin fractions": lambda: sf.basin_fractions(
        DUFFING(), "W", (1, 1.4), BOX, points=3, starts=32
    ),
    "sweep": lambda: sf.sweep(
        SLIDING(), "Nd", (0.05, 0.15), points=5, starts=1, f=12.2, transient=200, periods=32
    ),
    "regimes": lambda: sf.regimes(
        SLIDING(), {"f": (12.2, 12.21), "Nd": (0.06, 0.16)}, points=(2, 3)
    ),
    "uncertainty": lambda: sf.uncertainty(
        doubling(), SCATTER, samples=32, loads=[0.0434, "50mN"], indices=True
    ),
    "design": lambda: sf.design(doubling(), {"Vd": (0.4, 0.8)}, above=["50mN"], load="20mN"),
    "fit": fitted,
    "plan": planned,
    "grid": lambda: study(
        {"what": "threshold", "vary": "Nd", "span": [0, 0.9]},
        {"grid": {"Vd": [0.5, 0.6], "alpha": [1.0, 1.05]}},
    ),
    "list": lambda: study(
        {"what": "response", "vary": "Nd", "span": [0, 0.1]},
        {"list": [{"Vd": 0.5}, {"Vd": 0.6}]},
    ),
}
"""What makes a result of each kind, by what is special about it."""
