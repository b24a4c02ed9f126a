"""Continuation: stepping, test functions, location, normal forms, switching."""

from slipfold.branches.branch import Branch as Branch
from slipfold.branches.branch import End as End
from slipfold.branches.event import Event as Event
from slipfold.branches.progress import Observer as Observer
from slipfold.branches.progress import Progress as Progress
from slipfold.branches.response import trace_response as trace_response
from slipfold.branches.settings import Newton as Newton
from slipfold.branches.settings import Settings as Settings
from slipfold.branches.settings import Steps as Steps
from slipfold.branches.special_point import SpecialPoint as SpecialPoint
