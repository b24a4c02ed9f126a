"""Structures from matrices, with elements, friction contacts and forcing."""

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
from slipfold.models.structures.springs import (
    GeometricSpring as GeometricSpring,
)
from slipfold.models.structures.springs import LinearSpring as LinearSpring
from slipfold.models.structures.springs import PolynomialSpring as PolynomialSpring
from slipfold.models.structures.structure import Structure as Structure
