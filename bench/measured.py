"""What one run of the benchmarks has measured."""

from typing import Any, NamedTuple

from processes import Usage


class Measured(NamedTuple):
    """All that was measured; what was not asked for is empty."""

    records: dict[str, dict[str, Any]]
    absent: dict[str, str]
    first: list[Usage]
    cached: list[Usage]
    paper: list[Usage]
    loci: dict[str, dict[str, Any]]
    map: dict[str, Any]
    systems: dict[str, dict[str, dict[str, Any]]]
    cycles: dict[str, dict[str, dict[str, Any]]]
    size: dict[str, Any]
    ensemble: dict[str, Any]
    stick: dict[str, dict[str, Any]]
    study: dict[str, Any]
    batch: dict[str, dict[str, Any]]
    after_the_hopf: dict[str, Any]
