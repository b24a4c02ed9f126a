"""Rows gathered into columns one by one: in memory while they are few, else on disk."""

from __future__ import annotations

import tempfile
import weakref
from collections.abc import Iterator, Mapping, Sequence
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from slipfold.results.fields import REAL, TEXT, WHOLE, ValueType
from slipfold.studies.works import CaseField

KINDS: dict[str, ValueType] = {"real": REAL, "whole": WHOLE, "text": TEXT}

BLOCK = 512
"""Rows that are put into arrays at once."""

ROOM = 2**22
"""Bytes of all columns above which they go to disk."""


def type_of(item: CaseField) -> Any:
    """Return the type of an array; words are objects, which share what is said often."""
    return object if item.kind == "text" else KINDS[item.kind].type


class Gathered:
    """Columns that grow at their ends; what a row lacks is missing.

    >>> table = Gathered([CaseField("x", "real", ""), CaseField("why", "text", "")])
    >>> table.add({"x": 1.5, "why": "limit"})
    >>> table.add({"why": "limit"})
    >>> {name: column.tolist() for name, column in table.columns().items()}
    {'x': [1.5, nan], 'why': ['limit', 'limit']}
    """

    def __init__(self, items: Sequence[CaseField]) -> None:
        self._items, self._size = items, 0
        self._rows: list[Mapping[str, Any]] = []
        self._words: dict[str, int] = {"": 0}
        self._blocks: dict[str, list[NDArray[Any]]] = {item.name: [] for item in items}
        self._files: dict[str, IO[bytes]] = {}

    def add(self, row: Mapping[str, Any]) -> None:
        """Add a row at the end."""
        self._rows.append(row)
        if len(self._rows) == BLOCK:
            self._put_away()

    def columns(self) -> Mapping[str, NDArray[Any]]:
        """Return the columns, which cannot be changed; no rows can be added after that."""
        self._put_away()
        words = np.array([*self._words], object)
        types = {item.name: _kept_as(item) for item in self._items}
        if self._files:
            spoken = {item.name for item in self._items if item.kind == "text"}
            return _OnDisk(self._files, types, self._size, spoken, words)
        result = {}
        for item in self._items:
            blocks = self._blocks.pop(item.name)
            values = np.concatenate(blocks) if blocks else np.empty(0, types[item.name])
            result[item.name] = words[values] if item.kind == "text" else values
        return result

    def _put_away(self) -> None:
        rows, self._rows = self._rows, []
        if not rows:
            return
        self._size += len(rows)
        for item in self._items:
            values = [KINDS[item.kind].missing if (result := row.get(item.name)) is None else result
                      for row in rows]  # fmt: skip
            if item.kind == "text":
                values = [self._words.setdefault(word, len(self._words)) for word in values]
            self._blocks[item.name].append(np.array(values, _kept_as(item)))
        if self._files or 8 * self._size * len(self._items) > ROOM:
            self._to_disk()

    def _to_disk(self) -> None:
        for name, blocks in self._blocks.items():
            if name not in self._files:
                self._files[name] = tempfile.TemporaryFile()  # noqa: SIM115
            for block in blocks:
                self._files[name].write(block.tobytes())
            blocks.clear()


def _kept_as(item: CaseField) -> Any:
    """Return the type of stored values: numbers for words."""
    return np.int32 if item.kind == "text" else KINDS[item.kind].type


class _OnDisk(Mapping[str, NDArray[Any]]):
    """Columns that are read when they are looked at; the files have no names and go with them."""

    def __init__(
        self,
        files: Mapping[str, IO[bytes]],
        types: Mapping[str, Any],
        size: int,
        spoken: set[str],
        words: NDArray[Any],
    ) -> None:
        self._files, self._types, self._size = files, types, size
        self._spoken, self._words = spoken, words
        for file in files.values():
            file.flush()
            weakref.finalize(self, file.close)

    def __getitem__(self, name: str) -> NDArray[Any]:
        file = self._files[name]
        values: NDArray[Any] = np.memmap(file, self._types[name], "r", 0, (self._size,))
        if name in self._spoken:
            values = self._words[values]
            values.setflags(write=False)
        return values

    def __iter__(self) -> Iterator[str]:
        return iter(self._files)

    def __len__(self) -> int:
        return len(self._files)

    def __reduce__(self) -> tuple[Any, ...]:
        """Files stay where they are: elsewhere there are arrays."""
        return dict, ({name: np.array(values) for name, values in self.items()},)
