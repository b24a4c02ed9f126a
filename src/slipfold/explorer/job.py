"""A request on its way from a client to a worker and back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from slipfold.explorer.messages import DiagramRequest, ExportRequest, ViewRequest
from slipfold.explorer.worker import Reply

RANK = {
    "orbit": 0,
    "diagram": 1,
    "simulation": 2,
    "exponents": 2,
    "export": 2,
    "plane": 3,
    "basins": 3,
    "regimes": 3,
}
"""Quick answers first."""

SLOW = ("plane", "basins", "regimes")
"""What takes so long that it must not take all workers."""

OVERTAKEN = 40
"""Later jobs that may go before one of the next rank, so that no job waits for ever."""


class Failing(Protocol):
    """Takes a sentence, and whether the same request may succeed if it is made again."""

    def __call__(self, sentence: str, again: bool = False) -> None:
        """Tell that a job ends without a last reply."""


@dataclass(eq=False)
class Job:
    """A request on its way."""

    request: ViewRequest | ExportRequest  # what is asked for
    # Number of the client, whose jobs go to one worker where possible: it remembers its diagrams
    home: int
    # Takes the replies, and last of all one that is marked so, unless the job is cancelled
    deliver: Callable[[Reply], None]
    fail: Failing  # called if the job ends without a last reply
    number: int = 0
    place: int = 0
    cancelled: bool = False

    @property
    def kind(self) -> str:
        """Kind of the request."""
        return "export" if isinstance(self.request, ExportRequest) else self.request.kind

    @property
    def order(self) -> int:
        """Position in the queue."""
        rank = RANK[self.kind]
        if isinstance(self.request, DiagramRequest) and self.request.slot != "live":
            rank += 1
        return self.place + OVERTAKEN * rank
