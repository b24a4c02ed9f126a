"""Friction laws, one class each."""

from slipfold.models.friction.jenkins import Iwan as Iwan
from slipfold.models.friction.jenkins import Jenkins as Jenkins
from slipfold.models.friction.law import FrictionLaw as FrictionLaw
from slipfold.models.friction.law import MemoryLaw as MemoryLaw
from slipfold.models.friction.record import friction_laws as friction_laws
from slipfold.models.friction.record import law_from_record as law_from_record
from slipfold.models.friction.record import law_record as law_record
from slipfold.models.friction.with_memory import BoucWen as BoucWen
from slipfold.models.friction.with_memory import Dahl as Dahl
from slipfold.models.friction.with_memory import LuGre as LuGre
from slipfold.models.friction.without_memory import Coulomb as Coulomb
from slipfold.models.friction.without_memory import CoulombViscous as CoulombViscous
from slipfold.models.friction.without_memory import CubicStribeck as CubicStribeck
from slipfold.models.friction.without_memory import RationalStribeck as RationalStribeck
from slipfold.models.friction.without_memory import Regularized as Regularized
from slipfold.models.friction.without_memory import Stribeck as Stribeck
