"""Structures from matrices, with elements, friction contacts and forcing."""

from slipfold.models.structures.components.contacts import FrictionContact as FrictionContact
from slipfold.models.structures.components.forcing import BaseMotion as BaseMotion
from slipfold.models.structures.components.forcing import HarmonicForce as HarmonicForce
from slipfold.models.structures.components.forcing import MultiHarmonicForce as MultiHarmonicForce
from slipfold.models.structures.components.gap_spring import GapSpring as GapSpring
from slipfold.models.structures.components.geometric_spring import (
    GeometricSpring as GeometricSpring,
)
from slipfold.models.structures.components.normal_loads import ConstantLoad as ConstantLoad
from slipfold.models.structures.components.normal_loads import ContactLoad as ContactLoad
from slipfold.models.structures.components.normal_loads import ModulatedLoad as ModulatedLoad
from slipfold.models.structures.components.springs import CubicSpring as CubicSpring
from slipfold.models.structures.components.springs import LinearSpring as LinearSpring
from slipfold.models.structures.components.springs import PolynomialSpring as PolynomialSpring
from slipfold.models.structures.components.tabulated_force import TabulatedForce as TabulatedForce
from slipfold.models.structures.cost import Cost as Cost
from slipfold.models.structures.matrices.damping import ModalDamping as ModalDamping
from slipfold.models.structures.matrices.damping import ProportionalDamping as ProportionalDamping
from slipfold.models.structures.matrices.reduction import CraigBampton as CraigBampton
from slipfold.models.structures.matrices.reduction import ModalReduction as ModalReduction
from slipfold.models.structures.matrices.reduction import ReductionReport as ReductionReport
from slipfold.models.structures.structure import Structure as Structure
