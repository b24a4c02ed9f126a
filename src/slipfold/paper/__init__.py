"""The source paper reproduced: its figures as cases, its claims as checks."""

from slipfold.paper.claims import Claim as Claim
from slipfold.paper.reproduce import Reproduction as Reproduction
from slipfold.paper.reproduce import reproduce as reproduce
