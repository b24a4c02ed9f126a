"""Continuation: stepping, test functions, location, normal forms, switching."""

from slipfold.branches.branch import Branch as Branch
from slipfold.branches.event import Event as Event
from slipfold.branches.response import trace_response as trace_response
from slipfold.branches.settings import Settings as Settings
from slipfold.branches.special_point import SpecialPoint as SpecialPoint
from slipfold.continuation.end import End as End
from slipfold.continuation.settings import Newton as Newton
from slipfold.continuation.settings import Steps as Steps
