"""Orbits, cycles and equilibria: their equations, how perturbations grow, extrema."""

from slipfold.orbits.check import OrbitCheck as OrbitCheck
from slipfold.orbits.extrema import Extrema as Extrema
from slipfold.orbits.find import periodic_orbit as periodic_orbit
from slipfold.orbits.periodic_orbit import PeriodicOrbit as PeriodicOrbit
