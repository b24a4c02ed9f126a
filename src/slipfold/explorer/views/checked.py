"""What was computed again by other means, in a sentence."""

from __future__ import annotations

from typing import Any

from slipfold.checks.checked import Checked


def checked_view(checked: Checked | None) -> dict[str, Any] | None:
    """Return what was checked as plain data: a sentence, and whether all agree."""
    if checked is None or not checked.checks:
        return None
    return {"sentence": str(checked), "agree": checked.agree}
