r"""
BifurcationKit's tutorials
==========================

In BifurcationKit.jl a problem is a Julia function, a named tuple of parameters and a lens that says
which of them varies; ``ContinuationPar`` has steps, and ``continuation`` follows equilibria. Cycles
and curves in two parameters are further calls, each from a special point by its number, with
options of their own. Values are those that its documentation prints (version 0.7.3); it locates
points by bisection and gives intervals, which are the differences allowed here.
"""

import demos
from comparison import Comparison

import slipfold as sf


def special(diagram: sf.Diagram, kind: str, number: int = 0) -> sf.SpecialPoint:
    return [point for branch in diagram.branches for point in branch.special if point.type == kind][
        number
    ]


def named(locus: sf.LocusDiagram, kind: str, number: int = 0) -> tuple[float, ...]:
    return [point for curve in locus.loci for point in curve.special if point.type == kind][
        number
    ].values


table = Comparison()

# %%
# CO oxidation: the model of Bykov, Yablonskii and Kim. Folds and Hopf points of equilibria, then
# both as curves over q2 and k. MatCont's manual has the same points, with more digits right.

page, matcont = "tutorial CO oxidation", "MatCont's manual, a catalytic oscillator"
print((demos.FOLDER / "systems" / "co.toml").read_text())
co = demos.response("co")
co.plot("x")
print(co.summary())
for kind, number, theirs, interval, exact in (
    ("HB", 0, "1.04100305", 1.2e-4, "1.040991"),
    ("LP", 0, "1.05220009", 1e-5, "1.052200"),
    ("LP", 1, "1.04204852", 4e-7, "1.042049"),
    ("HB", 1, "1.05218722", 1.4e-3, "1.051558"),
):
    value = special(co, kind, number).value
    table.add(f"CO: {kind} q2", value, theirs, page, interval)
    table.add("the same", value, exact, matcont)

# %%
# Two Bogdanov-Takens points and a cusp on the folds, two Bautin points on the Hopf points.

window = ((0.5, 2.0), (0.1, 1.2))
curves = sf.locus([special(co, "LP"), special(co, "HB")], ("q2", "k"), window, switch=False)
curves.plot()
tests = "its test of the same model"
table.add("CO: BT k", max(named(curves, "BT", i)[1] for i in (0, 1)), "0.97139757", tests, 1e-5)
table.add("CO: BT k", min(named(curves, "BT", i)[1] for i in (0, 1)), "0.7223392465", tests, 4e-7)
table.add("CO: CP k", named(curves, "CP")[1], "0.35665351", tests, 1e-3)
table.add("CO: GH k", max(named(curves, "GH", i)[1] for i in (0, 1)), "0.305879", tests)
table.add("CO: GH k", min(named(curves, "GH", i)[1] for i in (0, 1)), "0.232", tests)

# %%
# Extended Lorenz-84 model: all five points of codimension two of equilibria.

page = "tutorial extended Lorenz-84"
print((demos.FOLDER / "systems" / "lorenz84.toml").read_text())
lorenz = demos.response("lorenz84")
lorenz.plot("X")
for kind, number, theirs, interval in (
    ("LP", 0, "1.54664839", 2e-8),
    ("HB", 0, "1.61975642", 2e-4),
    ("HB", 1, "2.46723305", 3e-5),
    ("HB", 2, "2.85996783", 1.1e-4),
):
    table.add(f"Lorenz-84: {kind} F", special(lorenz, kind, number).value, theirs, page, interval)

# %%

window = ((1.0, 3.0), (-0.06, 0.06))
points = [special(lorenz, "LP"), special(lorenz, "HB", 1)]
curves = sf.locus(points, ("F", "T"), window, switch=False)
curves.plot()
table.add("Lorenz-84: BT T", abs(named(curves, "BT")[1]), "0.02094014", page, 1e-6)
table.add("Lorenz-84: ZH T", abs(named(curves, "ZH")[1]), "0.00012644", page, 3e-7)
table.add("Lorenz-84: GH T", named(curves, "GH")[1], "0.05019751", page, 1e-6)
table.add("Lorenz-84: HH T", named(curves, "HH")[1], "0.02627340", page, 2e-6)

# %%
# Steinmetz and Larter's model: cycles with a fold and a Neimark-Sacker point, both as curves over
# k8 and k7. Where the curve of Neimark-Sacker points changes from soft to hard (CH) the
# documentation prints 1.74705 by shooting and 1.85525 by collocation; slipfold has 1.757359574 by
# both, and its coefficients at fixed k7 = 1.75 and 1.765 have different signs.

page = "tutorial Steinmetz-Larter"
cycles = demos.response("steinmetz")
cycles.plot("A")
window = ((0.75, 0.95), (1.4, 1.9))
points = [special(cycles, "NS"), special(cycles, "LP")]
curves = sf.locus(points, ("k8", "k7"), window, switch=False)
curves.plot()
table.add(
    "Steinmetz-Larter: CH k7", named(curves, "CH")[1], "1.75735957381", "both discretizations"
)
table.add("Steinmetz-Larter: R1 k7", named(curves, "R1", 0)[1], "1.85749669", page, 5e-4)
table.add(
    "the same on the other curve",
    named(curves, "R1", 1)[1],
    named(curves, "R1")[1],
    "the two agree",
)

# %%
# Times of equilibria and cycles over one parameter, in one run on one machine. BifurcationKit is
# not installed there, so AUTO stands for it, on the same files of equations.

print(demos.machine())
demos.Times(["co", "lorenz84", "steinmetz"])

# %%

table
