"""How often angles turn round, in words."""

from __future__ import annotations

from collections.abc import Mapping


def turns_text(turns: Mapping[str, int]) -> str:
    """Say how often angles turn round in a period; empty where none does.

    >>> turns_text({"phi": -1, "psi": 0, "theta": 2})
    'phi turns round once, backwards; theta turns round 2 times'
    """
    return "; ".join(
        f"{name} turns round {'once' if abs(count) == 1 else f'{abs(count)} times'}"
        f"{', backwards' if count < 0 else ''}"
        for name, count in turns.items()
        if count
    )
