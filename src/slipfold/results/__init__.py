"""Results: labelled, saved and read back, printed and exported."""

from slipfold.results.diagram import Diagram as Diagram
from slipfold.results.diagram import Labelled as Labelled
from slipfold.results.load import load as load
from slipfold.results.locus_diagram import LabelledLocus as LabelledLocus
from slipfold.results.locus_diagram import LocusDiagram as LocusDiagram
from slipfold.results.provenance import Provenance as Provenance
from slipfold.results.responses import Responses as Responses
from slipfold.results.simulation import Simulation as Simulation
from slipfold.results.threshold_map import ThresholdMap as ThresholdMap
