"""Figures, one function a kind of figure; each draws into the axes it is given."""

from slipfold.plots.contacts import draw_friction_force as draw_friction_force
from slipfold.plots.contacts import draw_hysteresis as draw_hysteresis
from slipfold.plots.contacts import draw_path as draw_path
from slipfold.plots.contacts import draw_timeline as draw_timeline
from slipfold.plots.contacts import draw_track as draw_track
from slipfold.plots.loci import draw_loci as draw_loci
from slipfold.plots.maps import draw_study as draw_study
from slipfold.plots.maps import draw_threshold_map as draw_threshold_map
from slipfold.plots.response import draw_family as draw_family
from slipfold.plots.response import draw_response as draw_response
from slipfold.plots.style import figure_style as figure_style
from slipfold.plots.trajectories import draw_phase as draw_phase
from slipfold.plots.trajectories import draw_spectrum as draw_spectrum
from slipfold.plots.trajectories import draw_timeseries as draw_timeseries
