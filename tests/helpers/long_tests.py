"""Families of which a test shows some members in every run, and all with the long tests."""

import pytest


def all_but_often_long(members, often):
    """Mark all members of a family as long, but those that run often."""
    return [m if m in often else pytest.param(m, marks=pytest.mark.long) for m in members]
