r"""
Squeal by mode coupling
========================

A mass on a belt, held by two inclined springs. The friction coefficient is constant, yet friction
follows the normal force and couples the two directions without symmetry; at a certain coefficient
two frequencies meet and one of the motions begins to grow. The minimal model of Hoffmann, Fischer,
Allgaier and Gaul, with a contact that hardens.
"""

from comparison import Comparison

import slipfold as sf

model = sf.built_in_models()["squeal"]()
diagram = sf.response(model, vary="mu", span=(0.3, 1.2))
diagram.plot("x")
print(diagram.summary())

# %%
# Without damping the frequencies meet at :math:`\mu = k_{12} / k_c`. Equal damping of both moves
# the onset to :math:`(k_{12} + c^2 k_1 / k_{12}) / k_c`.

hopf = next(p for p in diagram.branches[0].special if p.type == "HB")
onset = sf.locus(hopf, vary=("mu", "c"), window={"mu": (0.7, 0.9), "c": (0.001, 0.3)})
onset.plot()
(line,) = [locus for locus in onset.loci if locus.type == "HB"]

# %%

table = Comparison()
exact = (model.k12 + model.c**2 * model.k1 / model.k12) / model.kc
table.add("onset of squeal mu", hopf.value, exact, "closed form")
small = sf.response(
    model.replace(c=1e-4), vary="mu", span=(0.3, 1.2), settings=sf.Settings(largest_period=1)
)
onset = next(p for p in small.branches[0].special if p.type == "HB")
table.add("onset for c = 1e-4", onset.value, "0.75", "Hoffmann et al. 2002, undamped", within=1e-7)
mu, c = line.values[len(line.values) // 2]
exact = (model.k12 + c**2 * model.k1 / model.k12) / model.kc
table.add(f"on its locus, at c = {c:.4g}: mu", mu, float(exact), "closed form")
cycles = diagram.branches[hopf.leads_to - 1]
table.check("squealing at mu = 1.2", cycles.orbit(-1))
table
