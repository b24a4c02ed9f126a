"""Results: labelled, saved and read back, printed and exported."""

from slipfold.results.bifurcation_set import bifurcation_set as bifurcation_set
from slipfold.results.diagram import Diagram as Diagram
from slipfold.results.diagram import Labelled as Labelled
from slipfold.results.load import load as load
from slipfold.results.locus import locus as locus
from slipfold.results.locus_diagram import LabelledLocus as LabelledLocus
from slipfold.results.locus_diagram import LocusDiagram as LocusDiagram
from slipfold.results.provenance import Provenance as Provenance
from slipfold.results.response import response as response
from slipfold.results.simulation import Simulation as Simulation
from slipfold.results.simulation import simulate as simulate
from slipfold.results.threshold_map import threshold_map as threshold_map
from slipfold.results.threshold_result import ThresholdMap as ThresholdMap
