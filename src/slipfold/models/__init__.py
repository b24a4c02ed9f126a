"""Physics: states, parameters, symbolic equations, outputs and limits of validity."""

from slipfold.models.linear_modes import Modes as Modes
from slipfold.models.model import Model as Model
from slipfold.models.output import Limit as Limit
from slipfold.models.output import Output as Output
from slipfold.models.parameter import Parameter as Parameter
from slipfold.models.parameter import State as State
from slipfold.models.registry import built_in_models as built_in_models
from slipfold.models.registry import model_named as model_named
from slipfold.models.sliding_oscillator import SlidingOscillator as SlidingOscillator
