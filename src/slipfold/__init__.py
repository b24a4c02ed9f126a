"""Vibration of sliding structures with friction, and how it loses stability.

Three lines lead to a bifurcation diagram:

>>> import slipfold as sf
>>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.98), f=12.5)
>>> [point.type for branch in diagram.branches for point in branch.special]
['PD', 'NS', 'NS']
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from slipfold.branches.branch import Branch as Branch
    from slipfold.branches.settings import Event as Event
    from slipfold.branches.settings import Settings as Settings
    from slipfold.branches.special_point import SpecialPoint as SpecialPoint
    from slipfold.computations.loci import bifurcation_set as bifurcation_set
    from slipfold.computations.loci import locus as locus
    from slipfold.computations.long_term import attractors as attractors
    from slipfold.computations.long_term import basin_fractions as basin_fractions
    from slipfold.computations.long_term import basins as basins
    from slipfold.computations.long_term import lyapunov as lyapunov
    from slipfold.computations.long_term import regimes as regimes
    from slipfold.computations.long_term import simulate as simulate
    from slipfold.computations.long_term import sweep as sweep
    from slipfold.computations.measured import fit as fit
    from slipfold.computations.measured import measure as measure
    from slipfold.computations.measured import plan_measurement as plan_measurement
    from slipfold.computations.response import gradients as gradients
    from slipfold.computations.response import response as response
    from slipfold.computations.response import responses as responses
    from slipfold.computations.study import study as study
    from slipfold.computations.thresholds import design as design
    from slipfold.computations.thresholds import threshold_map as threshold_map
    from slipfold.computations.thresholds import uncertainty as uncertainty
    from slipfold.continuation.end import End as End
    from slipfold.continuation.settings import Newton as Newton
    from slipfold.continuation.settings import Steps as Steps
    from slipfold.errors import InputError as InputError
    from slipfold.loci.locus import Locus as Locus
    from slipfold.loci.locus import LocusEnd as LocusEnd
    from slipfold.loci.locus import LocusPoint as LocusPoint
    from slipfold.loci.region_map import Region as Region
    from slipfold.loci.region_map import RegionCheck as RegionCheck
    from slipfold.loci.region_map import RegionMap as RegionMap
    from slipfold.loci.region_map import RegionMotion as RegionMotion
    from slipfold.long_term.attractor import Attractor as Attractor
    from slipfold.long_term.spectrum import Spectrum as Spectrum
    from slipfold.long_term.spectrum import find_spectrum as find_spectrum
    from slipfold.models.friction.jenkins import Iwan as Iwan
    from slipfold.models.friction.jenkins import Jenkins as Jenkins
    from slipfold.models.friction.law import FrictionLaw as FrictionLaw
    from slipfold.models.friction.with_memory import BoucWen as BoucWen
    from slipfold.models.friction.with_memory import Dahl as Dahl
    from slipfold.models.friction.with_memory import LuGre as LuGre
    from slipfold.models.friction.without_memory import Coulomb as Coulomb
    from slipfold.models.friction.without_memory import CoulombViscous as CoulombViscous
    from slipfold.models.friction.without_memory import CubicStribeck as CubicStribeck
    from slipfold.models.friction.without_memory import RationalStribeck as RationalStribeck
    from slipfold.models.friction.without_memory import Regularized as Regularized
    from slipfold.models.friction.without_memory import Stribeck as Stribeck
    from slipfold.models.model import Model as Model
    from slipfold.models.quantities import Limit as Limit
    from slipfold.models.quantities import Output as Output
    from slipfold.models.quantities import Parameter as Parameter
    from slipfold.models.quantities import State as State
    from slipfold.models.registry import built_in_models as built_in_models
    from slipfold.models.sliding_oscillator import SlidingOscillator as SlidingOscillator
    from slipfold.models.structures.contacts import ConstantLoad as ConstantLoad
    from slipfold.models.structures.contacts import ContactLoad as ContactLoad
    from slipfold.models.structures.contacts import FrictionContact as FrictionContact
    from slipfold.models.structures.contacts import ModulatedLoad as ModulatedLoad
    from slipfold.models.structures.cost import Cost as Cost
    from slipfold.models.structures.damping import ModalDamping as ModalDamping
    from slipfold.models.structures.damping import ProportionalDamping as ProportionalDamping
    from slipfold.models.structures.forcing import BaseMotion as BaseMotion
    from slipfold.models.structures.forcing import HarmonicForce as HarmonicForce
    from slipfold.models.structures.forcing import MultiHarmonicForce as MultiHarmonicForce
    from slipfold.models.structures.forcing import TabulatedForce as TabulatedForce
    from slipfold.models.structures.reduction import CraigBampton as CraigBampton
    from slipfold.models.structures.reduction import ModalReduction as ModalReduction
    from slipfold.models.structures.reduction import ReductionReport as ReductionReport
    from slipfold.models.structures.springs import CubicSpring as CubicSpring
    from slipfold.models.structures.springs import GapSpring as GapSpring
    from slipfold.models.structures.springs import GeometricSpring as GeometricSpring
    from slipfold.models.structures.springs import LinearSpring as LinearSpring
    from slipfold.models.structures.springs import PolynomialSpring as PolynomialSpring
    from slipfold.models.structures.structure import Structure as Structure
    from slipfold.models.system import System as System
    from slipfold.models.unforced import Unforced as Unforced
    from slipfold.orbits.check import OrbitCheck as OrbitCheck
    from slipfold.orbits.extrema import Extrema as Extrema
    from slipfold.orbits.find import periodic_orbit as periodic_orbit
    from slipfold.orbits.periodic_orbit import PeriodicOrbit as PeriodicOrbit
    from slipfold.parameter_space.least_squares import Estimate as Estimate
    from slipfold.parameter_space.measurement import Measurement as Measurement
    from slipfold.parameter_space.measurement import Quantity as Quantity
    from slipfold.parameter_space.measurement import read_measurement as read_measurement
    from slipfold.parameter_space.sampling import SobolIndices as SobolIndices
    from slipfold.parameter_space.scatter import Scatter as Scatter
    from slipfold.progress import Progress as Progress
    from slipfold.results.attractors import Attractors as Attractors
    from slipfold.results.attractors import BasinFractions as BasinFractions
    from slipfold.results.attractors import Basins as Basins
    from slipfold.results.attractors import Share as Share
    from slipfold.results.attractors import Shares as Shares
    from slipfold.results.diagram import Diagram as Diagram
    from slipfold.results.locus_diagram import LocusDiagram as LocusDiagram
    from slipfold.results.measured import Fit as Fit
    from slipfold.results.measured import MeasurementPlan as MeasurementPlan
    from slipfold.results.responses import Responses as Responses
    from slipfold.results.result import load as load
    from slipfold.results.simulation import Simulation as Simulation
    from slipfold.results.study import StudyResult as StudyResult
    from slipfold.results.thresholds import Design as Design
    from slipfold.results.thresholds import ThresholdMap as ThresholdMap
    from slipfold.results.trajectories import (
        LyapunovExponents as LyapunovExponents,
    )
    from slipfold.results.trajectories import RegimeMap as RegimeMap
    from slipfold.results.trajectories import Sweep as Sweep
    from slipfold.results.uncertainty import (
        ThresholdUncertainty as ThresholdUncertainty,
    )
    from slipfold.tori.surface import TorusSpectrum as TorusSpectrum
    from slipfold.tori.torus_branch import Locked as Locked
    from slipfold.tori.torus_branch import TorusBranch as TorusBranch

_HOMES = {
    "slipfold.branches.branch": ("Branch",),
    "slipfold.branches.settings": ("Event", "Settings"),
    "slipfold.branches.special_point": ("SpecialPoint",),
    "slipfold.computations.loci": ("bifurcation_set", "locus"),
    "slipfold.computations.long_term": (
        "attractors",
        "basin_fractions",
        "basins",
        "lyapunov",
        "regimes",
        "simulate",
        "sweep",
    ),
    "slipfold.computations.measured": ("fit", "measure", "plan_measurement"),
    "slipfold.computations.response": ("gradients", "response", "responses"),
    "slipfold.computations.study": ("study",),
    "slipfold.computations.thresholds": ("design", "threshold_map", "uncertainty"),
    "slipfold.continuation.end": ("End",),
    "slipfold.continuation.settings": ("Newton", "Steps"),
    "slipfold.errors": ("InputError",),
    "slipfold.loci.locus": ("Locus", "LocusEnd", "LocusPoint"),
    "slipfold.loci.region_map": ("Region", "RegionCheck", "RegionMap", "RegionMotion"),
    "slipfold.long_term.attractor": ("Attractor",),
    "slipfold.long_term.spectrum": ("Spectrum", "find_spectrum"),
    "slipfold.models.friction.jenkins": ("Iwan", "Jenkins"),
    "slipfold.models.friction.law": ("FrictionLaw",),
    "slipfold.models.friction.with_memory": ("BoucWen", "Dahl", "LuGre"),
    "slipfold.models.friction.without_memory": (
        "Coulomb",
        "CoulombViscous",
        "CubicStribeck",
        "RationalStribeck",
        "Regularized",
        "Stribeck",
    ),
    "slipfold.models.model": ("Model",),
    "slipfold.models.quantities": ("Limit", "Output", "Parameter", "State"),
    "slipfold.models.registry": ("built_in_models",),
    "slipfold.models.sliding_oscillator": ("SlidingOscillator",),
    "slipfold.models.structures.contacts": (
        "ConstantLoad",
        "ContactLoad",
        "FrictionContact",
        "ModulatedLoad",
    ),
    "slipfold.models.structures.cost": ("Cost",),
    "slipfold.models.structures.damping": ("ModalDamping", "ProportionalDamping"),
    "slipfold.models.structures.forcing": (
        "BaseMotion",
        "HarmonicForce",
        "MultiHarmonicForce",
        "TabulatedForce",
    ),
    "slipfold.models.structures.reduction": ("CraigBampton", "ModalReduction", "ReductionReport"),
    "slipfold.models.structures.springs": (
        "CubicSpring",
        "GapSpring",
        "GeometricSpring",
        "LinearSpring",
        "PolynomialSpring",
    ),
    "slipfold.models.structures.structure": ("Structure",),
    "slipfold.models.system": ("System",),
    "slipfold.models.unforced": ("Unforced",),
    "slipfold.orbits.check": ("OrbitCheck",),
    "slipfold.orbits.extrema": ("Extrema",),
    "slipfold.orbits.find": ("periodic_orbit",),
    "slipfold.orbits.periodic_orbit": ("PeriodicOrbit",),
    "slipfold.parameter_space.least_squares": ("Estimate",),
    "slipfold.parameter_space.measurement": ("Measurement", "Quantity", "read_measurement"),
    "slipfold.parameter_space.sampling": ("SobolIndices",),
    "slipfold.parameter_space.scatter": ("Scatter",),
    "slipfold.progress": ("Progress",),
    "slipfold.results.attractors": ("Attractors", "BasinFractions", "Basins", "Share", "Shares"),
    "slipfold.results.diagram": ("Diagram",),
    "slipfold.results.locus_diagram": ("LocusDiagram",),
    "slipfold.results.measured": ("Fit", "MeasurementPlan"),
    "slipfold.results.responses": ("Responses",),
    "slipfold.results.result": ("load",),
    "slipfold.results.simulation": ("Simulation",),
    "slipfold.results.study": ("StudyResult",),
    "slipfold.results.thresholds": ("Design", "ThresholdMap"),
    "slipfold.results.trajectories": ("LyapunovExponents", "RegimeMap", "Sweep"),
    "slipfold.results.uncertainty": ("ThresholdUncertainty",),
    "slipfold.tori.surface": ("TorusSpectrum",),
    "slipfold.tori.torus_branch": ("Locked", "TorusBranch"),
}
_HOME = {name: home for home, names in _HOMES.items() for name in names}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    """Import a public name, or look the version up."""
    if name == "__version__":
        return import_module("slipfold.version").package_version()
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(import_module(_HOME[name]), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """List the public names and what every module has."""
    return sorted({*__all__, *globals()})
