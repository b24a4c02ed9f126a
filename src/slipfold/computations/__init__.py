"""What people call to compute: input checked, computed, checked again, made a result."""

from slipfold.computations.bifurcation_set import bifurcation_set as bifurcation_set
from slipfold.computations.locus import locus as locus
from slipfold.computations.response import response as response
from slipfold.computations.responses import CaseProgress as CaseProgress
from slipfold.computations.responses import responses as responses
from slipfold.computations.simulate import simulate as simulate
from slipfold.computations.threshold_map import threshold_map as threshold_map
