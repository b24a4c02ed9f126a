"""Many motions at once, known at the start of every forcing period."""

from slipfold.flow.strobes.strobe_many import StrobePoints as StrobePoints
from slipfold.flow.strobes.strobe_many import strobe_many as strobe_many
