"""Time: compiled flows, their derivatives, batches of them, and simulation."""

from slipfold.flow.flow import Flow as Flow
from slipfold.flow.flow import flow_of as flow_of
from slipfold.flow.guarded_flow import Stop as Stop
from slipfold.flow.settlement import Settlement as Settlement
from slipfold.flow.simulate import simulate as simulate
from slipfold.flow.trajectory import Trajectory as Trajectory
