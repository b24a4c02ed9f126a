"""Vibration of sliding structures with friction, and how it loses stability.

Three lines lead to a bifurcation diagram:

>>> import slipfold as sf
>>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.98), f=12.5)
>>> [point.type for branch in diagram.branches for point in branch.special]
['PD', 'NS', 'NS']
"""

from slipfold import figures as _figures  # noqa: F401 (says how results are drawn)
from slipfold.attractors import Spectrum as Spectrum
from slipfold.attractors import find_spectrum as find_spectrum
from slipfold.branches import Branch as Branch
from slipfold.branches import End as End
from slipfold.branches import Event as Event
from slipfold.branches import Newton as Newton
from slipfold.branches import Progress as Progress
from slipfold.branches import Settings as Settings
from slipfold.branches import SpecialPoint as SpecialPoint
from slipfold.branches import Steps as Steps
from slipfold.computations import CaseProgress as CaseProgress
from slipfold.computations import bifurcation_set as bifurcation_set
from slipfold.computations import locus as locus
from slipfold.computations import response as response
from slipfold.computations import responses as responses
from slipfold.computations import simulate as simulate
from slipfold.computations import threshold_map as threshold_map
from slipfold.errors import InputError as InputError
from slipfold.loci.locus import Locus as Locus
from slipfold.loci.locus import LocusEnd as LocusEnd
from slipfold.loci.locus import LocusPoint as LocusPoint
from slipfold.loci.progress import LocusProgress as LocusProgress
from slipfold.loci.region_map import Region as Region
from slipfold.loci.region_map import RegionCheck as RegionCheck
from slipfold.loci.region_map import RegionMap as RegionMap
from slipfold.models import BaseMotion as BaseMotion
from slipfold.models import BoucWen as BoucWen
from slipfold.models import ConstantLoad as ConstantLoad
from slipfold.models import ContactLoad as ContactLoad
from slipfold.models import Cost as Cost
from slipfold.models import Coulomb as Coulomb
from slipfold.models import CoulombViscous as CoulombViscous
from slipfold.models import CraigBampton as CraigBampton
from slipfold.models import CubicSpring as CubicSpring
from slipfold.models import CubicStribeck as CubicStribeck
from slipfold.models import Dahl as Dahl
from slipfold.models import FrictionContact as FrictionContact
from slipfold.models import FrictionLaw as FrictionLaw
from slipfold.models import GapSpring as GapSpring
from slipfold.models import GeometricSpring as GeometricSpring
from slipfold.models import HarmonicForce as HarmonicForce
from slipfold.models import Iwan as Iwan
from slipfold.models import Jenkins as Jenkins
from slipfold.models import Limit as Limit
from slipfold.models import LinearSpring as LinearSpring
from slipfold.models import LuGre as LuGre
from slipfold.models import ModalDamping as ModalDamping
from slipfold.models import ModalReduction as ModalReduction
from slipfold.models import Model as Model
from slipfold.models import ModulatedLoad as ModulatedLoad
from slipfold.models import MultiHarmonicForce as MultiHarmonicForce
from slipfold.models import Output as Output
from slipfold.models import Parameter as Parameter
from slipfold.models import PolynomialSpring as PolynomialSpring
from slipfold.models import ProportionalDamping as ProportionalDamping
from slipfold.models import RationalStribeck as RationalStribeck
from slipfold.models import ReductionReport as ReductionReport
from slipfold.models import Regularised as Regularised
from slipfold.models import SlidingOscillator as SlidingOscillator
from slipfold.models import State as State
from slipfold.models import Stribeck as Stribeck
from slipfold.models import Structure as Structure
from slipfold.models import System as System
from slipfold.models import TabulatedForce as TabulatedForce
from slipfold.models import Unforced as Unforced
from slipfold.models import built_in_models as built_in_models
from slipfold.orbits import Extrema as Extrema
from slipfold.orbits import OrbitCheck as OrbitCheck
from slipfold.orbits import PeriodicOrbit as PeriodicOrbit
from slipfold.orbits import periodic_orbit as periodic_orbit
from slipfold.results import Diagram as Diagram
from slipfold.results import LocusDiagram as LocusDiagram
from slipfold.results import Responses as Responses
from slipfold.results import Simulation as Simulation
from slipfold.results import ThresholdMap as ThresholdMap
from slipfold.results import load as load
from slipfold.thresholds.threshold_map import MapProgress as MapProgress

__all__ = [
    "BaseMotion",
    "BoucWen",
    "Branch",
    "CaseProgress",
    "ConstantLoad",
    "ContactLoad",
    "Cost",
    "Coulomb",
    "CoulombViscous",
    "CraigBampton",
    "CubicSpring",
    "CubicStribeck",
    "Dahl",
    "Diagram",
    "End",
    "Event",
    "Extrema",
    "FrictionContact",
    "FrictionLaw",
    "GapSpring",
    "GeometricSpring",
    "HarmonicForce",
    "InputError",
    "Iwan",
    "Jenkins",
    "Limit",
    "LinearSpring",
    "Locus",
    "LocusDiagram",
    "LocusEnd",
    "LocusPoint",
    "LocusProgress",
    "LuGre",
    "MapProgress",
    "ModalDamping",
    "ModalReduction",
    "Model",
    "ModulatedLoad",
    "MultiHarmonicForce",
    "Newton",
    "OrbitCheck",
    "Output",
    "Parameter",
    "PeriodicOrbit",
    "PolynomialSpring",
    "Progress",
    "ProportionalDamping",
    "RationalStribeck",
    "ReductionReport",
    "Region",
    "RegionCheck",
    "RegionMap",
    "Regularised",
    "Responses",
    "Settings",
    "Simulation",
    "SlidingOscillator",
    "SpecialPoint",
    "Spectrum",
    "State",
    "Steps",
    "Stribeck",
    "Structure",
    "System",
    "TabulatedForce",
    "ThresholdMap",
    "Unforced",
    "bifurcation_set",
    "built_in_models",
    "find_spectrum",
    "load",
    "locus",
    "periodic_orbit",
    "response",
    "responses",
    "simulate",
    "threshold_map",
]
