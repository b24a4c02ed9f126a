"""What a result says of its checks: a line of text, and plain data in files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from slipfold.checks.checked import Checked

__all__ = ["checked_attributes", "checked_lines", "checked_record", "read_checked"]


def checked_lines(checked: Checked | None) -> list[str]:
    """Return the sentence, no line if nothing was checked."""
    return [] if checked is None else [str(checked)]


def checked_record(checked: Checked | None) -> dict[str, Any]:
    """Return the item of a record for `json`, nothing if nothing was checked."""
    return {} if checked is None else {"checked": checked.to_json()}


def checked_attributes(checked: Checked | None) -> dict[str, str]:
    """Return the attribute of a saved result, none if nothing was checked."""
    return {} if checked is None else {"checked": json.dumps(checked.to_json())}


def read_checked(attributes: Mapping[str, Any]) -> Checked | None:
    """Return what the attributes of a saved result hold; files of earlier versions lack it."""
    text = attributes.get("checked")
    return None if text is None else Checked.from_json(json.loads(str(text)))
