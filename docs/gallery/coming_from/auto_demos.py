r"""
AUTO's demos
============

A demo of AUTO is a file of equations in Fortran, a script, and a file of constants for each run:
mesh ``NTST``, steps ``DS``, ``DSMIN`` and ``DSMAX``, tolerances ``EPSL``, ``EPSU`` and ``EPSS``,
what is free (``ICP``) and where to leave from (``IRS``, ``ISW``). In slipfold the equations are a
file of text, and one command follows the equilibrium, the cycles from its Hopf points and what
branches from these. Steps, meshes and tolerances are its own. AUTO's points below are computed by
AUTO from the same files of equations, with the constants of its demos; where its manual prints a
value, the table quotes that, too. Four demos are run to make this page; the points of the others,
which take a second each, are those of the run in which both programs were timed.
"""

import demos
from comparison import Comparison

table = Comparison()
manual = "AUTO's manual"
print(demos.command("ab"))
print((demos.FOLDER / "systems" / "ab.toml").read_text())

# %%
# ``ab``: two reactions in a stirred tank. AUTO runs the equilibrium with ``IPS=1, ICP=[1]``, then
# restarts at the Hopf point with ``IPS=2, ICP=[1, 11]`` and stops at a period of 1000. slipfold
# ends the branch where the duration grows and the parameter no longer changes, and names why.

ab = demos.response("ab")
ab.plot("y")
print(ab.summary())
demos.compare(table, "ab", ab)
table.add("ab: first LP p", ab.branches[0].special[0].value, "0.1057390", f"{manual}, tutorial")
table.add("ab: homoclinic p", ab.branches[1].parameter[-1], "0.1055071", f"{manual}, tutorial")

# %%
# ``tor``: an electronic circuit, built in as ``freire`` and on a page of its own. AUTO restarts at
# the Hopf point, then at the first branch point with ``ISW=-1``. Both branches snake to homoclinic
# orbits.

print(demos.command("tor"))
demos.compare(table, "tor")

# %%
# ``plp``: an enzyme on a membrane. The branch of cycles closes on the second Hopf point. AUTO goes
# back along it and reports both folds again, and a fold at each Hopf point.

print(demos.command("plp"))
plp = demos.response("plp")
plp.plot("s")
demos.compare(table, "plp", plp)

# %%
# ``chu``: Chua's circuit. Of cycles that near a homoclinic orbit there are infinitely many folds,
# a period doubling beside each. AUTO's steps pass most of these.

print(demos.command("chu"))
chu = demos.response("chu")
chu.plot("x")
demos.compare(table, "chu", chu)

# %%
# ``pen``: two pendula that turn together. In AUTO both angles grow; here the second is its lead
# over the first, and ``angle = true`` says that the first turns. AUTO starts from a file of
# numbers, ``dat='pen'``; slipfold from what a motion settles on, ``--settled``. From the period
# doubling rotations out of phase begin.

print(demos.command("pen"))
demos.compare(table, "pen")

# %%
# ``kpr``: Koper's model, where AUTO finds a homoclinic orbit by thirteen runs of HomCont. Cycles
# born at the Hopf point lead to the same orbit.

print(demos.command("kpr"))
demos.compare(table, "kpr")
end = demos.measured()["systems"]["kpr"]["ours"]["ends"][1]
table.add("kpr: homoclinic lambda", end, "-1.85119", manual)

# %%
# ``lor``: period doublings of the Lorenz equations. AUTO needs a run for each, ``ISW=-1``, and
# another mesh: ``NTST`` 20, 40, 60.

print(demos.command("lor"))
demos.compare(table, "lor")

# %%
# ``pp2``: fish, sharks, and a quota of fishing.

print(demos.command("pp2"))
demos.compare(table, "pp2")

# %%
# ``abc``: three reactions in a stirred tank, with two families of cycles between four Hopf points.

print(demos.command("abc"))
abc = demos.response("abc")
abc.plot("z")
demos.compare(table, "abc", abc)

# %%
# ``frc``: a neuron under a periodic current. AUTO wants autonomous equations, so the demo adds an
# oscillator of two states; a file with ``[forcing]`` has a period instead.

print(demos.command("frc"))
ours, theirs = (demos.measured()["systems"]["frc"][of]["last"][0] for of in ("ours", "theirs"))
table.add("frc: largest v at a period of 1", ours, f"{theirs:.10g}", "AUTO-07p, run here", 5e-4)

# %%
# All branches of each demo in one run on one machine. AUTO's time is its own clock, slipfold's is
# with normal forms, uncertainties and checks, and of all branches, which in ``tor``, ``chu`` and
# ``pen`` are more than AUTO was requested. A point of AUTO's that is not ours is a Hopf point or a
# homoclinic orbit that AUTO takes for another point.

print(demos.machine())
demos.Times(["ab", "tor", "plp", "chu", "pen", "kpr", "lor", "pp2", "abc", "frc"])

# %%

table
