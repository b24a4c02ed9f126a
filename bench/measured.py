"""What one run of the benchmarks has measured."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from processes import Usage

Records = dict[str, dict[str, Any]]


@dataclass(frozen=True)
class Measured:
    """All that was measured, by part; what was not asked for is not there.

    `records` has what each program did in a part, by its name; `usages` the runs of a command;
    `absent` why a program did not end in a part; `failed` why slipfold did not, by part.
    """

    records: Mapping[str, Records] = field(default_factory=dict)
    usages: Mapping[str, list[Usage]] = field(default_factory=dict)
    absent: Mapping[tuple[str, str], str] = field(default_factory=dict)
    failed: Mapping[str, str] = field(default_factory=dict)

    def of(self, part: str) -> Records:
        """Return the records of a part."""
        return self.records.get(part, {})

    def several(self, parts: Mapping[str, Any]) -> dict[str, Records]:
        """Return the records of some parts, by part, as far as they were measured."""
        return {name: self.records[name] for name in parts if name in self.records}

    def ours(self, part: str) -> dict[str, Any]:
        """Return what slipfold did in a part."""
        return self.of(part).get("slipfold", {})
