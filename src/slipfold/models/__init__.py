"""Physics: states, parameters, symbolic equations, outputs and limits of validity."""

from slipfold.models.friction import BoucWen as BoucWen
from slipfold.models.friction import Coulomb as Coulomb
from slipfold.models.friction import CoulombViscous as CoulombViscous
from slipfold.models.friction import CubicStribeck as CubicStribeck
from slipfold.models.friction import Dahl as Dahl
from slipfold.models.friction import FrictionLaw as FrictionLaw
from slipfold.models.friction import Iwan as Iwan
from slipfold.models.friction import Jenkins as Jenkins
from slipfold.models.friction import LuGre as LuGre
from slipfold.models.friction import RationalStribeck as RationalStribeck
from slipfold.models.friction import Regularised as Regularised
from slipfold.models.friction import Stribeck as Stribeck
from slipfold.models.linear_modes import Modes as Modes
from slipfold.models.model import Model as Model
from slipfold.models.output import Limit as Limit
from slipfold.models.output import Output as Output
from slipfold.models.parameter import Parameter as Parameter
from slipfold.models.parameter import State as State
from slipfold.models.registry import built_in_models as built_in_models
from slipfold.models.registry import model_named as model_named
from slipfold.models.sliding_oscillator import SlidingOscillator as SlidingOscillator
from slipfold.models.system import System as System
