"""Figures, one function a kind of figure; each draws into the axes it is given."""

from slipfold.plots.contact_path import draw_path as draw_path
from slipfold.plots.contact_path import draw_track as draw_track
from slipfold.plots.friction_loops import draw_friction_force as draw_friction_force
from slipfold.plots.friction_loops import draw_hysteresis as draw_hysteresis
from slipfold.plots.loci import draw_loci as draw_loci
from slipfold.plots.phase import draw_phase as draw_phase
from slipfold.plots.response import draw_family as draw_family
from slipfold.plots.response import draw_response as draw_response
from slipfold.plots.spectrum import draw_spectrum as draw_spectrum
from slipfold.plots.studies.study import draw_study as draw_study
from slipfold.plots.style import figure_style as figure_style
from slipfold.plots.threshold_map import draw_threshold_map as draw_threshold_map
from slipfold.plots.timeline import draw_timeline as draw_timeline
from slipfold.plots.timeseries import draw_timeseries as draw_timeseries
