"""How much a client may ask for: so that no page can exhaust the machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from time import monotonic
from types import MappingProxyType


@dataclass(frozen=True)
class Limits:
    """Bounds on what clients ask for."""

    request_bytes: int = 64 * 1024  # largest request
    # Requests of one client, in the long run; a slider that is dragged makes sixty
    requests_per_second: float = 120.0
    burst: int = 240  # requests of one client at once
    clients: int = 64  # open pages
    unsent_bytes: int = 64 * 2**20  # answers that wait for a slow client; beyond that it is let go
    # Time that a worker may take over a request, by kind
    seconds: Mapping[str, float] = field(
        default_factory=lambda: MappingProxyType(
            {
                "diagram": 60.0,
                "orbit": 30.0,
                "simulation": 120.0,
                "exponents": 300.0,
                "plane": 600.0,
                "basins": 600.0,
                "regimes": 600.0,
                "export": 120.0,
            }
        )
    )
    worker_bytes: int = 2**30  # memory beyond which a worker is replaced once it is idle


class Allowance:
    """How many requests a client has left; it grows with time.

    By `per_second`, up to `most`; `clock` tells the time in s.

    >>> allowance = Allowance(1.0, 2, clock=lambda: 0.0)
    >>> [allowance.take() for _ in range(3)]
    [True, True, False]
    """

    def __init__(
        self, per_second: float, most: int, clock: Callable[[], float] = monotonic
    ) -> None:
        self._per_second = per_second
        self._most = most
        self._clock = clock
        self._left = float(most)
        self._then = clock()

    def take(self) -> bool:
        """Use one up; False if there is none."""
        now = self._clock()
        self._left = min(self._left + (now - self._then) * self._per_second, self._most)
        self._then = now
        if self._left < 1:
            return False
        self._left -= 1
        return True
