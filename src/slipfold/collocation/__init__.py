"""A second discretisation of periodic orbits, to check the first: orthogonal collocation.

It shares the model's symbolic equations with the flow, and nothing else.
"""

from slipfold.collocation.collocate import collocate as collocate
from slipfold.collocation.collocated_orbit import CollocatedOrbit as CollocatedOrbit
from slipfold.collocation.equilibrium import exact_equilibrium as exact_equilibrium
