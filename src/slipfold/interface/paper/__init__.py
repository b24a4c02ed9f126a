"""The source paper reproduced: its figures as cases, its claims as checks."""

from slipfold.interface.paper.claims import Claim as Claim
from slipfold.interface.paper.reproduce import Reproduction as Reproduction
from slipfold.interface.paper.reproduce import reproduce as reproduce
